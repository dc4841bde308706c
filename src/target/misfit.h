#pragma once
#include <Eigen/Core>
#include <vector>

namespace furrow::target {

/// How far each point lies from where the homography of all, one coefficient of distortion about the
/// picture's middle and a smooth rest put it, in units of `board`. The rest is a cubic in the board's own
/// coordinates (less with few points): it takes up what other lenses and a bent board do; a point that
/// belongs elsewhere stays out. Empty when no plane fits.
std::vector<double> plane_misfit(const std::vector<Eigen::Vector2d>& board,
                                 const std::vector<Eigen::Vector2d>& px, int width, int height);

}  // namespace furrow::target
