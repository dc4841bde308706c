#include "furrow/project/plan_job.h"

#include <cmath>

#include "furrow/audit/budget.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/figures/stacked.h"
#include "furrow/geom/angles.h"
#include "project/calibration_outputs.h"

namespace furrow::project {
namespace {

using altitude::PlannedShot;
using base::format_fixed;
using geom::rad_to_deg;

double relative_sigma(const PlannedShot& shot) {
  return shot.height_above_canopy_m.sigma / shot.height_above_canopy_m.value;
}

std::string percent(double share) {
  return format_fixed(100.0 * share, 1) + " %";
}

std::string pose_words(const altitude::PlannedPose& pose) {
  return format_fixed(pose.height_above_canopy_m, 2) + " m above the canopy at " +
         format_fixed(rad_to_deg(pose.pitch_rad), 1) + " deg";
}

audit::ShotBudget budget_of(const PlannedShot& shot) {
  return {"planned", shot.height_above_canopy_m, shot.height_budget};
}

std::string expected_words(const PlanOutcome& outcome) {
  if (!outcome.shot.ok())
    return pose_words(outcome.pose) + " gives no height: " + outcome.shot.error().message();
  const PlannedShot& shot = *outcome.shot;
  const auto causes = audit::causes_of({budget_of(shot)});
  return pose_words(shot.pose) + ": expect a sigma of " + format_fixed(shot.height_above_canopy_m.sigma, 3) +
         " m (" + percent(relative_sigma(shot)) + " of the height) for a shot alone; most of it is " +
         audit::cause_words(causes.at(0).cause) + " (" + format_fixed(100.0 * causes[0].variance_share, 0) +
         " % of the variance).";
}

/// A pose that is worth a change of plan, or the word that none is.
std::string better_words(const PlanOutcome& outcome, const std::optional<PlannedShot>& best,
                         const std::string& what) {
  constexpr double kWorthIt = 0.95;  // of the planned sigma
  if (!best) return "No other " + what + " gives a height.";
  if (outcome.shot.ok() && relative_sigma(*best) > kWorthIt * relative_sigma(*outcome.shot))
    return "No other " + what + " that was tried is clearly better.";
  return "A better " + what + ": " + pose_words(best->pose) + " with " + percent(relative_sigma(*best)) +
         " of the height.";
}

std::vector<std::string> plan_row(const std::string& scan, const PlannedShot& shot) {
  return {scan,
          format_fixed(shot.pose.height_above_canopy_m, 3),
          format_fixed(rad_to_deg(shot.pose.pitch_rad), 1),
          format_fixed(shot.height_above_canopy_m.sigma, 4),
          format_fixed(100.0 * relative_sigma(shot), 2),
          format_fixed(shot.cross_track_sigma_m, 4),
          format_fixed(rad_to_deg(shot.pitch_sigma_rad), 3),
          std::to_string(shot.rows_used)};
}

Status write_plan(const PlanOutcome& outcome, const std::filesystem::path& out) {
  FURROW_DO(base::write_file(out / "plan.csv", base::to_csv(plan_table(outcome))));
  if (outcome.shot.ok()) {
    FURROW_DO(base::write_file(out / "plan_budget.csv", base::to_csv(plan_budget_table(*outcome.shot))));
  }
  for (const auto& made : {figures::plan_over_pitch(outcome.advice.by_pitch),
                           figures::plan_over_height(outcome.advice.by_height)}) {
    if (!made.ok() && made.error().code == "nothing_to_draw") continue;
    FURROW_TRY(const figures::Figure figure, made);
    FURROW_DO(figures::write_figure(out, figure));
  }
  return Done{};
}

}  // namespace

Result<Camera> plan_camera(const PlanLens& lens) {
  const bool by_sensor = lens.focal_mm > 0.0 && lens.sensor_mm > 0.0;
  if (!(lens.width_px > 0 && lens.height_px > 0))
    return Error{"bad_lens", "camera", "no picture size", "width and height in px", ""};
  if (!(lens.focal_px > 0.0) && !by_sensor) {
    return Error{"bad_lens", "camera", "no focal length",
                 "a camera file, or a focal length in px, or in mm with the sensor's width", ""};
  }
  Camera camera;
  camera.model = camera::CameraModel::pinhole;
  camera.width = lens.width_px;
  camera.height = lens.height_px;
  camera.fx = camera.fy =
      lens.focal_px > 0.0 ? lens.focal_px : lens.focal_mm * lens.width_px / lens.sensor_mm;
  camera.cx = 0.5 * (lens.width_px - 1);
  camera.cy = 0.5 * (lens.height_px - 1);
  camera.provenance = "stated for a plan";
  FURROW_DO(camera::validate(camera));
  return camera;
}

Result<PlanSource> plan_source(const std::filesystem::path& project_file, const JobOptions& job) {
  FURROW_TRY(const Project project, read_project(project_file));
  FURROW_TRY(const ProjectCamera camera, camera_of(project, job));
  return PlanSource{camera.camera, project.field, geom::deg_to_rad(project.gimbal_pitch_sigma_deg)};
}

base::CsvTable plan_budget_table(const PlannedShot& shot) {
  base::CsvTable table;
  table.source = "plan_budget.csv";
  table.columns = {"cause", "sigma_m", "variance_percent"};
  for (const audit::CauseShare& share : audit::causes_of({budget_of(shot)})) {
    constexpr double kShown = 0.0005;
    if (std::abs(share.variance_share) < kShown) continue;
    const double sigma = std::copysign(
        shot.height_above_canopy_m.sigma * std::sqrt(std::abs(share.variance_share)), share.variance_share);
    table.rows.push_back(
        {share.cause, format_fixed(sigma, 4), format_fixed(100.0 * share.variance_share, 1)});
  }
  return table;
}

base::CsvTable plan_table(const PlanOutcome& outcome) {
  base::CsvTable table;
  table.source = "plan.csv";
  table.columns = {"scan",          "above_canopy_m",      "pitch_deg",       "sigma_m",
                   "sigma_percent", "cross_track_sigma_m", "pitch_sigma_deg", "rows_used"};
  if (outcome.shot.ok()) table.rows.push_back(plan_row("planned", *outcome.shot));
  for (const PlannedShot& shot : outcome.advice.by_pitch) table.rows.push_back(plan_row("other pitch", shot));
  for (const PlannedShot& shot : outcome.advice.by_height)
    table.rows.push_back(plan_row("other height", shot));
  return table;
}

Result<PlanOutcome> plan_job(const PlanRequest& request, const std::optional<std::filesystem::path>& out) {
  PlanOutcome outcome;
  outcome.pose = request.pose;
  outcome.shot = altitude::plan_shot(request.camera, request.pose, request.field, request.options);
  if (!outcome.shot.ok()) {
    // What no other pose can mend.
    for (const char* code : {"bad_pose", "no_spacing", "bad_field", "not_finite"}) {
      if (outcome.shot.error().code == code) return outcome.shot.error();
    }
  }
  outcome.advice = altitude::plan_advice(request.camera, request.pose, request.field, request.options);
  if (!outcome.shot.ok() && !outcome.advice.best_pitch && !outcome.advice.best_height) {
    return Error{"no_plan", "plan",
                 "neither this pose nor another pitch or height gives one: " + outcome.shot.error().message(),
                 "rows that the picture can resolve", "check the numbers of camera and rows"};
  }
  outcome.words = {expected_words(outcome), better_words(outcome, outcome.advice.best_pitch, "pitch"),
                   better_words(outcome, outcome.advice.best_height, "height")};
  if (out) FURROW_DO(write_plan(outcome, *out));
  return outcome;
}

}  // namespace furrow::project
