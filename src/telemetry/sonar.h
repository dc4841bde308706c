#pragma once
#include "furrow/telemetry/track.h"

namespace furrow::telemetry {

/// When a sonar or vision height without a validity flag may be believed. DJI's repeats its last value when
/// it loses the ground: 12.1 m up to 119 m height on a Mavic 2, 0.4 m at 100 m on a Matrice 350.
struct SonarRule {
  double ceiling_m =
      10.0;  ///< readings and barometric heights above this are not used (DJI's stated sensor range)
  double held_change_m = 0.5;  ///< a run of equal readings is "held" when the barometer moves by more (5 of
                               ///< its 0.1 m steps) in it
  double held_unseen_s = 1.0;  ///< and, where no barometric height can tell, when it lasts longer
};

/// Sets height_vps_m to NaN where the rule does not trust it, and says how often:
///   reading <= 0 or > ceiling_m;  height_takeoff_m > ceiling_m;
///   any row of a run of exactly equal readings over which height_takeoff_m spans more than held_change_m.
void distrust_held_sonar(Track& track, const SonarRule& rule = {});

}  // namespace furrow::telemetry
