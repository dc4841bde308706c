#include "outline_roughness.h"

#include <cmath>
#include <Eigen/Geometry>
#include <limits>
#include <optional>

#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

constexpr double kNearAlong_m = 12.0;  // a pixel of a phone's or drone's wide lens is 1 to 2 cm there
constexpr double kNearRows = 1.6;      // spacings to the side
constexpr std::size_t kFewest = 7;     // samples of an edge

/// Where lines of sight meet the plane of the tops: along the rows and to their left.
struct Places {
  std::vector<double> along_m, left_m;
};

std::optional<Eigen::Vector2d> place_on_tops(const RowAxes<double>& axes, double drop_m,
                                             const Eigen::Vector2d& p) {
  const Eigen::Vector3d m(axes.m.x, axes.m.y, axes.m.z), q(axes.q.x, axes.q.y, axes.q.z);
  const double down = -q.dot(p.homogeneous());
  if (!(down > 0.0)) return std::nullopt;
  const double reach = drop_m / down;
  return Eigen::Vector2d(reach * m.cross(q).dot(p.homogeneous()), reach * m.dot(p.homogeneous()));
}

Places places_of(const RowsOnUnitPlane::Row& row, std::optional<Eigen::Vector2d> RowDirection::*edge,
                 const RowAxes<double>& axes, double drop_m) {
  Places places;
  for (const RowDirection& direction : row.directions) {
    if (!(direction.*edge)) continue;
    const auto place = place_on_tops(axes, drop_m, *(direction.*edge));
    if (!place || std::abs(place->x()) > kNearAlong_m) continue;
    places.along_m.push_back(place->x());
    places.left_m.push_back(place->y());
  }
  return places;
}

/// Robust scatter about the least-squares line.
double scatter_of(const Places& places) {
  const double n = static_cast<double>(places.along_m.size());
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (std::size_t i = 0; i < places.along_m.size(); ++i)
    x += places.along_m[i] / n, y += places.left_m[i] / n;
  for (std::size_t i = 0; i < places.along_m.size(); ++i) {
    xx += (places.along_m[i] - x) * (places.along_m[i] - x);
    xy += (places.along_m[i] - x) * (places.left_m[i] - y);
  }
  std::vector<double> residuals;
  for (std::size_t i = 0; i < places.along_m.size(); ++i)
    residuals.push_back(places.left_m[i] - y - (xx > 0.0 ? xy / xx : 0.0) * (places.along_m[i] - x));
  return stats::mad_sigma(residuals);
}

}  // namespace

double outline_roughness_m(const RowsOnUnitPlane& rows, const ShotVector& x) {
  const RowAxes<double> axes = row_axes(x[kTheta], x[kLambda], x[kPsi]);
  const double farthest_m = kNearRows * x[kPoseSize + kSpacing];
  std::vector<double> scatters;
  for (const RowsOnUnitPlane::Row& row : rows.rows) {
    for (const auto edge : {&RowDirection::left, &RowDirection::right}) {
      const Places places = places_of(row, edge, axes, std::exp(x[kLogHeight]));
      if (places.left_m.size() < kFewest) continue;
      const double place_m = stats::median(places.left_m);
      const bool is_far = (edge == &RowDirection::left) == (place_m > 0.0);
      if (is_far && std::abs(place_m) < farthest_m) scatters.push_back(scatter_of(places));
    }
  }
  return scatters.empty() ? std::numeric_limits<double>::quiet_NaN() : stats::median(scatters);
}

}  // namespace furrow::altitude
