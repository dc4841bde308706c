#pragma once
#include <array>
#include <Eigen/Core>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Most knots that one place depends on: 4 x 4 of a cubic patch.
inline constexpr int kMaxKnots = 16;

/// The spline surface of a splined model at one place of the stereographic plane.
struct SplineSample {
  Eigen::Vector2d shift;                 ///< what is added to the place
  Eigen::Matrix2d d_shift;               ///< by the place
  int knots = 0;                         ///< how many of the following count: 16 cubic, 9 quadratic
  std::array<int, kMaxKnots> knot;       ///< number of each, row by row over the grid
  std::array<double, kMaxKnots> weight;  ///< d shift / d knot, the same for x and y
};

/// The patch at a place; outside the grid the nearest one, as mrcal has it.
SplinePatch patch_at(const SplineGrid& grid, const Eigen::Vector2d& stereographic);

/// The surface by one patch, continued outside it.
SplineSample sample_patch(const Camera& camera, const Eigen::Vector2d& stereographic,
                          const SplinePatch& patch);

/// By the patch at that place.
SplineSample sample_spline(const Camera& camera, const Eigen::Vector2d& stereographic);

/// Knots per unit of the stereographic plane.
double knots_per_unit(const SplineGrid& grid);

/// Whether the place lies on the grid's own patches, where knots on all sides bear on it.
bool is_inside_grid(const SplineGrid& grid, const Eigen::Vector2d& stereographic);

}  // namespace furrow::camera
