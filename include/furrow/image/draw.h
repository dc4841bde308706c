#pragma once
#include <array>
#include <cstdint>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "furrow/image/image.h"

namespace furrow::image {

using Rgb = std::array<std::uint8_t, 3>;

/// A line through pixels, with a dark rim so that it stays visible on leaves, soil and sky.
struct InkLine {
  std::vector<Eigen::Vector2d> points_px;
  Rgb colour{};
  double width_px = 2.0;
  bool has_arrow = false;  ///< at the last point
};

/// A line of ASCII text with its base line's start at `at_px`, on a dark ground.
struct InkText {
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();
  std::string text;
  double height_px = 14.0;  ///< of a capital letter
  Rgb colour = {255, 255, 255};
};

/// The picture with lines, then texts over it: fast enough for video, coarser than a figure.
Image inked(Image picture, const std::vector<InkLine>& lines, const std::vector<InkText>& texts);

}  // namespace furrow::image
