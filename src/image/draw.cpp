#include "furrow/image/draw.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <opencv2/imgproc.hpp>

#include "image/mat.h"

namespace furrow::image {
namespace {

constexpr int kShift = 4;  // sixteenths of a pixel

cv::Scalar scalar(const Rgb& colour) {
  return {static_cast<double>(colour[0]), static_cast<double>(colour[1]), static_cast<double>(colour[2])};
}

/// Coordinates far outside wrap around in OpenCV's integers; nothing there is visible.
cv::Point fixed(const Eigen::Vector2d& px) {
  constexpr double kFar = 1e5;  // px
  const auto one = [&](double v) {
    return static_cast<int>(std::lround(std::clamp(v, -kFar, kFar) * (1 << kShift)));
  };
  return {one(px.x()), one(px.y())};
}

void stroke(cv::Mat& mat, const InkLine& line, const cv::Scalar& colour, int width) {
  for (std::size_t i = 1; i < line.points_px.size(); ++i)
    cv::line(mat, fixed(line.points_px[i - 1]), fixed(line.points_px[i]), colour, width, cv::LINE_AA, kShift);
  if (!line.has_arrow || line.points_px.size() < 2) return;
  const Eigen::Vector2d tip = line.points_px.back(), back = line.points_px[line.points_px.size() - 2] - tip;
  if (!(back.norm() > 1.0)) return;
  const double length = std::min(6.0 * line.width_px, back.norm());
  for (const double turn : {0.45, -0.45})
    cv::line(mat, fixed(tip), fixed(tip + Eigen::Rotation2Dd(turn) * back.normalized() * length), colour,
             width, cv::LINE_AA, kShift);
}

void write(cv::Mat& mat, const InkText& text) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  constexpr double kCapitalPx = 21.0;  // of that font at scale 1
  const double scale = text.height_px / kCapitalPx;
  const int thickness = std::max(1, static_cast<int>(std::lround(text.height_px / 10.0)));
  const cv::Point at(static_cast<int>(std::lround(text.at_px.x())),
                     static_cast<int>(std::lround(text.at_px.y())));
  int below = 0;
  const cv::Size size = cv::getTextSize(text.text, kFont, scale, thickness, &below);
  const int air = static_cast<int>(std::lround(0.4 * text.height_px));
  const cv::Rect ground =
      cv::Rect(at.x - air, at.y - size.height - air, size.width + 2 * air, size.height + below + 2 * air) &
      cv::Rect(0, 0, mat.cols, mat.rows);
  if (!ground.empty()) mat(ground) *= 0.35;
  cv::putText(mat, text.text, at, kFont, scale, scalar(text.colour), thickness, cv::LINE_AA);
}

}  // namespace

Image inked(Image picture, const std::vector<InkLine>& lines, const std::vector<InkText>& texts) {
  check(picture.channels == 3, "inked: a colour picture");
  cv::Mat mat = view(picture);
  for (const InkLine& line : lines) {
    const int width = std::max(1, static_cast<int>(std::lround(line.width_px)));
    stroke(mat, line, {16, 16, 16}, width + 2);
    stroke(mat, line, scalar(line.colour), width);
  }
  for (const InkText& text : texts) write(mat, text);
  return picture;
}

}  // namespace furrow::image
