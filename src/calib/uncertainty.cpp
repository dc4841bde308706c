#include "furrow/calib/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>

namespace furrow::calib {

std::optional<Eigen::Matrix2d> projection_covariance(const Calibration& calibration,
                                                     const Eigen::Vector2d& px, double distance_m) {
  const Camera& camera = calibration.camera;
  const Eigen::Index n = camera.covariance.rows();
  if (n == 0 || calibration.drift_covariance.rows() != n + 6 || !(distance_m > 0.0)) return std::nullopt;
  const auto way = camera::unproject_ray(camera, px);
  if (!way) return std::nullopt;
  const bool finite = std::isfinite(distance_m);
  const Eigen::Vector3d x = finite ? Eigen::Vector3d(*way * distance_m) : *way;
  const auto seen = camera::project_with_jacobians(camera, x);
  if (!seen) return std::nullopt;
  Eigen::Matrix<double, 2, Eigen::Dynamic> by(2, n + 6);
  by.leftCols(n) = seen->by_all_intrinsics(n);
  for (int i = 0; i < 3; ++i) by.col(n + i) = seen->d_point * Eigen::Vector3d::Unit(i).cross(x);
  // A direction does not move when the boards shift.
  if (finite) {
    by.rightCols<3>() = seen->d_point;
  } else {
    by.rightCols<3>().setZero();
  }
  return Eigen::Matrix2d(by * calibration.drift_covariance * by.transpose());
}

std::optional<double> projection_sigma_px(const Calibration& calibration, const Eigen::Vector2d& px,
                                          double distance_m) {
  const auto covariance = projection_covariance(calibration, px, distance_m);
  if (!covariance) return std::nullopt;
  return std::sqrt(
      std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(*covariance).eigenvalues()[1]));
}

std::optional<double> height_error_percent(const Camera& camera) {
  if (camera.covariance.rows() < 2) return std::nullopt;
  constexpr double kPercent = 100.0;
  const double mean_px = 0.5 * (camera.fx + camera.fy);
  const double variance =
      0.25 * (camera.covariance(0, 0) + camera.covariance(1, 1) + 2.0 * camera.covariance(0, 1));
  return kPercent * std::sqrt(std::max(0.0, variance)) / mean_px;
}

}  // namespace furrow::calib
