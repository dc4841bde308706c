#include "project/shot_chain.h"

#include <chrono>
#include <cmath>
#include <limits>

#include "furrow/altitude/thesis.h"
#include "furrow/altitude/unit_plane.h"
#include "furrow/depth/surfaces.h"
#include "furrow/depth/thesis.h"
#include "furrow/geom/angles.h"
#include "furrow/geom/attitude.h"
#include "furrow/image/image.h"
#include "furrow/rows/detect.h"

namespace furrow::project {
namespace {

using geom::deg_to_rad;
using geom::rad_to_deg;

Estimate in_degrees(const Estimate& radians) {
  return {rad_to_deg(radians.value), rad_to_deg(radians.sigma), radians.observations};
}

audit::ShotRecord record_of(const telemetry::Shot& shot, const sync::ShotPose& pose) {
  audit::ShotRecord record;
  record.shot_id = shot.shot_id;
  record.image = shot.image.filename().string();
  record.t_utc_ns = pose.state.t_utc_ns;
  record.latitude_deg = pose.state.latitude_deg;
  record.longitude_deg = pose.state.longitude_deg;
  record.height_takeoff_m = pose.state.height_takeoff_m;
  record.height_vps_m = pose.state.height_vps_m;
  record.pitch_log_deg = pose.state.gimbal_pitch_deg;
  record.status = "not run";
  return record;
}

/// The gimbal's angles as priors. A gimbal holds its roll level, so a log without roll counts as 0.
altitude::AttitudePrior prior_of(const telemetry::Sample& state, const Project& project) {
  altitude::AttitudePrior prior;
  const double pitch_deg =
      std::isfinite(state.gimbal_pitch_deg) ? state.gimbal_pitch_deg : project.gimbal_pitch_deg;
  if (std::isfinite(pitch_deg))
    prior.pitch_rad = {deg_to_rad(pitch_deg), deg_to_rad(project.gimbal_pitch_sigma_deg), 1};
  const double roll_deg = std::isfinite(state.gimbal_roll_deg) ? state.gimbal_roll_deg : 0.0;
  prior.roll_rad = {deg_to_rad(roll_deg), deg_to_rad(project.gimbal_roll_sigma_deg), 1};
  return prior;
}

/// The thesis's height from its distance; without a sigma, as the thesis gives none.
Estimate height_at(const Result<double>& slant_distance_m, double pitch_rad) {
  if (!slant_distance_m.ok()) return {};
  const auto height_m = altitude::thesis_height_above_canopy_m(*slant_distance_m, pitch_rad);
  if (!height_m.ok()) return {};
  return {*height_m, std::numeric_limits<double>::quiet_NaN(), 1};
}

/// The thesis's formula with the half width found at the picture's middle row.
Estimate automatic_thesis_height(const rows::RowLines& lines, const Camera& camera,
                                 const altitude::FieldKnowledge& field,
                                 const altitude::AttitudePrior& prior) {
  for (const rows::RowLine& row : lines.rows) {
    if (row.index != 0 || !row.half_width_px) continue;
    const Estimate height = thesis_height(row.half_width_px->value, camera, field, prior);
    if (std::isfinite(height.value)) return height;
  }
  return {};
}

void set_failure(audit::ShotRecord& record, const Error& error) {
  record.status = error.code;
  record.reason = error.message();
}

/// A picture that could not be looked at. It is named without its folder: outputs hold no absolute path.
void set_unseen(ShotResult& result, Error error, const Project& project) {
  error.where = result.record.image;
  set_failure(result.record, error);
  result.lines.method = project.rows_method == rows::Method::thesis ? "thesis" : "field";
  result.lines.status = result.record.status;
  result.lines.reason = result.record.reason;
}

/// Rows -> three heights.
void measure(ShotResult& result, const Camera& camera, const Project& project) {
  audit::ShotRecord& record = result.record;
  for (const rows::RowLine& row : result.lines.rows) record.rows_used += row.seen ? 1 : 0;
  record.rows_confidence = result.lines.confidence;
  if (!result.lines.ok()) {
    record.status = result.lines.status;
    record.reason = result.lines.reason;
    return;
  }
  record.above_canopy_thesis_m = automatic_thesis_height(result.lines, camera, project.field, result.prior);
  const auto directions = altitude::rows_on_unit_plane(result.lines, camera);
  if (directions.ok()) {
    const auto closed = altitude::from_spacing(*directions, project.field,
                                               altitude::over_slope(result.prior, refine_options(project)));
    if (closed.ok()) record.above_canopy_spacing_m = closed->height_above_canopy_m;
  }
  const auto refined =
      altitude::refine_shot(result.lines, camera, project.field, result.prior, refine_options(project));
  if (refined.ok()) {
    record = with_refined(std::move(record), *refined);
    record.above_canopy_shot_m = refined->height_above_canopy_m;
    result.vision = vision_of_shot(*refined);
    result.budget = refined->height_budget;
  } else {
    set_failure(record, refined.error());
  }
}

/// The shot's own map: the one with its picture's stem.
std::optional<std::filesystem::path> map_of(const telemetry::Shot& shot, const ProjectDepth& depth) {
  for (const std::filesystem::path& map : depth.maps) {
    if (map.stem() == shot.image.stem()) return map;
  }
  return std::nullopt;
}

/// The thesis's height and that of all of the map. A map that says nothing leaves both open.
void measure_depth(ShotResult& result, const telemetry::Shot& shot, const Project& project) {
  const auto file = map_of(shot, *project.depth);
  if (!file || !result.prior.pitch_rad.usable()) return;
  auto map = depth::read_depth_map(*file, project.depth->unit_per_count);
  if (!map.ok()) {
    result.depth_reason = map.error().message();
    return;
  }
  if (project.depth->disparity) *map = depth::thesis_metres(*map);
  result.record.above_canopy_depth_thesis_m =
      height_at(depth::thesis_slant_distance_m(*map), result.prior.pitch_rad.value);
  if (project.depth->disparity) *map = depth::for_focal_length(std::move(*map), *result.camera);
  const auto height = depth::height_from_map({std::move(*map), *result.camera, result.prior.pitch_rad,
                                              result.prior.roll_rad, project.field.row_height_m},
                                             {.scale_sigma = project.depth->scale_sigma});
  if (!height.ok()) {
    result.depth_reason = height.error().message();
    return;
  }
  result.record.above_canopy_depth_m = height->above_canopy_m;
  result.depth.above_canopy_m = height->above_canopy_m;
  result.depth.shared = {{"depth_scale", height->by_scale_m}, {"depth_angles", height->by_angles_m}};
}

}  // namespace

altitude::RefineOptions refine_options(const Project& project) {
  altitude::RefineOptions options;
  options.terrain_slope_sigma_rad = deg_to_rad(project.slope_sigma_deg);
  options.slope_across_sigma_rad = deg_to_rad(project.slope_across_sigma_deg);
  return options;
}

Estimate thesis_height(double half_width_px, const Camera& camera, const altitude::FieldKnowledge& field,
                       const altitude::AttitudePrior& prior) {
  if (!field.half_width_m.usable() || !prior.pitch_rad.usable()) return {};
  return height_at(altitude::thesis_slant_distance_m(field.half_width_m.value, camera.fx, half_width_px),
                   prior.pitch_rad.value);
}

rows::Priors horizon_of(const altitude::AttitudePrior& prior, const Camera& camera) {
  rows::Priors priors;
  if (!prior.pitch_rad.usable()) return priors;
  const double pitch = prior.pitch_rad.value;
  // Nearer to nadir than this the horizon is so far away that its place tells the row search nothing.
  constexpr double kSteepest = deg_to_rad(-80.0);
  if (pitch < kSteepest || pitch > -kSteepest) return priors;
  priors.horizon_v_px = camera.cy + camera.fy * std::tan(pitch);
  priors.horizon_sigma_px = camera.fy * prior.pitch_rad.sigma / (std::cos(pitch) * std::cos(pitch));
  priors.horizon_slope = -std::tan(prior.roll_rad.value);
  return priors;
}

audit::ShotRecord with_refined(audit::ShotRecord record, const altitude::RefinedShot& refined) {
  record.pitch_deg = in_degrees(refined.pitch_rad);
  record.above_canopy_refined_m = refined.height_above_canopy_m;
  record.above_ground_refined_m = refined.height_above_ground_m;
  record.cross_track_m = refined.cross_track_m;
  record.heading_error_deg = in_degrees(refined.heading_rad);
  record.rows_used = refined.rows_used;
  record.status = refined.usable ? "ok" : "not_converged";
  record.reason = refined.usable ? "" : refined.termination;
  return record;
}

ShotResult process_shot(const telemetry::Shot& shot, const sync::ShotPose& pose, const Camera& camera,
                        const Project& project) {
  ShotResult result;
  result.record = record_of(shot, pose);
  const auto picture = image::read_image(shot.image);
  if (!picture.ok()) {
    set_unseen(result, picture.error(), project);
    return result;
  }
  auto carried = camera::carry_camera(camera, picture->width, picture->height);
  if (!carried.ok()) {
    set_unseen(result, carried.error(), project);
    return result;
  }
  result.camera = std::move(*carried);
  result.prior = prior_of(pose.state, project);
  rows::DetectOptions options;
  options.method = project.rows_method;
  options.priors = horizon_of(result.prior, *result.camera);
  const auto start = std::chrono::steady_clock::now();
  result.lines = rows::detect(*picture, options);
  result.elapsed_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  measure(result, *result.camera, project);
  if (project.depth) measure_depth(result, shot, project);
  return result;
}

}  // namespace furrow::project
