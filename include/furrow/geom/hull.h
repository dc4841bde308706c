#pragma once
#include <Eigen/Core>
#include <vector>

namespace furrow::geom {

/// Corners of the smallest convex outline about the points, in the order in which x turns towards y; points
/// on its sides are left out. Fewer than three where all points lie in one line.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points);

/// Whether a point lies in a convex outline as convex_hull() returns it, its sides included.
bool is_inside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& point);

}  // namespace furrow::geom
