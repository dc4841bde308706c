#pragma once
#include <limits>

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
  /// How far the rows' outline in the picture lies above the top that row_height_m names, in a picture taken
  /// at -45 deg: the flatter the line of sight, the more leaves stand in it, and the highest is seen. Grows
  /// with the cotangent of the depression; 0 for smooth boxes, negative where row_height_m names the tips of
  /// the shoots. Unusable: 0 +- kOutlineRiseSigmaPerHalfWidth.
  Estimate outline_rise_m;
  /// One-sigma of a row's axis about its nominal place, as a whole along the part a picture shows. NaN:
  /// kPlantingSigmaPerSpacing.
  double planting_sigma_m = std::numeric_limits<double>::quiet_NaN();
  /// One-sigma of a row's own half width about half_width_m, likewise. NaN: kGrowthSigmaPerHalfWidth.
  double growth_sigma_m = std::numeric_limits<double>::quiet_NaN();
};

/// Rows set out with RTK or by tape and posts lie within 2 to 3 cm of their place at 3 m spacing: one
/// hundredth.
inline constexpr double kPlantingSigmaPerSpacing = 0.01;
/// Mean half width of one row over a picture against the field's: trimmed hedges repeat to 3 cm in 0.6 m.
inline constexpr double kGrowthSigmaPerHalfWidth = 0.05;

/// With the mean of the leaves first hit from above called the top, heights by the outline came out 0 to 1 cm
/// over cot short in Furrow's renders and 2.5 to 3.5 cm short in another program's; with the highest leaves
/// called the top 2.5 to 4 cm long, all at a half width of 0.6 m (docs/formulation/altitude.md, section 8).
inline constexpr double kOutlineRiseSigmaPerHalfWidth = 0.04;

/// What the gimbal says about one shot, with one-sigma; unusable values are not known.
struct AttitudePrior {
  Estimate pitch_rad;  ///< negative below the horizon
  Estimate roll_rad;
};

}  // namespace furrow::altitude
