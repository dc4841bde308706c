#include "furrow/calib/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <limits>

#include "calib/view_information.h"
#include "furrow/camera/compare.h"

namespace furrow::calib {

namespace {

using LensAndDrift = Eigen::Matrix<double, 2, Eigen::Dynamic>;

/// Derivative of where a point projects by (intrinsics, turn, shift), for a point seen at `px` from
/// `distance_m`.
std::optional<LensAndDrift> by_lens_and_drift(const Calibration& calibration, const Eigen::Vector2d& px,
                                              double distance_m) {
  const Camera& camera = calibration.camera;
  const Eigen::Index n = camera.covariance.rows();
  if (n == 0 || calibration.drift_covariance.rows() != n + 6 || !(distance_m > 0.0)) return std::nullopt;
  const auto way = camera::unproject_ray(camera, px);
  if (!way) return std::nullopt;
  const bool finite = std::isfinite(distance_m);
  const Eigen::Vector3d x = finite ? Eigen::Vector3d(*way * distance_m) : *way;
  const auto seen = camera::project_with_jacobians(camera, x);
  if (!seen) return std::nullopt;
  LensAndDrift by(2, n + 6);
  by.leftCols(n) = seen->by_all_intrinsics(n);
  for (int i = 0; i < 3; ++i) by.col(n + i) = seen->d_point * Eigen::Vector3d::Unit(i).cross(x);
  // A direction does not move when the boards shift.
  if (finite) {
    by.rightCols<3>() = seen->d_point;
  } else {
    by.rightCols<3>().setZero();
  }
  return by;
}

/// `at(px)` at the middle of every cell.
template <class At>
UncertaintyMap map_over(const Camera& camera, int columns, int rows, const At& at) {
  check(columns > 0 && rows > 0, "uncertainty map: a grid needs cells");
  UncertaintyMap out{columns, rows, {}};
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector2d px((i + 0.5) * camera.width / columns - 0.5,
                               (j + 0.5) * camera.height / rows - 0.5);
      out.values.push_back(at(px).value_or(std::numeric_limits<double>::quiet_NaN()));
    }
  }
  return out;
}

}  // namespace

std::optional<Eigen::Matrix2d> projection_covariance(const Calibration& calibration,
                                                     const Eigen::Vector2d& px, double distance_m) {
  const auto by = by_lens_and_drift(calibration, px, distance_m);
  if (!by) return std::nullopt;
  return Eigen::Matrix2d(*by * calibration.drift_covariance * by->transpose());
}

UncertaintyMap projection_sigma_map(const Calibration& calibration, double distance_m, int columns,
                                    int rows) {
  return map_over(calibration.camera, columns, rows, [&](const Eigen::Vector2d& px) {
    return projection_sigma_px(calibration, px, distance_m);
  });
}

std::optional<double> height_error_percent_at(const Calibration& calibration, const Eigen::Vector2d& px,
                                              double distance_m) {
  const Camera& camera = calibration.camera;
  const Eigen::Vector2d middle(0.5 * (camera.width - 1), 0.5 * (camera.height - 1));
  // Two pixels that coincide have no distance; this near the limit is reached.
  const double nearest_px = 0.02 * camera.width;
  Eigen::Vector2d way = px - middle;
  if (way.norm() < nearest_px) way = Eigen::Vector2d(nearest_px, 0.0);
  const auto here = by_lens_and_drift(calibration, middle + way, distance_m),
             there = by_lens_and_drift(calibration, middle, distance_m);
  if (!here || !there) return std::nullopt;
  const Eigen::RowVectorXd by = way.normalized().transpose() * (*here - *there);
  constexpr double kPercent = 100.0;
  return kPercent * std::sqrt(std::max(0.0, (by * calibration.drift_covariance * by.transpose()).value())) /
         way.norm();
}

UncertaintyMap height_error_map(const Calibration& calibration, double distance_m, int columns, int rows) {
  return map_over(calibration.camera, columns, rows, [&](const Eigen::Vector2d& px) {
    return height_error_percent_at(calibration, px, distance_m);
  });
}

std::optional<double> projection_sigma_px(const Calibration& calibration, const Eigen::Vector2d& px,
                                          double distance_m) {
  const auto covariance = projection_covariance(calibration, px, distance_m);
  if (!covariance) return std::nullopt;
  return std::sqrt(
      std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(*covariance).eigenvalues()[1]));
}

Eigen::VectorXd focal_by_intrinsics(const Camera& camera) {
  // The mean focal length on the axis: 1/2 each by fx and fy, and a splined lens's knots around the axis, in
  // which it is linear.
  Eigen::VectorXd by = Eigen::VectorXd::Zero(camera::intrinsics(camera).size());
  by.head<2>().setConstant(0.5);
  if (camera.model != camera::CameraModel::splined_stereographic) return by;
  const double mean_px = camera::focal_on_axis_px(camera).mean();
  const auto at = camera::project_with_jacobians(camera, Eigen::Vector3d::UnitZ());
  for (Eigen::Index i = 4; at && i < at->d_intrinsics.cols(); ++i) {
    const int place = at->place[static_cast<std::size_t>(i)];
    Camera moved = camera;
    moved.distortion[static_cast<std::size_t>(place - 4)] += 1.0;
    by[place] = camera::focal_on_axis_px(moved).mean() - mean_px;
  }
  return by;
}

std::optional<double> height_error_percent(const Camera& camera) {
  if (camera.covariance.rows() < 2) return std::nullopt;
  const Eigen::VectorXd by = focal_by_intrinsics(camera);
  constexpr double kPercent = 100.0;
  return kPercent * std::sqrt(std::max(0.0, by.dot(camera.covariance * by))) /
         camera::focal_on_axis_px(camera).mean();
}

std::optional<double> picture_sigma_px(const Camera& camera) {
  if (camera.covariance.rows() < 2) return std::nullopt;
  const Eigen::MatrixXd by = camera::picture_change(camera);
  if (by.rows() == 0) return std::nullopt;
  const double sum = (by * camera.covariance).cwiseProduct(by).sum();
  return std::sqrt(std::max(0.0, 2.0 * sum / static_cast<double>(by.rows())));
}

}  // namespace furrow::calib
