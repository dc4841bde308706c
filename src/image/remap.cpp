#include "furrow/image/remap.h"

#include <opencv2/imgproc.hpp>

namespace furrow::image {

Image remap(const Image& source, int width, int height, const std::vector<Eigen::Vector2d>& from_px) {
  Image out = make_image(width, height, source.channels);
  check(from_px.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
        "remap: one place a pixel");
  cv::Mat map(height, width, CV_32FC2);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Eigen::Vector2d& from = from_px[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                                            static_cast<std::size_t>(u)];
      const bool inside = from.x() >= -0.5 && from.y() >= -0.5 && from.x() <= source.width - 0.5 &&
                          from.y() <= source.height - 0.5;
      constexpr float kFarOutside = -1e4F;
      map.at<cv::Vec2f>(v, u) = inside ? cv::Vec2f(static_cast<float>(from.x()), static_cast<float>(from.y()))
                                       : cv::Vec2f(kFarOutside, kFarOutside);
    }
  }
  const int type = source.channels == 3 ? CV_8UC3 : CV_8UC1;
  // OpenCV takes no const data; it only reads.
  const cv::Mat from(source.height, source.width, type, const_cast<std::uint8_t*>(source.data.data()));
  cv::Mat to(height, width, type, out.data.data());
  // Half a pixel beyond the border still belongs to the border's pixel.
  cv::remap(from, to, map, cv::noArray(), cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      if (map.at<cv::Vec2f>(v, u)[0] < -1.0F) std::fill_n(out.at(u, v), source.channels, std::uint8_t{0});
    }
  }
  return out;
}

}  // namespace furrow::image
