#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "furrow/sim/world.h"
#include "sim/plan.h"

namespace furrow::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFinest_m = 0.02;  // distance between the points of a line near the camera
constexpr double kRelative = 0.01;  // and far from it, as a part of the distance
constexpr double kBehind_m = 60.0, kAhead_m = 400.0;

/// Projects points of the rows, which repeat the same few thousand times a shot.
class RowProjector {
 public:
  RowProjector(const Scene& scene, const ShotTruth& shot)
      : scene_(scene),
        shot_(shot),
        terrain_(scene),
        frame_(scene.field.curvature_per_m),
        turn_(world_from_plan(scene.field.azimuth_deg)) {
    const auto beyond = camera::unproject(scene.camera, {0.0, 0.0});
    reach_ = beyond ? 2.0 * beyond->norm() : 2.0;
  }
  std::optional<Vector2d> at(double s, double l) const {
    const Vector2d xy = frame_.plan_from_row(s, l);
    const Vector2d east_north = turn_ * xy;
    const Vector3d in_cam =
        shot_.cam_from_world *
        Vector3d(east_north.x(), east_north.y(), terrain_.height(xy.x(), xy.y()) + scene_.field.row_height_m);
    // Beyond the lens's own field the polynomial may fold back into the picture.
    if (in_cam.z() <= 0.0 || in_cam.head<2>().norm() > reach_ * in_cam.z()) return std::nullopt;
    return camera::project(scene_.camera, in_cam);
  }

 private:
  const Scene& scene_;
  const ShotTruth& shot_;
  Terrain terrain_;
  RowFrame frame_;
  Eigen::Matrix2d turn_;
  double reach_;
};

/// The line at l in the picture, from near to far.
std::vector<Vector2d> line_px(const RowProjector& project, double s_camera, double l) {
  std::vector<Vector2d> line;
  for (double d = -kBehind_m; d < kAhead_m; d += std::max(kFinest_m, kRelative * std::abs(d))) {
    if (const auto px = project.at(s_camera + d, l)) line.push_back(*px);
  }
  return line;
}

/// u where a line crosses picture row v; the first crossing from its near end.
std::optional<double> crossing_u(const std::vector<Vector2d>& line, double v) {
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const double a = line[i].y() - v, b = line[i + 1].y() - v;
    if ((a >= 0.0) == (b >= 0.0)) continue;
    return line[i].x() + (line[i + 1].x() - line[i].x()) * a / (a - b);
  }
  return std::nullopt;
}

}  // namespace

std::vector<TrueRow> true_rows(const Scene& scene, const ShotTruth& shot, double step_px) {
  check(step_px > 0.0, "a step above 0");
  const RowProjector project(scene, shot);
  const Field& f = scene.field;
  std::vector<TrueRow> rows;
  double nearest_px = std::numeric_limits<double>::infinity();
  int followed = 0;
  for (int row = f.rows_each_side; row >= -f.rows_each_side; --row) {
    const double l = row * f.spacing_m;
    const auto centre = line_px(project, shot.along_row_m, l);
    const auto left = line_px(project, shot.along_row_m, l + f.half_width_m);
    const auto right = line_px(project, shot.along_row_m, l - f.half_width_m);
    TrueRow seen;
    seen.row = row;
    for (double v = 0.0; v < scene.camera.height; v += step_px) {
      const auto u = crossing_u(centre, v), left_u = crossing_u(left, v), right_u = crossing_u(right, v);
      if (!u || !left_u || !right_u || *u < 0.0 || *u > scene.camera.width - 1) continue;
      seen.crossings.push_back({v, *u, *left_u, *right_u});
    }
    if (seen.crossings.empty()) continue;
    const auto middle = crossing_u(centre, 0.5 * (scene.camera.height - 1));
    const double off_px = middle ? std::abs(*middle - 0.5 * (scene.camera.width - 1)) : nearest_px;
    if (off_px < nearest_px) {
      nearest_px = off_px;
      followed = row;
    }
    rows.push_back(std::move(seen));
  }
  for (TrueRow& row : rows) row.index = followed - row.row;
  return rows;
}

}  // namespace furrow::sim
