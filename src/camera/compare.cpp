#include "furrow/camera/compare.h"

#include <cmath>
#include <Eigen/Dense>
#include <limits>

#include "furrow/geom/hull.h"

namespace furrow::camera {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Eigen::Matrix3d rotation(const Eigen::Vector3d& vector_rad) {
  const double angle = vector_rad.norm();
  if (angle == 0.0) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector_rad / angle).toRotationMatrix();
}

/// d(px) / d(small turn of the ray): J_point [-ray]x.
Eigen::Matrix<double, 2, 3> by_turn(const Projection& seen, const Eigen::Vector3d& ray) {
  Eigen::Matrix<double, 2, 3> out;
  for (int i = 0; i < 3; ++i) out.col(i) = seen.d_point * Eigen::Vector3d::Unit(i).cross(ray);
  return out;
}

/// A place of the grid that both cameras can see.
struct Place {
  std::size_t index;
  Eigen::Vector2d px_in_a;
  Eigen::Vector3d ray;
};

/// Turn that brings b's pixels nearest to a's, by Gauss-Newton.
Eigen::Matrix3d fit_turn(const Camera& b, const std::vector<Place>& places) {
  Eigen::Matrix3d b_from_a = Eigen::Matrix3d::Identity();
  constexpr int kRounds = 20;
  constexpr double kConverged_rad = 1e-12;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Place& place : places) {
      const Eigen::Vector3d ray = b_from_a * place.ray;
      const auto seen = project_with_jacobians(b, ray);
      if (!seen) continue;
      const Eigen::Matrix<double, 2, 3> j = by_turn(*seen, ray);
      normal += j.transpose() * j;
      right += j.transpose() * (place.px_in_a - seen->px);
    }
    const Eigen::Vector3d step = normal.ldlt().solve(right);
    if (!step.allFinite()) return Eigen::Matrix3d::Identity();
    b_from_a = rotation(step) * b_from_a;
    if (step.norm() < kConverged_rad) break;
  }
  return b_from_a;
}

/// Takes out of the derivatives `by` what the three columns of `turn` can do as well.
void take_turn_out(const Eigen::MatrixXd& turn, Eigen::MatrixXd& by) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(turn);
  const Eigen::MatrixXd q = qr.householderQ() * Eigen::MatrixXd::Identity(turn.rows(), turn.cols());
  by -= q * (q.transpose() * by).eval();
}

/// Root mean square that the covariances predict for the differences left by the best turn (eq. 5 of
/// docs/formulation/camera.md).
double expected_rms_px(const Camera& a, const Camera& b, const std::vector<Place>& places) {
  const Eigen::Index n = a.covariance.rows(), m = b.covariance.rows();
  if (n == 0 || m == 0) return kNan;
  const auto rows = static_cast<Eigen::Index>(2 * places.size());
  Eigen::MatrixXd turn(rows, 3), by_a(rows, n), by_b(rows, m);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto in_a = project_with_jacobians(a, places[i].ray);
    const auto in_b = project_with_jacobians(b, places[i].ray);
    if (!in_a || !in_b) return kNan;
    turn.middleRows<2>(static_cast<Eigen::Index>(2 * i)) = by_turn(*in_a, places[i].ray);
    by_a.middleRows<2>(static_cast<Eigen::Index>(2 * i)) = in_a->by_all_intrinsics(n);
    by_b.middleRows<2>(static_cast<Eigen::Index>(2 * i)) = in_b->by_all_intrinsics(m);
  }
  take_turn_out(turn, by_a);
  take_turn_out(turn, by_b);
  const double sum =
      (by_a * a.covariance).cwiseProduct(by_a).sum() + (by_b * b.covariance).cwiseProduct(by_b).sum();
  return std::sqrt(std::max(0.0, sum) / static_cast<double>(places.size()));
}

}  // namespace

Eigen::MatrixXd picture_change(const Camera& camera, int columns, int rows) {
  check(columns > 1 && rows > 1, "picture_change: a grid needs two columns and rows");
  const Eigen::Index n = intrinsics(camera).size();
  Eigen::MatrixXd by(2 * columns * rows, n), turn(2 * columns * rows, 3);
  Eigen::Index used = 0;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const auto ray = unproject_ray(
          camera, {(i + 0.5) * camera.width / columns - 0.5, (j + 0.5) * camera.height / rows - 0.5});
      const auto seen = ray ? project_with_jacobians(camera, *ray) : std::nullopt;
      if (!seen) continue;
      by.middleRows<2>(used) = seen->by_all_intrinsics(n);
      turn.middleRows<2>(used) = by_turn(*seen, *ray);
      used += 2;
    }
  }
  by.conservativeResize(used, n);
  if (used < 3) return by;
  take_turn_out(turn.topRows(used), by);
  return by;
}

Result<CameraDifference> compare_cameras(const Camera& a, const Camera& b, int columns, int rows,
                                         const std::vector<Eigen::Vector2d>& within) {
  check(columns > 1 && rows > 1, "compare_cameras: a grid needs two columns and rows");
  FURROW_DO(validate(a));
  FURROW_DO(validate(b));
  if (a.width != b.width || a.height != b.height) {
    return Error{"picture_sizes_differ", "camera",
                 std::to_string(a.width) + "x" + std::to_string(a.height) + " and " +
                     std::to_string(b.width) + "x" + std::to_string(b.height),
                 "two cameras for pictures of one size", ""};
  }
  CameraDifference out;
  out.columns = columns;
  out.rows = rows;
  std::vector<Place> places;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector2d px((i + 0.5) * a.width / columns - 0.5, (j + 0.5) * a.height / rows - 0.5);
      out.at_px.push_back(px);
      if (!within.empty() && !geom::is_inside(within, px)) continue;
      const auto ray = unproject_ray(a, px);
      if (ray && unproject_ray(b, px)) places.push_back({out.at_px.size() - 1, px, *ray});
    }
  }
  out.difference_px.assign(out.at_px.size(), Eigen::Vector2d::Constant(kNan));
  out.compared_share = static_cast<double>(places.size()) / static_cast<double>(out.at_px.size());
  if (places.size() < 3) {
    return Error{"cameras_do_not_meet", "camera",
                 "fewer than 3 places of the picture with a ray in both cameras", "", ""};
  }
  const Eigen::Matrix3d b_from_a = fit_turn(b, places);
  const Eigen::AngleAxisd turn(b_from_a);
  out.b_from_a_rad = turn.angle() * turn.axis();
  double squared = 0.0;
  for (const Place& place : places) {
    const auto px = project(b, b_from_a * place.ray);
    if (!px) continue;
    out.difference_px[place.index] = *px - place.px_in_a;
    squared += out.difference_px[place.index].squaredNorm();
    out.mean_px += out.difference_px[place.index].norm() / static_cast<double>(places.size());
    out.largest_px = std::max(out.largest_px, out.difference_px[place.index].norm());
  }
  out.rms_px = std::sqrt(squared / static_cast<double>(places.size()));
  out.expected_rms_px = expected_rms_px(a, b, places);
  return out;
}

}  // namespace furrow::camera
