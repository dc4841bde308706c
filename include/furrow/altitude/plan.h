#pragma once
#include <cstdint>
#include <vector>

#include "furrow/altitude/shot_height.h"

namespace furrow::altitude {

/// A shot that has not been flown.
struct PlannedPose {
  double height_above_canopy_m = 2.0;
  double pitch_rad = -0.35;  ///< negative below the horizon
  double heading_rad = 0.0;  ///< against the rows, positive to the left
  double cross_track_m = 0.0;
};

struct PlanOptions {
  /// One-sigma of an edge of leaves in the picture, and its correlation from one cut to the next (10 px
  /// apart). Defaults: leaves of a vine at 3 m scatter an edge by some pixels over tens of pixels.
  double edge_sigma_px = 3.0;
  double edge_correlation = 0.7;
  /// What the gimbal is trusted to, bias included.
  double pitch_sigma_rad = 0.0175;
  double roll_sigma_rad = 0.0087;
  /// Whether the detector tells a row's edge against the leaves of the next row, not only against soil.
  bool leaf_against_leaf = false;
  /// Rows narrower than this in the picture are not found.
  double narrowest_px = 6.0;
  RefineOptions refine;
};

/// What to expect of it.
struct PlannedShot {
  PlannedPose pose;
  Estimate height_above_canopy_m;  ///< the planned height with the sigma to expect
  double cross_track_sigma_m = 0.0;
  double pitch_sigma_rad = 0.0;
  std::vector<SigmaShare> height_budget;
  int rows_used = 0;
};

/// Sigma to expect of refine_shot for this camera (with its covariance, when it has one), pose and field: the
/// refinement itself on rows drawn by the prism model with noise of a fixed seed
/// (docs/formulation/altitude.md, section 10). Errors: as refine_shot; bad_pose (height not above 0, pitch
/// outside -90..0 deg, not finite).
Result<PlannedShot> plan_shot(const Camera& camera, const PlannedPose& pose, const FieldKnowledge& field,
                              const PlanOptions& options = {});

/// Plans of the same shot at other pitches (every 5 deg from -10 to -90) and at other heights (half to
/// double, in ten steps), each in order; poses without an answer are left out. The best is the one with the
/// smallest sigma relative to its height.
struct PlanAdvice {
  std::vector<PlannedShot> by_pitch, by_height;
  std::optional<PlannedShot> best_pitch, best_height;
};
PlanAdvice plan_advice(const Camera& camera, const PlannedPose& pose, const FieldKnowledge& field,
                       const PlanOptions& options = {});

}  // namespace furrow::altitude
