#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/image/image.h"

namespace furrow::image {

/// A picture of width x height whose pixel i (row by row) is the source's at `from_px[i]`, bicubic; black
/// where that is not finite or lies outside the source.
Image remap(const Image& source, int width, int height, const std::vector<Eigen::Vector2d>& from_px);

}  // namespace furrow::image
