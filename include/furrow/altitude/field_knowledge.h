#pragma once
#include <algorithm>
#include <limits>

#include "furrow/base/result.h"
#include "furrow/stats/estimate.h"

namespace furrow::altitude {

/// What the farm knows about its rows: each value with its one-sigma. A sigma of 0 means exactly known.
struct FieldKnowledge {
  Estimate row_spacing_m;  ///< between neighbouring row centres; unusable when not known
  Estimate half_width_m;   ///< half the width of the canopy at its widest, seen from above
  Estimate row_height_m;   ///< top of the canopy above the soil
  /// From the top of the canopy down to its lowest leaves; unusable when not known.
  Estimate foliage_depth_m;
  /// Half width at the lowest leaves over half_width_m: 1 for a box, near 0 for a V; unusable when not known.
  Estimate base_width_ratio;
  /// From the outline's highest point down to where the row is widest: 0 for a box's flat top. Unusable:
  /// kRoundingPerHalfWidth, by a factor of exp(kLogRoundingSigma) more or less.
  Estimate rounding_m;
  /// Length over which the leaves thin out e-fold at the edge of the canopy: by so much the outline swells
  /// where a line of sight meets e times as many of them. 0 for trimmed hedges. Unusable:
  /// kSoftnessPerHalfWidth, by a factor of exp(kLogSoftnessSigma) more or less.
  Estimate softness_m;
  /// How far the outline's highest point lies above the top that row_height_m names: a picture shows the
  /// outline. 0 for smooth boxes, near 0 where row_height_m names the highest leaves, most where it names the
  /// mean of the leaves first hit from above. Unusable: what the rounding makes and kOutlineRisePerLeaf, with
  /// a sigma by the softness.
  Estimate outline_rise_m;
  /// One-sigma of a row's axis about its nominal place, as a whole along the part a picture shows. NaN:
  /// kPlantingSigmaPerSpacing.
  double planting_sigma_m = std::numeric_limits<double>::quiet_NaN();
  /// One-sigma of a row's own half width about half_width_m, likewise. NaN: kGrowthSigmaPerHalfWidth.
  double growth_sigma_m = std::numeric_limits<double>::quiet_NaN();
};

/// Error bad_field when rows would overlap, even one sigma narrower: then a whole width was taken for half of
/// one.
Status rows_apart(const FieldKnowledge& field);

/// Rows set out with RTK or by tape and posts lie within 2 to 3 cm of their place at 3 m spacing: one
/// hundredth.
inline constexpr double kPlantingSigmaPerSpacing = 0.01;
/// Mean half width of one row over a picture against the field's: trimmed hedges repeat to 3 cm in 0.6 m.
inline constexpr double kGrowthSigmaPerHalfWidth = 0.05;

/// Ellipses fitted to the far edges of 36 rendered flights at their true poses were 0.14 to 1.7 half widths
/// deep (docs/formulation/altitude.md, section 5): half a width, within a factor of two.
inline constexpr double kRoundingPerHalfWidth = 0.5;
inline constexpr double kLogRoundingSigma = 0.7;

/// Over rendered plants leaves thinned out over 0.03 to 0.16 half widths, over opaque renders over less than
/// 0.03 (section 5): 0.05, within a factor of three.
inline constexpr double kSoftnessPerHalfWidth = 0.05;
inline constexpr double kLogSoftnessSigma = 1.2;

/// Outlines are ragged by the reach of a leaf, which does not grow with the row: vine leaves are 10 to 15 cm
/// across. A row that is narrower is as wide as its leaves reach.
inline constexpr double kLeafReach_m = 0.12;
constexpr double leaf_reach_m(double half_width_m) {
  return std::min(half_width_m, kLeafReach_m);
}
/// Highest points of outlines lay over the named top by 0.3 leaves (0.04 m) where that is the highest leaf,
/// 1.1 in Furrow's renders, 2.6 where it is the mean of the leaves first hit from above (section 8). Of the
/// middle one, which is half a width deep, the rounding makes (1 - pi/4) 0.3 m = 0.06 m and this is the rest,
/// that of ragged leaves.
inline constexpr double kOutlineRisePerLeaf = 0.6;
/// One-sigma of that: firm outlines rise by 0 (smooth walls) to 0.8 leaves (Furrow's ragged but opaque
/// renders); where leaves thin out, the highest one and the mean of those first hit lie 5 to 13 times that
/// length apart, which evenly spread is 3.5 times it; never more than a leaf and a half.
inline constexpr double kFirmOutlineRiseSigmaPerLeaf = 0.4;
inline constexpr double kOutlineRiseSigmaPerSoftness = 3.5;
inline constexpr double kMostOutlineRiseSigmaPerLeaf = 1.5;
/// Far edges of leaves, rendered by two programs, wander by 0.06 half widths along the rows and more (those
/// of a trimmed hedge by 0.035), those of smooth solids by less than 0.03: below, leaves add less to the
/// rise.
inline constexpr double kRaggedPerHalfWidth = 0.05;
/// One-sigma of the rise of ragged leaves over the top that words name (eq. 8.8).
constexpr double ragged_rise_sigma_m(double half_width_m, double softness_m) {
  const double leaf_m = leaf_reach_m(half_width_m);
  return std::min(kFirmOutlineRiseSigmaPerLeaf * leaf_m + kOutlineRiseSigmaPerSoftness * softness_m,
                  kMostOutlineRiseSigmaPerLeaf * leaf_m);
}

/// The same of rows whose softness no picture tells. Rows of unknown width may be of any: as much as leaves
/// make.
constexpr double typical_rise_sigma_m(double half_width_m = std::numeric_limits<double>::infinity()) {
  return ragged_rise_sigma_m(half_width_m, kSoftnessPerHalfWidth * half_width_m);
}

/// What the gimbal says about one shot, with one-sigma; unusable values are not known.
struct AttitudePrior {
  Estimate pitch_rad;  ///< negative below the horizon
  Estimate roll_rad;
};

}  // namespace furrow::altitude
