#include "camera/spline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace furrow::camera {
namespace {

/// Weights of the knots along one axis and their slopes by the place, in knots.
struct AxisWeights {
  std::array<double, 4> weight{}, slope{};
};

/// First knot of the patch along one axis of `count` knots.
int first_knot(double at, int count, int order) {
  const double held = std::clamp(at, 0.0, 1.0 * count);
  return order == 3 ? std::clamp(static_cast<int>(std::floor(held)), 1, count - 3) - 1
                    : std::clamp(static_cast<int>(std::floor(held + 0.5)), 1, count - 2) - 1;
}

/// Uniform cubic B-spline; x runs from 0 to 1 between the two middle knots.
AxisWeights cubic_weights(double at, int first) {
  const double x = at - (first + 1), y = 1.0 - x;
  AxisWeights out;
  out.weight = {y * y * y / 6.0, (4.0 - 6.0 * x * x + 3.0 * x * x * x) / 6.0,
                (4.0 - 6.0 * y * y + 3.0 * y * y * y) / 6.0, x * x * x / 6.0};
  out.slope = {-y * y / 2.0, (3.0 * x * x - 4.0 * x) / 2.0, (4.0 * y - 3.0 * y * y) / 2.0, x * x / 2.0};
  return out;
}

/// Uniform quadratic B-spline; x runs from -1/2 to 1/2 about the middle knot.
AxisWeights quadratic_weights(double at, int first) {
  const double x = at - (first + 1);
  AxisWeights out;
  out.weight = {0.5 * (x - 0.5) * (x - 0.5), 0.75 - x * x, 0.5 * (x + 0.5) * (x + 0.5), 0.0};
  out.slope = {x - 0.5, -2.0 * x, x + 0.5, 0.0};
  return out;
}

Eigen::Vector2d in_knots(const SplineGrid& grid, const Eigen::Vector2d& stereographic) {
  return stereographic * knots_per_unit(grid) + 0.5 * Eigen::Vector2d(grid.columns - 1.0, grid.rows - 1.0);
}

}  // namespace

double knots_per_unit(const SplineGrid& grid) {
  const int spare = grid.order == 3 ? 2 : 1;
  const double edge = 2.0 * std::tan(grid.fov_x_deg * std::numbers::pi / 180.0 / 4.0);
  return (grid.columns - 1.0 - spare) / (2.0 * edge);
}

bool is_inside_grid(const SplineGrid& grid, const Eigen::Vector2d& stereographic) {
  const Eigen::Vector2d at = in_knots(grid, stereographic);
  const double spare = grid.order == 3 ? 1.0 : 0.5;
  return at.x() >= spare && at.y() >= spare && at.x() <= grid.columns - 1.0 - spare &&
         at.y() <= grid.rows - 1.0 - spare;
}

SplinePatch patch_at(const SplineGrid& grid, const Eigen::Vector2d& stereographic) {
  const Eigen::Vector2d at = in_knots(grid, stereographic);
  return {first_knot(at.x(), grid.columns, grid.order), first_knot(at.y(), grid.rows, grid.order)};
}

SplineSample sample_spline(const Camera& camera, const Eigen::Vector2d& stereographic) {
  return sample_patch(camera, stereographic, patch_at(camera.spline, stereographic));
}

SplineSample sample_patch(const Camera& camera, const Eigen::Vector2d& stereographic,
                          const SplinePatch& patch) {
  const SplineGrid& grid = camera.spline;
  const Eigen::Vector2d at = in_knots(grid, stereographic);
  const auto weights = grid.order == 3 ? cubic_weights : quadratic_weights;
  const AxisWeights across = weights(at.x(), patch.column), down = weights(at.y(), patch.row);
  const int side = grid.order + 1;
  SplineSample out;
  out.shift.setZero();
  out.d_shift.setZero();
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      const int knot = (patch.row + j) * grid.columns + patch.column + i;
      const Eigen::Vector2d value(camera.distortion[2 * static_cast<std::size_t>(knot)],
                                  camera.distortion[2 * static_cast<std::size_t>(knot) + 1]);
      const auto place = static_cast<std::size_t>(out.knots++);
      out.knot[place] = knot;
      out.weight[place] = across.weight[a] * down.weight[b];
      out.shift += out.weight[place] * value;
      out.d_shift.col(0) += across.slope[a] * down.weight[b] * value;
      out.d_shift.col(1) += across.weight[a] * down.slope[b] * value;
    }
  }
  out.d_shift *= knots_per_unit(grid);
  return out;
}

}  // namespace furrow::camera
