#include "farm.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "furrow/base/text.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

/// Standard deviation of a uniform distribution over [0, 1].
const double kUniformSigma = 1.0 / std::sqrt(12.0);
/// A sigma of 0 means exactly known; a solver needs a number above 0, small against anything that matters.
constexpr double kExactRelativeSigma = 1e-7;

/// The middle of [0, upper], as wide as that whole range.
Estimate anywhere_up_to(double upper) {
  return {0.5 * upper, kUniformSigma * upper, 0};
}

Status finite_or_unknown(const char* name, const Estimate& value) {
  if (std::isnan(value.value)) return Done{};
  if (std::isfinite(value.value) && std::isfinite(value.sigma) && value.sigma >= 0.0) return Done{};
  return Error{"not_finite", name,
               base::format_double(value.value) + " with sigma " + base::format_double(value.sigma),
               "a finite value with a finite sigma, or NaN for not known", ""};
}

Status above_zero_or_unknown(const char* name, const Estimate& value) {
  FURROW_DO(finite_or_unknown(name, value));
  if (!(value.value <= 0.0)) return Done{};
  return Error{"bad_field", name, base::format_double(value.value), "a length above 0", ""};
}

/// Logarithm of a length over the half width, or what stands in where it is not known.
Estimate log_part(const Estimate& length_m, double half_width_m, const Estimate& unknown) {
  constexpr double kNone = 1e-6;  // of the half width: stands for 0
  if (!length_m.usable()) return unknown;
  const double length = std::max(length_m.value, kNone * half_width_m);
  return {std::log(length / half_width_m), std::max(length_m.sigma / length, kExactRelativeSigma),
          length_m.observations};
}

Estimate with_positive_sigma(Estimate e) {
  e.sigma = std::max(e.sigma, kExactRelativeSigma * e.value);
  return e;
}

/// The rise of a canopy as ragged as leaves make it (eq. 8.8).
Estimate ragged_rise(const CanopyShape& shape) {
  // The mean height of half an ellipse of depth r is pi/4 r; of a box it is r, of a gable r/2.
  const double over_mean_m = (1.0 - geom::kPi / 4.0) * shape.rounding_m;
  const double by_shape_m = 0.5 * kUniformSigma * shape.rounding_m;
  const double sigma_m = ragged_rise_sigma_m(shape.half_width_m, shape.softness_m);
  return {kOutlineRisePerLeaf * leaf_reach_m(shape.half_width_m) + over_mean_m,
          std::hypot(sigma_m, by_shape_m), 0};
}

/// The rise of a smooth surface, whose top is beyond doubt (eq. 8.10): 0 over a round one; over a flat one
/// the ellipse, which the prior keeps from being flat, lifts its highest point by most of its depth.
Estimate smooth_rise(const CanopyShape& shape) {
  constexpr double kLifted = 0.7;     // (w - W(t)) / t over r, for t of 1 to 2
  constexpr double kFlatUpTo = 0.7;   // half widths: no flat top passes for a deeper ellipse
  constexpr double kOpenUpTo = 0.35;  // half widths: shallower ones may be flat or round alike
  const double deepest_m = kFlatUpTo * shape.half_width_m;
  const double flat_part = std::max(0.0, 1.0 - shape.rounding_m / deepest_m);
  const double open_m = std::min(shape.rounding_m, kOpenUpTo * shape.half_width_m);
  return {kLifted * shape.rounding_m * flat_part, 0.5 * kLifted * open_m, 0};
}

/// How far the outline is as ragged as leaves make it, 0 to 1 (eq. 8.9).
double raggedness(const CanopyShape& shape) {
  if (!std::isfinite(shape.roughness_m)) return 1.0;
  return std::min(1.0, shape.roughness_m / (kRaggedPerHalfWidth * shape.half_width_m));
}

}  // namespace

Status rows_apart(const FieldKnowledge& field) {
  const Estimate &w = field.half_width_m, &s = field.row_spacing_m;
  if (!(w.value - w.sigma > 0.5 * s.value)) return Done{};
  return Error{"bad_field", "half_width_m",
               base::format_double(w.value) + " for rows " + base::format_double(s.value) + " m apart",
               "at most half of that", "It is half the width of one row's canopy."};
}

