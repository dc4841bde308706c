#pragma once
#include <optional>
#include <string>

#include "furrow/altitude/shot_height.h"
#include "furrow/audit/shot_record.h"
#include "furrow/camera/camera.h"
#include "furrow/project/project.h"
#include "furrow/rows/detect.h"
#include "furrow/rows/row_lines.h"
#include "furrow/sync/locate.h"
#include "furrow/telemetry/shot.h"
#include "project/fusion.h"

namespace furrow::project {

/// How a shot's rows are refined for this farm.
altitude::RefineOptions refine_options(const Project& project);

/// One shot's way through the stages; nothing edits an earlier stage's result.
struct ShotResult {
  audit::ShotRecord record;
  rows::RowLines lines;
  altitude::AttitudePrior prior;
  VisionHeight vision;                       ///< of this shot alone
  VisionHeight depth;                        ///< of its depth map
  std::string depth_reason;                  ///< why a map that is there gives no height
  std::vector<altitude::SigmaShare> budget;  ///< of the height of this shot alone
  std::optional<Camera> camera;  ///< at this picture's size; nothing when it could not be carried there
  double elapsed_ms = 0.0;       ///< of the row detection
};

/// Picture and log -> rows -> heights. Never fails: what stopped it stands in record.status and
/// record.reason.
ShotResult process_shot(const telemetry::Shot& shot, const sync::ShotPose& pose, const Camera& camera,
                        const Project& project);

/// Where the gimbal's angles put the horizon. Without a lens: the horizon is often outside the picture, where
/// no lens model holds. Nothing near nadir or without a pitch.
rows::Priors horizon_of(const altitude::AttitudePrior& prior, const Camera& camera);

/// The thesis's height above the canopy from a half width at the picture's middle row, px; without a sigma,
/// as the thesis gives none. Unusable without the row's half width in metres and the gimbal's pitch.
Estimate thesis_height(double half_width_px, const Camera& camera, const altitude::FieldKnowledge& field,
                       const altitude::AttitudePrior& prior);

/// The record with a refinement's height, attitude and offset in it.
audit::ShotRecord with_refined(audit::ShotRecord record, const altitude::RefinedShot& refined);

}  // namespace furrow::project
