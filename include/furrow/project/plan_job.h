#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/plan.h"
#include "furrow/base/csv.h"
#include "furrow/project/jobs.h"

namespace furrow::project {

/// A lens as a data sheet or a calibration states it.
struct PlanLens {
  double focal_px = 0.0;                   ///< 0: from the two below
  double focal_mm = 0.0, sensor_mm = 0.0;  ///< focal length and width of the sensor
  int width_px = 0, height_px = 0;         ///< of the picture
};

/// A distortion-free camera with square pixels and its axis in the middle. Errors: bad_lens (which number is
/// missing or not above 0).
Result<Camera> plan_camera(const PlanLens& lens);

/// Camera and farm of a project, for plans; a project that calibrates is calibrated. `pitch_sigma_rad` is its
/// gimbal's.
struct PlanSource {
  Camera camera;
  altitude::FieldKnowledge field;
  double pitch_sigma_rad = 0.0;
};
Result<PlanSource> plan_source(const std::filesystem::path& project_file, const JobOptions& job = {});

struct PlanRequest {
  Camera camera;
  altitude::FieldKnowledge field;
  altitude::PlannedPose pose;
  altitude::PlanOptions options;
};

struct PlanOutcome {
  altitude::PlannedPose pose;
  /// What to expect of the pose; its error says why there is no height.
  Result<altitude::PlannedShot> shot = Error{"not_run", "plan", "not planned yet", "", ""};
  altitude::PlanAdvice advice;
  std::vector<std::string> words;  ///< the answer and what would be better, a sentence each
};

/// Plans the pose and its neighbours; with `out`, plan.csv, plan_budget.csv and the figures over pitch and
/// height. Errors: bad_pose, no_spacing, bad_field; no_plan (neither the pose nor any other tried has an
/// answer); those of writing.
Result<PlanOutcome> plan_job(const PlanRequest& request,
                             const std::optional<std::filesystem::path>& out = {});

/// plan_budget.csv: the planned pose's sigma by cause, with each part of the variance.
base::CsvTable plan_budget_table(const altitude::PlannedShot& shot);

/// plan.csv: every pose tried ("planned", "other pitch", "other height") with the sigmas to expect.
base::CsvTable plan_table(const PlanOutcome& outcome);

}  // namespace furrow::project
