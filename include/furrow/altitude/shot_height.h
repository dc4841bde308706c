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

/// Closed form: what the rows tell with one known length (docs/formulation/altitude.md, section 3).
struct SpacingHeight {
  Estimate height_above_canopy_m;  ///< unusable when no length is known
  Estimate height_over_spacing;    ///< the same as a ratio; needs no farm number, but two rows
  Estimate pitch_rad;              ///< from the vanishing point
  Estimate yaw_rad;                ///< camera against the rows, positive to the left
  Estimate cross_track_m;          ///< camera left of row 0, metres; unusable when no length is known
  /// Between the rows as the picture shows it, with the covariance with cross_track_m: the camera's
  /// cross-track from row k is cross_track_m + k row_spacing_m. Unusable when no length is known, or of a row
  /// alone.
  Estimate row_spacing_m;
  double cross_track_spacing_covariance_m2 = 0.0;
};

/// Needs two or more rows. Takes each row's far edge where edges are given: it is the top's silhouette
/// whatever the wall's shape. `prior` fills in for the pitch where the rows are parallel in the picture (near
/// nadir). Errors: not_enough_rows, ill_conditioned, no_pitch (parallel rows and no prior), not_finite and
/// bad_field (a farm's number that no farm can have, by name).
Result<SpacingHeight> from_spacing(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                   const AttitudePrior& prior);

/// The same with any length that is known: the spacing, a height above the canopy that something else
/// measured (of the rows' named top, like height_above_canopy_m), half the rows' width; the more the better.
/// A row alone will do when `prior` knows the pitch; then the spacing tells no metres, and those of a half
/// width alone are as rough as the row's edges. Nothing in metres is usable when no length is known. Errors:
/// as from_spacing.
Result<SpacingHeight> from_any_scale(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                     const AttitudePrior& prior, const Estimate& height_above_canopy_m);

/// One cause's share of a height's uncertainty; the squares of all shares add up to the square of the sigma.
struct SigmaShare {
  /// picture, plants, spacing, half_width, foliage, pitch, roll, focal, distortion, outline; in a flight also
  /// terrain (its mean slope) and other (the other shots' noise and the log's steps).
  std::string cause;
  double sigma_m = 0.0;  ///< negative where a correlation takes away from the sum
};

/// One shot's refinement.
struct RefinedShot {
  Estimate height_above_canopy_m;
  Estimate height_above_ground_m;  ///< plus the row height and its sigma
  Estimate pitch_rad, roll_rad,
      yaw_rad;  ///< geom::Attitude; yaw and roll lose their meaning within some degrees of nadir
  /// The picture's upward direction against the rows, positive to the left: yaw in the gimbal's order (yaw,
  /// roll, pitch). Equal to yaw_rad without roll, and sound at nadir too.
  Estimate heading_rad;
  Estimate cross_track_m;  ///< camera left of row 0
  /// What is added to the height above the rows' outline to give height_above_canopy_m
  /// (FieldKnowledge::outline_rise_m).
  Estimate outline_rise_m;
  Estimate row_spacing_m;
  Estimate half_width_m;
  Estimate foliage_depth_m;
  Estimate rounding_m;        ///< from the outline's highest point down to where the row is widest
  Estimate softness_m;        ///< length over which the leaves thin out (FieldKnowledge::softness_m)
  Estimate base_width_ratio;  ///< half width at the lowest leaves over half_width_m
  /// Covariance of (height, pitch, roll, yaw, cross-track, spacing, half width, foliage depth); zero rows
  /// where held fixed.
  Eigen::MatrixXd covariance;
  std::vector<SigmaShare> height_budget;  ///< of height_above_canopy_m, by cause
  /// Causes that all shots of the flight err by together, each independent of the others: metres by which one
  /// sigma of it moves this shot's height. Empty for a shot refined alone.
  std::vector<SigmaShare> height_shared;
  int rows_used = 0;      ///< rows that carry the result
  int rows_left_out = 0;  ///< rows found, but too far from the common field to belong to it
  int observations = 0;   ///< samples in the rows used
  int iterations = 0;
  double residual_rms = 0.0;  ///< weighted; about 1 when the sigmas are right
  std::string termination = "never ran";
  bool usable = false;
};

struct RefineOptions {
  /// Scale of the Cauchy loss of a row, in sigmas per observation: rows beyond it lose their pull while
  /// outliers are looked for.
  double robust_scale = 2.0;
  /// A row is left out of the final fit when its misfit has less than this chance for good rows.
  double outlier_chance = 1e-3;
  /// A prior that the picture contradicts by more than this many sigmas of their difference is an error,
  /// contradictory_priors.
  double prior_conflict_sigmas = 5.0;
  /// One-sigma of the angle between the rows' plane and level ground along the rows: gimbals measure against
  /// gravity, pictures against the rows. Added to the sigma of the pitch. Default: a vineyard terrace or a
  /// sown field within half a degree. More over hills; but where a picture shows two or three ragged rows
  /// only, the gimbal tells the pitch better than they do.
  double terrain_slope_sigma_rad = 0.0087;
  /// The same across the rows, added to the sigma of the roll. Default 3 deg: rows along a slope stand on up
  /// to 10 % without terraces, a sigma of 5 or 6 % if all of that is as likely, and less where fields are
  /// flat; two rows to each side tell the roll themselves, so that flat ground pays with little.
  double slope_across_sigma_rad = 0.0524;
  /// A height with a larger sigma than this part of itself is no answer but an error, height_open.
  double largest_relative_sigma = 0.5;
  /// Rows that miss every field of equally spaced rows by more than this many times their sigmas are no rows
  /// of one field: an error, rows_do_not_fit.
  double largest_misfit = 5.0;
  int max_iterations = 50;
};

/// The gimbal's angles against rows on ground that slopes: each sigma grows by the slope's
/// (RefineOptions::terrain_slope_sigma_rad, slope_across_sigma_rad). A roll that is not known is level as for
/// a camera held by hand, over the same slope.
AttitudePrior over_slope(AttitudePrior prior, const RefineOptions& options);

/// Height, attitude and offset of one shot from its row centres and edges in pixels, through the full camera
/// model, with priors. Rows are prisms with walls, so that an oblique view of a wall does not bias the height
/// (docs/formulation/altitude.md, section 5).
/// Errors: as from_spacing, no_spacing, contradictory_priors (names the prior), height_open, rows_do_not_fit,
/// not_finite (names the input), bad_field, solve_failed.
Result<RefinedShot> refine_shot(const rows::RowLines& lines, const Camera& camera,
                                const FieldKnowledge& field, const AttitudePrior& prior,
                                const RefineOptions& options = {});

/// Where the camera is over the rows.
struct RowOffset {
  Estimate cross_track_m;  ///< camera left of row 0
  Estimate yaw_rad;        ///< camera against the rows, positive to the left
  /// As SpacingHeight's: the cross-track from row k is cross_track_m + k row_spacing_m.
  Estimate row_spacing_m;
  double cross_track_spacing_covariance_m2 = 0.0;
};

/// The offset by whatever is known of spacing, height above the canopy and half width, from the rows that
/// were seen themselves: those which only the common field carries may not be there. By refine_shot where
/// there is a spacing and it has an answer, else by from_any_scale. Errors: as from_any_scale, no_metres
/// (no known length tells any), and bad_field (rows that overlap) with a spacing.
Result<RowOffset> offset_from_rows(const rows::RowLines& lines, const Camera& camera,
                                   const FieldKnowledge& field, const AttitudePrior& prior,
                                   const Estimate& height_above_canopy_m);

}  // namespace furrow::altitude
