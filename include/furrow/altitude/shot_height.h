#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/altitude/unit_plane.h"
#include "furrow/camera/camera.h"
#include "furrow/geom/attitude.h"
#include "furrow/rows/row_lines.h"

namespace furrow::altitude {

/// Closed form: what the spacing alone tells (docs/formulation.md).
struct SpacingHeight {
  Estimate height_above_canopy_m;  ///< unusable when no spacing is known
  Estimate height_over_spacing;    ///< the same as a ratio; needs no farm number
  Estimate pitch_rad;              ///< from the vanishing point
  Estimate yaw_rad;                ///< camera against the rows, positive to the left
  Estimate cross_track_m;          ///< camera left of row 0, metres; unusable when no spacing is known
};

/// Needs two or more rows. `prior` fills in for the pitch where the rows are parallel in the picture (near
/// nadir). Errors: not_enough_rows, ill_conditioned, no_pitch (parallel rows and no prior).
Result<SpacingHeight> from_spacing(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                   const AttitudePrior& prior);

/// One shot's refinement.
struct RefinedShot {
  Estimate height_above_canopy_m;
  Estimate height_above_ground_m;  ///< plus the row height and its sigma
  Estimate pitch_rad, roll_rad, yaw_rad;
  Estimate cross_track_m;  ///< camera left of row 0
  Estimate row_spacing_m;
  Estimate half_width_m;
  /// Covariance of (height, pitch, roll, yaw, cross-track, spacing, half width, foliage depth); zero rows
  /// where held fixed.
  Eigen::MatrixXd covariance;
  int observations = 0;
  int iterations = 0;
  double residual_rms = 0.0;  ///< weighted; about 1 when the sigmas are right
  std::string termination = "never ran";
  bool usable = false;
};

struct RefineOptions {
  /// Scale of the Cauchy loss in sigmas.
  double robust_scale = 2.0;
  int max_iterations = 50;
};

/// Height, attitude and offset of one shot from its row centres and edges in pixels, through the full camera
/// model, with priors. Errors: as from_spacing, no_spacing, not_finite (names the input), solve_failed.
Result<RefinedShot> refine_shot(const rows::RowLines& lines, const Camera& camera,
                                const FieldKnowledge& field, const AttitudePrior& prior,
                                const RefineOptions& options = {});

}  // namespace furrow::altitude
