#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <numbers>

#include "calib/round.h"

namespace furrow::calib {
namespace {

/// Largest |x| and |y| on the stereographic plane that the picture reaches; pixels without a ray, as in the
/// dark corners of a circular picture, are left out.
Eigen::Vector2d stereographic_reach(const Camera& camera) {
  Eigen::Vector2d reach = Eigen::Vector2d::Zero();
  // Nearer to straight behind than this (155 degrees off) the plane has no end.
  constexpr double kFarthestZ = -0.9;
  constexpr int kPlaces = 32;
  for (int j = 0; j <= kPlaces; ++j) {
    for (int i = 0; i <= kPlaces; ++i) {
      const auto ray = camera::unproject_ray(
          camera, {(camera.width - 1.0) * i / kPlaces, (camera.height - 1.0) * j / kPlaces});
      if (ray && ray->z() > kFarthestZ)
        reach = reach.cwiseMax((ray->head<2>() * 2.0 / (1.0 + ray->z())).cwiseAbs());
    }
  }
  return reach;
}

/// A grid of square meshes over all that the picture sees, with about nine corners to a knot.
camera::SplineGrid grid_for(const Camera& seen, std::size_t corners) {
  const Eigen::Vector2d reach = stereographic_reach(seen).cwiseMax(1e-3);
  constexpr double kCornersPerKnot = 9.0, kFewest = 8.0, kMost = 16.0, kMargin = 1.05;
  camera::SplineGrid grid;
  const double fov_rad = 4.0 * std::atan(0.5 * kMargin * reach.x());
  grid.fov_x_deg = std::clamp(static_cast<int>(std::ceil(fov_rad * 180.0 / std::numbers::pi)), 10, 340);
  const double ratio = reach.y() / reach.x();
  grid.columns = static_cast<int>(std::clamp(
      std::round(std::sqrt(static_cast<double>(corners) / (kCornersPerKnot * ratio))), kFewest, kMost));
  const double mesh = 4.0 * std::tan(grid.fov_x_deg * std::numbers::pi / 720.0) / (grid.columns - 3.0);
  grid.rows = std::max(4, static_cast<int>(std::ceil(2.0 * kMargin * reach.y() / mesh)) + 3);
  return grid;
}

/// The splined camera whose surface is that of `seen`: least squares over the stereographic plane, a linear
/// problem, a touch of ridge for the knots beyond.
Camera splined_like(const Camera& seen, const camera::SplineGrid& grid) {
  Camera out = seen;
  out.model = camera::CameraModel::splined_stereographic;
  out.spline = grid;
  out.distortion.assign(static_cast<std::size_t>(camera::distortion_count(out.model, grid)), 0.0);
  out.covariance.resize(0, 0);
  const Eigen::Index knots = grid.columns * grid.rows;
  Eigen::MatrixXd normal = 1e-6 * Eigen::MatrixXd::Identity(knots, knots);
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(knots, 2);
  const double reach = 2.0 * std::tan(grid.fov_x_deg * std::numbers::pi / 720.0),
               mesh = 2.0 * reach / (grid.columns - 3.0);
  const double down = 0.5 * mesh * (grid.rows - 3.0);
  constexpr int kPerMesh = 3;
  for (double y = -down; y <= down; y += mesh / kPerMesh) {
    for (double x = -reach; x <= reach; x += mesh / kPerMesh) {
      const Eigen::Vector3d ray = Eigen::Vector3d(x, y, 1.0 - 0.25 * (x * x + y * y)).normalized();
      const auto px = camera::project(seen, ray);
      const auto back = px ? camera::unproject_ray(seen, *px) : std::nullopt;
      // Beyond the fold of the formula there is nothing to imitate.
      if (!back || (*back - ray).norm() > 1e-6) continue;
      const auto at = camera::project_with_jacobians(out, ray);
      const Eigen::Vector2d shift((px->x() - seen.cx) / seen.fx - x, (px->y() - seen.cy) / seen.fy - y);
      for (Eigen::Index a = 4; a < at->d_intrinsics.cols(); a += 2) {
        const Eigen::Index knot_a = (at->place[static_cast<std::size_t>(a)] - 4) / 2;
        const double weight_a = at->d_intrinsics(0, a) / seen.fx;
        right.row(knot_a) += weight_a * shift.transpose();
        for (Eigen::Index b = 4; b < at->d_intrinsics.cols(); b += 2)
          normal(knot_a, (at->place[static_cast<std::size_t>(b)] - 4) / 2) +=
              weight_a * at->d_intrinsics(0, b) / seen.fx;
      }
    }
  }
  const Eigen::MatrixX2d values = normal.ldlt().solve(right);
  for (Eigen::Index k = 0; k < knots; ++k) {
    out.distortion[static_cast<std::size_t>(2 * k)] = values(k, 0);
    out.distortion[static_cast<std::size_t>(2 * k + 1)] = values(k, 1);
  }
  return out;
}

}  // namespace

Status solve_splined_lens(const Job& job, const Start& start, Round& round) {
  Job first = job;
  first.options.model = camera::CameraModel::fisheye;
  first.options.solve_aspect = first.options.solve_warp = false;
  FURROW_DO(solve_formula(first, start, round));
  Camera seen = start.camera;
  take_over(round, round.solved, seen);
  if (!camera::validate(seen).ok()) return solve_failed("no fisheye to start the splines from");
  std::size_t corners = 0;
  for (const SolveView& view : round.views) corners += view.seen.px.size();
  FreeTerms free;
  free.core = false;
  const camera::SplineGrid grid = grid_for(seen, corners);
  const Camera camera = splined_like(seen, grid);
  if (!camera::validate(camera).ok()) return solve_failed("no grid of knots over what the lens sees");
  free.distortion = static_cast<int>(camera.distortion.size());
  free.warp = job.options.solve_warp;
  const double noise_px = residual_px(round);
  round.model = make_shared_model(camera, round.model.board, Eigen::Vector2d::Zero(), free);
  // Knots within 0.02 of the fisheye's surface, one sigma: some 20 px at a focal length of 1000.
  constexpr double kKnotSigma = 0.02;
  round.model.prior_mean = shared_of(round.model);
  round.model.prior_weight = Eigen::VectorXd::Constant(round.model.count, noise_px / kKnotSigma);
  if (free.warp) round.model.prior_weight.tail<2>().setZero();
  round.solved = solve(round.model, shared_of(round.model), round.views, {job.options.max_iterations});
  return Done{};
}

}  // namespace furrow::calib
