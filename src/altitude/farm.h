#pragma once
#include <limits>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/base/result.h"

namespace furrow::altitude {

/// FieldKnowledge with every gap filled by what holds for any row crop, widely (docs/formulation/altitude.md,
/// section 6).
struct Farm {
  Estimate row_spacing_m, half_width_m, foliage_depth_m, base_width_ratio;
  /// Logarithms of FieldKnowledge::rounding_m and softness_m over the half width.
  Estimate rounding, softness;
  double planting_sigma_m = 0.0, growth_sigma_m = 0.0, foot_sigma_m = 0.0;
  bool half_width_given = false, foliage_depth_given = false, base_ratio_given = false,
       rounding_given = false, softness_given = false;
};

/// Errors: not_finite, bad_field (not above 0, or rows that overlap), each naming the quantity. Nothing need
/// be known.
Status sound_field(const FieldKnowledge& field);

/// Errors: as sound_field, no_spacing.
Result<Farm> complete_farm(const FieldKnowledge& field);

/// What the pictures tell of a canopy's outline.
struct CanopyShape {
  double half_width_m = 0.0, rounding_m = 0.0, softness_m = 0.0;
  /// outline_roughness_m; NaN counts as ragged.
  double roughness_m = std::numeric_limits<double>::quiet_NaN();
};

/// How far the rows' outline stands above their top (FieldKnowledge::outline_rise_m; eq. 8.7 and 8.8).
Estimate outline_rise(const FieldKnowledge& field, const CanopyShape& shape);

/// Logarithm of the rounded top's depth over the half width, with what stands in where it is not known.
Estimate log_rounding(const FieldKnowledge& field, double half_width_m);
/// The same of the length over which its leaves thin out.
Estimate log_softness(const FieldKnowledge& field, double half_width_m);

}  // namespace furrow::altitude
