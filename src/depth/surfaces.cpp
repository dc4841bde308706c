#include "furrow/depth/surfaces.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

#include "furrow/base/text.h"
#include "furrow/geom/attitude.h"
#include "furrow/stats/robust.h"

namespace furrow::depth {
namespace {

/// A pixel that is known: its ray (x, y, 1) on the unit plane and its z-depth.
struct Point {
  Eigen::Vector3d ray;
  double z_m = 0.0;
};

/// Fewer points are no surface.
constexpr std::size_t kLeastPoints = 200;
/// More than these add time and no knowledge: neighbours repeat each other.
constexpr int kMostColumns = 160;

Result<std::vector<Point>> points_of(const SurfaceInput& input) {
  const DepthMap& map = input.z_depth_m;
  // A network's input is squeezed to its own shape; the map still covers the camera's whole picture.
  const Camera camera = camera::resize_camera(input.camera, map.width, map.height);
  const int step = std::max(1, map.width / kMostColumns);
  std::vector<Point> points;
  for (int v = step / 2; v < map.height; v += step) {
    for (int u = step / 2; u < map.width; u += step) {
      const double z = static_cast<double>(map.at(u, v));
      if (!std::isfinite(z)) continue;
      const auto ray = camera::unproject(camera, {u, v});
      if (ray) points.push_back({{ray->x(), ray->y(), 1.0}, z});
    }
  }
  if (points.size() < kLeastPoints) {
    return Error{"map_too_small", "depth map", std::to_string(points.size()) + " values",
                 "at least " + std::to_string(kLeastPoints), ""};
  }
  return points;
}

/// Direction down in cam.
Eigen::Vector3d down_in_cam(double pitch_rad, double roll_rad) {
  return -geom::cam_from_level({0.0, pitch_rad, roll_rad}).col(2);
}

/// Drop from the camera to each point that is seen well below the horizon.
std::vector<double> drops_of(const std::vector<Point>& points, const Eigen::Vector3d& down,
                             double flattest_rad) {
  std::vector<double> drops;
  for (const Point& point : points) {
    const double sine = down.dot(point.ray) / point.ray.norm();
    if (sine > std::sin(flattest_rad)) drops.push_back(point.z_m * down.dot(point.ray));
  }
  return drops;
}

/// Canopy at `drop`, soil a row height below it, and what fits neither.
struct Levels {
  double drop_m = 0.0, sigma_m = 0.0;
  double soil_share = 0.0, fitting_share = 0.0;
  double cost = HUGE_VAL;
};

constexpr double kGate = 2.0;  ///< sigmas beyond which a point belongs to no level

double level_cost(const std::vector<double>& drops, double drop, double row_height, double sigma) {
  double cost = 0.0;
  for (const double d : drops) {
    const double canopy = std::abs(d - drop), soil = std::abs(d - drop - row_height);
    const double away = std::min(canopy, soil) / sigma;
    // Leaves win where both explain a point equally well.
    cost += std::min(away * away, kGate * kGate) + (soil < canopy ? 1e-3 : 0.0);
  }
  return cost;
}

/// Means of those that belong to the levels, until they stay.
Levels settle(const std::vector<double>& drops, double drop, double row_height, double sigma) {
  Levels levels{drop, sigma, 0.0, 0.0, level_cost(drops, drop, row_height, sigma)};
  for (int pass = 0; pass < 20; ++pass) {
    std::vector<double> canopy_drops;
    double soil = 0.0;
    for (const double d : drops) {
      const bool is_soil = std::abs(d - levels.drop_m - row_height) < std::abs(d - levels.drop_m);
      const double as_canopy = d - (is_soil ? row_height : 0.0);
      if (std::abs(as_canopy - levels.drop_m) > kGate * sigma) continue;
      canopy_drops.push_back(as_canopy);
      soil += is_soil;
    }
    if (canopy_drops.empty()) return levels;
    const double before = levels.drop_m;
    levels.drop_m = stats::mean(canopy_drops);
    levels.sigma_m = stats::standard_deviation(canopy_drops);
    levels.soil_share = soil / static_cast<double>(canopy_drops.size());
    levels.fitting_share = static_cast<double>(canopy_drops.size()) / static_cast<double>(drops.size());
    if (std::abs(levels.drop_m - before) < 1e-6 * before) break;
  }
  return levels;
}

Levels find_levels(const std::vector<double>& drops, double row_height) {
  constexpr int kTries = 200;
  // Apart enough to tell two levels, wide enough for a tenth of the height.
  const double low = stats::quantile(drops, 0.02), high = stats::quantile(drops, 0.98);
  const double sigma =
      std::max(1e-3, std::min(0.1 * stats::median(drops), row_height > 0.0 ? row_height / 8.0 : HUGE_VAL));
  double best = low, least = HUGE_VAL;
  for (int i = 0; i <= kTries; ++i) {
    const double drop = low + (high - low) * i / kTries;
    const double cost = level_cost(drops, drop, row_height, sigma);
    if (cost < least) least = cost, best = drop;
  }
  return settle(drops, best, row_height, sigma);
}

/// Weighted plane through all points: 1/z = g . ray, which is linear, and the errors of a disparity are those
/// of 1/z. Height along the normal: 1 / |g|.
struct Plane {
  double pitch_rad = 0.0, height_m = 0.0;
};

Plane fit_plane(const std::vector<Point>& points) {
  Eigen::Vector3d g(0.0, 0.0, 1.0);
  std::vector<double> residuals(points.size(), 0.0);
  double scale = HUGE_VAL;
  for (int pass = 0; pass < 10; ++pass) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double r = std::abs(residuals[i]), weight = r < scale ? 1.0 : scale / r;
      normal += weight * points[i].ray * points[i].ray.transpose();
      right += weight * points[i].ray / points[i].z_m;
    }
    g = normal.ldlt().solve(right);
    for (std::size_t i = 0; i < points.size(); ++i) residuals[i] = 1.0 / points[i].z_m - g.dot(points[i].ray);
    scale = std::max(1e-12, stats::mad_sigma(residuals));
  }
  // The normal points down; the axis dips by the angle to the plane.
  return {-std::asin(g.z() / g.norm()), 1.0 / g.norm()};
}

