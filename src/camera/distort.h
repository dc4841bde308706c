#pragma once
#include <Eigen/Core>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Coefficients of the longest of OpenCV's models.
inline constexpr int kMaxDistortion = 12;

/// All coefficients in OpenCV's order; those a model lacks are 0.
using Coefficients = Eigen::Matrix<double, kMaxDistortion, 1>;
Coefficients coefficients(const Camera& camera);

/// A point of the unit plane after the lens, with its derivatives.
struct Distorted {
  Eigen::Vector2d xy;
  Eigen::Matrix2d d_xy;  ///< by the undistorted point
  Eigen::Matrix<double, 2, kMaxDistortion> d_coefficients;
};

/// docs/formulation/camera.md, eq. 1.
Eigen::Vector2d distort(const Coefficients& k, const Eigen::Vector2d& xy);
Distorted distort_with_jacobians(const Coefficients& k, const Eigen::Vector2d& xy);

/// The derivative by the undistorted point alone.
Eigen::Matrix2d distort_jacobian(const Coefficients& k, const Eigen::Vector2d& xy);

/// r -> r N(r^2) / D(r^2): the radial part alone, in distance from the axis.
double radial(const Coefficients& k, double r);

/// Smallest r > 0 at which radial() stops growing or has a pole; infinity when there is none.
double radial_fold(const Coefficients& k);

/// True only when radial() grows, without a pole, all the way to `r`; a bound by signs, so false means "look
/// closer". Far cheaper than radial_fold().
bool surely_grows_to(const Coefficients& k, double r);

}  // namespace furrow::camera
