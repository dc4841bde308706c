#include "furrow/altitude/plan.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/random.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "shot_system.h"

namespace furrow::altitude {
namespace {

/// Distance between cuts across the rows, px, as the row detection's.
constexpr double kCutPx = 10.0;
/// Rows looked for on each side: more than a picture of any pitch below -10 deg resolves.
constexpr int kRowsEachSide = 20;
/// One draw of picture noise stands for all.
constexpr std::uint64_t kSeed = 1;

Status check_pose(const PlannedPose& pose) {
  constexpr double kHighest_m = 10'000.0;  // rows are far below a pixel long before
  const bool sound = pose.height_above_canopy_m > 0.0 && pose.height_above_canopy_m <= kHighest_m &&
                     pose.pitch_rad < 0.0 && pose.pitch_rad >= -geom::kPi / 2.0 &&
                     std::isfinite(pose.heading_rad) && std::isfinite(pose.cross_track_m);
  if (sound) return Done{};
  return Error{"bad_pose", "plan",
               "height " + base::format_double(pose.height_above_canopy_m) + " m, pitch " +
                   base::format_double(geom::rad_to_deg(pose.pitch_rad)) + " deg",
               "a height above 0, at most 10000 m, and a pitch below the horizon, at least -90 deg", ""};
}

/// One edge that the picture shows, with the running state of its noise.
struct EdgeTrace {
  int row = 0;
  Side side = Side::left;
  Vector3<double> line;
  double state = 0.0;
};

/// Whether an edge at slope t stands against the leaves of a neighbour.
bool against_leaves(const VisibleRow<double>& neighbour, double t) {
  return t >= neighbour.right.slope - 1e-12 && t <= neighbour.left.slope + 1e-12;
}

std::vector<EdgeTrace> traces_of(const ShotVector& x, const PlanOptions& options) {
  const RowAxes<double> axes = row_axes(x[kTheta], x[kLambda], x[kPsi]);
  std::vector<EdgeTrace> traces;
  for (int k = -kRowsEachSide; k <= kRowsEachSide; ++k) {
    const auto seen = [&](int row) { return visible_row(x.data(), x.data() + kPoseSize, row); };
    const VisibleRow<double> row = seen(k), before = seen(k - 1), after = seen(k + 1);
    for (const Side side : {Side::left, Side::right}) {
      const double t = side == Side::left ? row.left.slope : row.right.slope;
      const bool merged = against_leaves(before, t) || against_leaves(after, t);
      if (merged && !options.leaf_against_leaf) continue;
      traces.push_back({k, side, line_at(axes, t), 0.0});
    }
  }
  return traces;
}

/// Where a line passes picture row v (without distortion), if that is inside the picture and below the
/// horizon.
std::optional<Eigen::Vector2d> cut(const EdgeTrace& trace, const RowAxes<double>& axes, const Camera& camera,
                                   double v) {
  const double y = (v - camera.cy) / camera.fy;
  const Eigen::Vector2d p(-(trace.line.y * y + trace.line.z) / trace.line.x, y);
  const bool below = axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z < 0.0;
  const auto px = camera::project(camera, {p.x(), p.y(), 1.0});
  if (!below || !px || px->x() < 0.0 || px->x() > camera.width - 1.0) return std::nullopt;
  return p;
}

/// The rows that a detector would give, as directions with noise.
RowsOnUnitPlane draw(const ShotVector& x, const Camera& camera, const PlanOptions& options) {
  const RowAxes<double> axes = row_axes(x[kTheta], x[kLambda], x[kPsi]);
  base::Random random(kSeed);
  const double sigma = options.edge_sigma_px / camera.fx;
  const double fresh = std::sqrt(1.0 - options.edge_correlation * options.edge_correlation);
  std::vector<EdgeTrace> traces = traces_of(x, options);
  RowsOnUnitPlane rows;
  for (EdgeTrace& trace : traces) {
    if (rows.rows.empty() || rows.rows.back().index != trace.row) rows.rows.push_back({trace.row, {}});
    const VisibleRow<double> row = visible_row(x.data(), x.data() + kPoseSize, trace.row);
    const double width_per_drop = (row.left.slope - row.right.slope) * camera.fx;
    trace.state = random.normal();
    for (int i = 0; i * kCutPx < camera.height; ++i) {
      trace.state = options.edge_correlation * trace.state + fresh * random.normal();
      const auto p = cut(trace, axes, camera, i * kCutPx);
      if (!p) continue;
      const double drop = -(axes.q.x * p->x() + axes.q.y * p->y() + axes.q.z);
      if (width_per_drop * drop < options.narrowest_px) continue;
      RowDirection d;
      d.centre = *p + Eigen::Vector2d(sigma * trace.state, 0.0);
      d.sigma = d.edge_sigma = sigma * std::abs(trace.line.x) / std::hypot(trace.line.x, trace.line.y);
      (trace.side == Side::left ? d.left : d.right) = d.centre;
      rows.rows.back().directions.push_back(d);
    }
  }
  std::erase_if(rows.rows, [](const RowsOnUnitPlane::Row& row) { return row.directions.size() < 2; });
  return rows;
}

ShotVector planned_vector(const PlannedPose& pose, const Farm& farm) {
  ShotVector x;
  x << std::log(pose.height_above_canopy_m), pose.pitch_rad, 0.0, pose.heading_rad, pose.cross_track_m,
      farm.row_spacing_m.value, farm.half_width_m.value, farm.foliage_depth_m.value,
      farm.base_width_ratio.value, farm.rounding.value, farm.softness.value;
  return x;
}

void keep_best(const std::vector<PlannedShot>& plans, std::optional<PlannedShot>& best) {
  const auto relative = [](const PlannedShot& p) {
    return p.height_above_canopy_m.sigma / p.height_above_canopy_m.value;
  };
  for (const PlannedShot& plan : plans) {
    if (!best || relative(plan) < relative(*best)) best = plan;
  }
}

}  // namespace

Result<PlannedShot> plan_shot(const Camera& camera, const PlannedPose& pose, const FieldKnowledge& field,
                              const PlanOptions& options) {
  FURROW_DO(camera::validate(camera));
  FURROW_DO(check_pose(pose));
  FURROW_TRY(const Farm farm, complete_farm(field));
  const ShotVector x = planned_vector(pose, farm);
  const AttitudePrior prior{{pose.pitch_rad, options.pitch_sigma_rad, 1}, {0.0, options.roll_sigma_rad, 1}};
  FURROW_TRY(PreparedShot prepared,
             prepare_directions(draw(x, camera, options), field, farm, prior, options.refine));
  // The sigma is wanted at the planned pose, not at the pose that this draw of noise gives.
  prepared.x = x;
  FURROW_TRY(const RefinedShot refined, settle_shot(prepared, camera, field, options.refine));
  PlannedShot plan;
  plan.pose = pose;
  plan.height_above_canopy_m = {pose.height_above_canopy_m, refined.height_above_canopy_m.sigma,
                                refined.observations};
  plan.cross_track_sigma_m = refined.cross_track_m.sigma;
  plan.pitch_sigma_rad = refined.pitch_rad.sigma;
  plan.height_budget = refined.height_budget;
  plan.rows_used = refined.rows_used;
  return plan;
}

PlanAdvice plan_advice(const Camera& camera, const PlannedPose& pose, const FieldKnowledge& field,
                       const PlanOptions& options) {
  PlanAdvice advice;
  for (int degrees = 10; degrees <= 90; degrees += 5) {
    PlannedPose other = pose;
    other.pitch_rad = -geom::deg_to_rad(degrees);
    const auto plan = plan_shot(camera, other, field, options);
    if (plan.ok()) advice.by_pitch.push_back(*plan);
  }
  constexpr int kSteps = 10;
  for (int i = 0; i <= kSteps; ++i) {
    PlannedPose other = pose;
    other.height_above_canopy_m *= std::exp2(-1.0 + 2.0 * i / kSteps);
    const auto plan = plan_shot(camera, other, field, options);
    if (plan.ok()) advice.by_height.push_back(*plan);
  }
  keep_best(advice.by_pitch, advice.best_pitch);
  keep_best(advice.by_height, advice.best_height);
  return advice;
}

}  // namespace furrow::altitude
