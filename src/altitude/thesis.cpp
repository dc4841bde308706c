#include "furrow/altitude/thesis.h"

#include <cmath>

#include "furrow/base/text.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

bool positive(double x) {
  return std::isfinite(x) && x > 0.0;
}

}  // namespace

Result<double> thesis_slant_distance_m(double half_width_m, double focal_px, double half_width_px) {
  if (!positive(half_width_m) || !positive(focal_px) || !positive(half_width_px)) {
    return Error{"bad_width", "thesis slant distance",
                 "half width " + base::format_double(half_width_m) + " m, " +
                     base::format_double(half_width_px) + " px, focal length " +
                     base::format_double(focal_px) + " px",
                 "finite lengths above 0", ""};
  }
  return half_width_m * focal_px / half_width_px;
}

Result<double> thesis_height_above_canopy_m(double slant_distance_m, double pitch_rad) {
  const bool below_horizon = std::isfinite(pitch_rad) && pitch_rad < 0.0 && pitch_rad >= -geom::kPi / 2.0;
  if (!below_horizon || !positive(slant_distance_m)) {
    return Error{"bad_pitch", "thesis height",
                 "pitch " + base::format_double(geom::rad_to_deg(pitch_rad)) + " deg, slant distance " +
                     base::format_double(slant_distance_m) + " m",
                 "a pitch below the horizon, at least -90 deg, and a distance above 0", ""};
  }
  return slant_distance_m * std::sin(-pitch_rad);
}

}  // namespace furrow::altitude
