#pragma once
#include "furrow/base/result.h"

namespace furrow::altitude {

/// L = half width x f / pix: slant distance to the row at the picture's middle (thesis, section 5).
/// Errors: bad_width (half widths not above 0).
Result<double> thesis_slant_distance_m(double half_width_m, double focal_px, double half_width_px);

/// H = L sin(depression): height above the canopy; `pitch_rad` is the gimbal's, negative below the horizon.
/// Errors: bad_pitch (not below the horizon).
Result<double> thesis_height_above_canopy_m(double slant_distance_m, double pitch_rad);

}  // namespace furrow::altitude
