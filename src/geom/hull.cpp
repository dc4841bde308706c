#include "furrow/geom/hull.h"

#include <algorithm>

namespace furrow::geom {
namespace {

/// Above 0 where c lies on the side of the line from a to b to which x turns towards y.
double side(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Half of the outline over points in rising order, its last one left to the other half (Andrew 1979).
void add_chain(const std::vector<Eigen::Vector2d>& points, std::vector<Eigen::Vector2d>& out) {
  const std::size_t first = out.size();
  for (const Eigen::Vector2d& p : points) {
    while (out.size() >= first + 2 && side(out[out.size() - 2], out.back(), p) <= 0.0) out.pop_back();
    out.push_back(p);
  }
  out.pop_back();
}

}  // namespace

std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> out;
  add_chain(points, out);
  std::reverse(points.begin(), points.end());
  add_chain(points, out);
  return out;
}

bool is_inside(const std::vector<Eigen::Vector2d>& hull, const Eigen::Vector2d& point) {
  if (hull.size() < 3) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    if (side(hull[i], hull[(i + 1) % hull.size()], point) < 0.0) return false;
  }
  return true;
}

}  // namespace furrow::geom
