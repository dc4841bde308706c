#pragma once
#include "furrow/stats/estimate.h"

namespace furrow::altitude {

/// What the farm knows about its rows: each value with its one-sigma. A sigma of 0 means exactly known.
struct FieldKnowledge {
  Estimate row_spacing_m;  ///< between neighbouring row centres; unusable when not known
  Estimate half_width_m;   ///< half the width of the canopy at its widest, seen from above
  Estimate row_height_m;   ///< top of the canopy above the soil
  Estimate
      foliage_depth_m;  ///< from the top of the canopy down to its lowest leaves; unusable when not known
};

/// What the gimbal says about one shot, with one-sigma; unusable values are not known.
struct AttitudePrior {
  Estimate pitch_rad;  ///< negative below the horizon
  Estimate roll_rad;
};

}  // namespace furrow::altitude