/// How far the height moves when the camera is turned by one sigma of an angle.
double by_angle(const std::vector<Point>& points, double pitch, double roll, double row_height,
                const SurfaceOptions& options, double drop) {
  const auto drops = drops_of(points, down_in_cam(pitch, roll), options.flattest_rad);
  return drops.empty() ? 0.0 : find_levels(drops, row_height).drop_m - drop;
}

}  // namespace

Result<DepthHeight> height_from_map(const SurfaceInput& input, const SurfaceOptions& options) {
  if (!input.pitch_rad.usable())
    return Error{"no_pitch", "depth map", "no pitch of the gimbal", "the log's or the picture's", ""};
  FURROW_TRY(const auto points, points_of(input));
  const double pitch = input.pitch_rad.value;
  const double roll = input.roll_rad.usable() ? input.roll_rad.value : 0.0;
  const auto drops = drops_of(points, down_in_cam(pitch, roll), options.flattest_rad);
  const double row_height = input.row_height_m.usable() ? input.row_height_m.value : 0.0;
  constexpr double kLeastShare = 0.5;
  const Levels levels = drops.size() < kLeastPoints ? Levels{} : find_levels(drops, row_height);
  if (levels.fitting_share < kLeastShare) {
    return Error{"no_surface", "depth map",
                 base::format_fixed(100.0 * levels.fitting_share, 0) + " % of " +
                     std::to_string(drops.size()) + " points lie on two levels",
                 "half of at least " + std::to_string(kLeastPoints), ""};
  }
  DepthHeight height;
  const Plane plane = fit_plane(points);
  height.plane_pitch_rad = plane.pitch_rad;
  height.plane_height_m = plane.height_m;
  height.scatter_m = levels.sigma_m;
  height.soil_share = levels.soil_share;
  const double patches = std::max(1.0, levels.fitting_share * input.z_depth_m.height /
                                           (std::pow(options.patch_share, 2) * input.z_depth_m.width));
  // A wrong scale moves the soil too, which stands a row height lower.
  height.by_scale_m = options.scale_sigma * (levels.drop_m + levels.soil_share * row_height);
  const auto turned = [&](double more_pitch, double more_roll) {
    return by_angle(points, pitch + more_pitch, roll + more_roll, row_height, options, levels.drop_m);
  };
  height.by_angles_m = std::hypot(turned(input.pitch_rad.sigma, 0.0),
                                  input.roll_rad.usable() ? turned(0.0, input.roll_rad.sigma) : 0.0);
  double variance = std::pow(levels.sigma_m, 2) / patches + std::pow(height.by_scale_m, 2) +
                    std::pow(height.by_angles_m, 2);
  // On one level only, leaves or soil is a guess.
  constexpr double kSeen = 0.05;
  const bool open = levels.soil_share < kSeen || levels.soil_share > 1.0 - kSeen;
  if (row_height > 0.0) {
    const double doubt = open ? row_height : levels.soil_share * input.row_height_m.sigma;
    variance += doubt * doubt;
  }
  height.above_canopy_m = {levels.drop_m, std::sqrt(variance), static_cast<int>(drops.size())};
  return height;
}

}  // namespace furrow::depth