Status sound_field(const FieldKnowledge& field) {
  FURROW_DO(above_zero_or_unknown("row_spacing_m", field.row_spacing_m));
  FURROW_DO(above_zero_or_unknown("half_width_m", field.half_width_m));
  FURROW_DO(above_zero_or_unknown("row_height_m", field.row_height_m));
  FURROW_DO(above_zero_or_unknown("foliage_depth_m", field.foliage_depth_m));
  FURROW_DO(above_zero_or_unknown("base_width_ratio", field.base_width_ratio));
  FURROW_DO(finite_or_unknown("outline_rise_m", field.outline_rise_m));
  FURROW_DO(finite_or_unknown("rounding_m", field.rounding_m));
  FURROW_DO(finite_or_unknown("softness_m", field.softness_m));
  return rows_apart(field);
}

Result<Farm> complete_farm(const FieldKnowledge& field) {
  FURROW_DO(sound_field(field));
  if (!field.row_spacing_m.usable()) {
    return Error{"no_spacing", "row_spacing_m", "no row spacing",
                 "the distance between row centres in metres",
                 "from_spacing still gives height over spacing"};
  }
  const bool width = field.half_width_m.usable(), height = field.row_height_m.usable(),
             depth = field.foliage_depth_m.usable(), ratio = field.base_width_ratio.usable();
  const double s = field.row_spacing_m.value;
  Farm farm;
  farm.half_width_given = width;
  farm.foliage_depth_given = depth;
  farm.base_ratio_given = ratio;
  farm.row_spacing_m = with_positive_sigma(field.row_spacing_m);
  farm.half_width_m = with_positive_sigma(width ? field.half_width_m : anywhere_up_to(0.5 * s));
  // Growers keep rows no higher than the alley is wide, or the next row stands in shade (Smart and Robinson
  // 1991).
  const double deepest = height ? field.row_height_m.value : s;
  farm.foliage_depth_m = with_positive_sigma(depth ? field.foliage_depth_m : anywhere_up_to(deepest));
  farm.base_width_ratio = with_positive_sigma(ratio ? field.base_width_ratio : anywhere_up_to(1.0));
  farm.rounding_given = field.rounding_m.usable();
  farm.rounding = log_rounding(field, farm.half_width_m.value);
  farm.softness_given = field.softness_m.usable();
  farm.softness = log_softness(field, farm.half_width_m.value);
  farm.planting_sigma_m =
      std::isfinite(field.planting_sigma_m) ? field.planting_sigma_m : kPlantingSigmaPerSpacing * s;
  farm.growth_sigma_m = std::isfinite(field.growth_sigma_m)
                            ? field.growth_sigma_m
                            : kGrowthSigmaPerHalfWidth * farm.half_width_m.value;
  // Where a wall's green seems to end is anywhere between its top and its lowest leaves: uniform over [0, d],
  // taken about d (eq. 5.4).
  farm.foot_sigma_m = farm.foliage_depth_m.value / std::sqrt(3.0);
  return farm;
}

Estimate outline_rise(const FieldKnowledge& field, const CanopyShape& shape) {
  if (field.outline_rise_m.usable()) return field.outline_rise_m;
  const Estimate ragged = ragged_rise(shape);
  const Estimate smooth = field.rounding_m.usable() ? Estimate{0.0, 0.0, 0} : smooth_rise(shape);
  const double part = raggedness(shape);
  return {part * ragged.value + (1.0 - part) * smooth.value,
          std::hypot(ragged.sigma, (1.0 - part) * smooth.sigma), 0};
}

Estimate log_rounding(const FieldKnowledge& field, double half_width_m) {
  return log_part(field.rounding_m, half_width_m, {std::log(kRoundingPerHalfWidth), kLogRoundingSigma, 0});
}

Estimate log_softness(const FieldKnowledge& field, double half_width_m) {
  return log_part(field.softness_m, half_width_m, {std::log(kSoftnessPerHalfWidth), kLogSoftnessSigma, 0});
}

}  // namespace furrow::altitude
