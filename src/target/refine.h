#pragma once
#include <Eigen/Core>
#include <optional>

#include "furrow/image/image.h"

namespace furrow::target {

/// A corner to sub-pixel, with the covariance that the picture's noise gives it.
struct RefinedCorner {
  Eigen::Vector2d px;
  double sigma_px = 0.0;  ///< per coordinate: sqrt(trace / 2) of the covariance
};

/// The point at which all gradients within `half_width_px` are at right angles to the line to it (Foerstner
/// and Guelch 1987; the criterion of OpenCV's cornerSubPix), by Gauss-weighted least squares, repeated to
/// 1e-3 px. Nothing when it leaves the window, the picture, or finds an edge only. `noise_grey`: standard
/// deviation of a pixel.
std::optional<RefinedCorner> refine_corner(const Image& grey, const Eigen::Vector2d& start_px,
                                           double half_width_px, double noise_grey);

/// Standard deviation of the pixel noise, grey levels: median of the Laplacian mask of Immerkaer (1996), not
/// under the rounding to whole levels.
double noise_grey(const Image& grey);

}  // namespace furrow::target
