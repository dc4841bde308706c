#include "furrow/altitude/birds_eye.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "furrow/image/remap.h"

namespace furrow::altitude {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The refined pose over the plane of the row tops; its frame is `row`, origin at the camera's foot.
struct PoseOverRows {
  const Camera& camera;
  Eigen::Matrix3d cam_from_row;
  double height_m;
  /// Beyond it (unit plane) the lens model folds back, and would show a second, false picture.
  double fold_radius = std::numeric_limits<double>::infinity();

  /// Where the pixel's ray meets the plane; nothing at and above the horizon.
  std::optional<Vector2d> on_plane(const Vector2d& px) const {
    const auto direction = camera::unproject(camera, px);
    if (!direction) return std::nullopt;
    const Vector3d ray = cam_from_row.transpose() * Vector3d(direction->x(), direction->y(), 1.0);
    if (!(ray.z() < 0.0)) return std::nullopt;
    return Vector2d(ray.head<2>() * (height_m / -ray.z()));
  }

  std::optional<Vector2d> px_of(const Vector2d& on_plane_m) const {
    const Vector3d point = cam_from_row * Vector3d(on_plane_m.x(), on_plane_m.y(), -height_m);
    if (point.z() > 0.0 && point.head<2>().norm() > fold_radius * point.z()) return std::nullopt;
    return camera::project(camera, point);
  }
};

struct Extent {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  void add(const Vector2d& point) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
};

/// The part of the plane that the picture shows finely enough, from a grid of its pixels.
Extent visible_ground(const PoseOverRows& pose, const BirdsEyeOptions& options) {
  constexpr int kSteps = 64;
  Extent extent;
  for (int j = 0; j <= kSteps; ++j) {
    const double v = (pose.camera.height - 1.0) * j / kSteps;
    for (int i = 0; i <= kSteps; ++i) {
      const double u = (pose.camera.width - 1.0) * i / kSteps;
      const auto here = pose.on_plane({u, v}), below = pose.on_plane({u, v + 1.0});
      if (here && below && (*here - *below).norm() <= options.coarsest_m_per_px) extent.add(*here);
    }
  }
  return extent;
}

/// Where in the picture each pixel of the view is seen; not finite where the camera cannot see it.
std::vector<Vector2d> seen_at(const PoseOverRows& pose, const BirdsEye& view, int width, int height) {
  std::vector<Vector2d> from_px;
  from_px.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      const Vector2d ground(view.ahead_m - (v + 0.5) / view.px_per_m,
                            view.left_m - (u + 0.5) / view.px_per_m);
      from_px.push_back(
          pose.px_of(ground).value_or(Vector2d::Constant(std::numeric_limits<double>::quiet_NaN())));
    }
  }
  return from_px;
}

GroundRow on_ground(const rows::RowLine& line, const PoseOverRows& pose) {
  GroundRow row;
  row.index = line.index;
  row.seen = line.seen;
  const auto add = [&](double u, double v, std::vector<Vector2d>& to) {
    if (!std::isfinite(u) || !std::isfinite(v)) return;
    if (const auto point = pose.on_plane({u, v})) to.push_back(*point);
  };
  for (const rows::RowSample& one : line.samples) {
    add(one.centre_px.x(), one.centre_px.y(), row.centre_m);
    add(one.left_u_px, one.centre_px.y(), row.left_m);
    add(one.right_u_px, one.centre_px.y(), row.right_m);
  }
  return row;
}

bool same_size(const Image& picture, const rows::RowLines& lines, const Camera& camera) {
  return picture.width == camera.width && picture.height == camera.height && lines.width == camera.width &&
         lines.height == camera.height;
}

}  // namespace

Result<BirdsEye> birds_eye(const Image& picture, const rows::RowLines& lines, const Camera& camera,
                           const RefinedShot& shot, const BirdsEyeOptions& options) {
  FURROW_DO(camera::validate(camera));
  if (!same_size(picture, lines, camera)) {
    return Error{"picture_size_differs", "bird's-eye view",
                 "a picture of " + std::to_string(picture.width) + "x" + std::to_string(picture.height) +
                     ", rows of " + std::to_string(lines.width) + "x" + std::to_string(lines.height),
                 "the camera's " + std::to_string(camera.width) + "x" + std::to_string(camera.height), ""};
  }
  if (!shot.usable) return Error{"not_refined", "bird's-eye view", shot.termination, "a refined shot", ""};
  const PoseOverRows pose{
      camera, geom::cam_from_level({shot.yaw_rad.value, shot.pitch_rad.value, shot.roll_rad.value}),
      shot.height_above_canopy_m.value,
      camera::fold_radius(camera).value_or(std::numeric_limits<double>::infinity())};
  Extent extent = visible_ground(pose, options);
  const double aside = options.aside_spacings * shot.row_spacing_m.value;
  extent.low.y() = std::max(extent.low.y(), -aside);
  extent.high.y() = std::min(extent.high.y(), aside);
  const Vector2d size = extent.high - extent.low;
  if (!(size.minCoeff() > 0.0) || !size.allFinite()) {
    return Error{"no_ground", "bird's-eye view",
                 "no part of the plane of the rows finer than " + std::to_string(options.coarsest_m_per_px) +
                     " m a pixel",
                 "a picture of the ground", ""};
  }
  BirdsEye view;
  view.px_per_m = options.longest_side_px / size.maxCoeff();
  view.ahead_m = extent.high.x();
  view.left_m = extent.high.y();
  view.spacing_m = shot.row_spacing_m.value;
  view.half_width_m = shot.half_width_m.value;
  view.cross_track_m = shot.cross_track_m.value;
  const int width = std::max(1, static_cast<int>(std::lround(size.y() * view.px_per_m)));
  const int height = std::max(1, static_cast<int>(std::lround(size.x() * view.px_per_m)));
  view.picture = image::remap(picture, width, height, seen_at(pose, view, width, height));
  for (const rows::RowLine& line : lines.rows) view.rows.push_back(on_ground(line, pose));
  return view;
}

}  // namespace furrow::altitude
