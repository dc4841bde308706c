#include "relative_farm.h"

#include <algorithm>
#include <cmath>

#include "farm.h"

namespace furrow::altitude {

RelativeFarm relative_farm(const FieldKnowledge& field) {
  RelativeFarm r;
  // Without numbers: anywhere between no width and rows that touch.
  r.width_ratio = {0.25, 0.5 / std::sqrt(12.0), 0};
  const double s = field.row_spacing_m.value;
  if (field.row_spacing_m.usable() && field.half_width_m.usable() && s > 0.0) {
    const double w = field.half_width_m.value / s;
    const double relative =
        std::hypot(field.half_width_m.sigma / field.half_width_m.value, field.row_spacing_m.sigma / s);
    r.width_ratio = {w, std::max(w * relative, 1e-6), 0};
  }
  const bool metres = field.row_spacing_m.usable() && s > 0.0;
  r.log_top_depth = log_rounding(metres ? field : FieldKnowledge{}, r.width_ratio.value * (metres ? s : 1.0));
  r.wander.planting_sigma_m =
      metres && std::isfinite(field.planting_sigma_m) ? field.planting_sigma_m / s : kPlantingSigmaPerSpacing;
  r.wander.growth_sigma_m = metres && std::isfinite(field.growth_sigma_m)
                                ? field.growth_sigma_m / s
                                : kGrowthSigmaPerHalfWidth * r.width_ratio.value;
  return r;
}

}  // namespace furrow::altitude
