#include "rows/green_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace furrow::rows {
namespace {

/// Shares from 0.1 to 0.7 in equal steps: all that leaves, soil, straw and sky have.
int chroma_level(int channel, float per_sum) {
  constexpr float kLow = 0.1F, kHigh = 0.7F, kPerShare = kChromaLevels / (kHigh - kLow);
  const float level = (static_cast<float>(channel) * per_sum - kLow) * kPerShare;
  return std::clamp(static_cast<int>(level), 0, kChromaLevels - 1);
}

cv::Mat reduced(const Image& picture, int width, int height) {
  const cv::Mat full(picture.height, picture.width, CV_8UC(picture.channels),
                     const_cast<std::uint8_t*>(picture.data.data()));
  if (width == picture.width && height == picture.height) return full;
  // By halves first, as far as they come out even: averaging four pixels is an order of magnitude faster than
  // averaging areas with parts of pixels.
  cv::Mat small = full;
  while (small.cols % 2 == 0 && small.rows % 2 == 0 && small.cols >= 2 * width && small.rows >= 2 * height) {
    cv::Mat half;
    cv::resize(small, half, {small.cols / 2, small.rows / 2}, 0, 0, cv::INTER_AREA);
    small = half;
  }
  if (small.cols == width && small.rows == height) return small;
  cv::Mat result;
  cv::resize(small, result, {width, height}, 0, 0, cv::INTER_AREA);
  return result;
}

}  // namespace

GreenMap green_map(const Image& picture, double most_pixels) {
  const double pixels = static_cast<double>(picture.width) * picture.height;
  const double shrink = std::min(1.0, std::sqrt(most_pixels / pixels));
  GreenMap map;
  map.width = std::max(1, static_cast<int>(std::lround(picture.width * shrink)));
  map.height = std::max(1, static_cast<int>(std::lround(picture.height * shrink)));
  map.scale_u = static_cast<double>(picture.width) / map.width;
  map.scale_v = static_cast<double>(picture.height) / map.height;
  map.value.assign(static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height), 0.0F);
  if (picture.channels != 3) return map;
  map.light.resize(map.value.size());
  map.chroma.resize(map.value.size());
  const cv::Mat small = reduced(picture, map.width, map.height);
  std::array<cv::Mat, 3> planes;
  for (int v = 0; v < map.height; ++v) {
    cv::split(small.row(v), planes.data());
    const std::uint8_t *red = planes[0].ptr(), *green = planes[1].ptr(), *blue = planes[2].ptr();
    float* out = map.value.data() + static_cast<std::ptrdiff_t>(v) * map.width;
    std::uint16_t* chroma = map.chroma.data() + static_cast<std::ptrdiff_t>(v) * map.width;
    std::uint16_t* light = map.light.data() + static_cast<std::ptrdiff_t>(v) * map.width;
    for (int u = 0; u < map.width; ++u) {
      const int sum = red[u] + green[u] + blue[u];
      const float per_sum = 1.0F / (static_cast<float>(sum) + kDarkLevel);
      light[u] = static_cast<std::uint16_t>(sum);
      out[u] = static_cast<float>(3 * green[u] - sum) * per_sum;
      chroma[u] = static_cast<std::uint16_t>(chroma_level(red[u], per_sum) * kChromaLevels +
                                             chroma_level(green[u], per_sum));
    }
  }
  return map;
}

}  // namespace furrow::rows
