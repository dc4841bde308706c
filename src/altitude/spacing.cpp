#include <algorithm>
#include <cmath>
#include <optional>

#include "farm.h"
#include "furrow/altitude/shot_height.h"
#include "pencil.h"

namespace furrow::altitude {
namespace {

/// Places in Scale's vector.
constexpr int kA = 0, kB = 1, kG = 2, kDrop = 3, kRise = 4;
using ScaleVector = Eigen::Matrix<double, 5, 1>;

/// The pencil in metres: a, b, g, drop to the rows' outline, and the outline's rise over the named top
/// (eq. 3.10).
struct Scale {
  ScaleVector value = ScaleVector::Zero();
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();

  double covariance_of(const ScaleVector& one, const ScaleVector& other) const {
    return one.dot(covariance * other);
  }
  double sigma_of(const ScaleVector& gradient) const {
    return std::sqrt(std::max(0.0, covariance_of(gradient, gradient)));
  }
  /// The drop as what `gradient` of the others and an independent sigma make it.
  void set_drop(double drop, const ScaleVector& gradient, double sigma) {
    value[kDrop] = drop;
    covariance.row(kDrop) = (covariance * gradient).transpose();
    covariance.col(kDrop) = covariance.row(kDrop).transpose();
    covariance(kDrop, kDrop) = covariance_of(gradient, gradient) + sigma * sigma;
  }
  /// One more independent measurement that differs from the value by `misfit` (eq. 3.11).
  void measure(const ScaleVector& gradient, double misfit, double sigma) {
    const ScaleVector shared = covariance * gradient;
    const double variance = gradient.dot(shared) + sigma * sigma;
    value += shared * (misfit / variance);
    covariance -= shared * shared.transpose() / variance;
  }
};

ScaleVector unit(int place) {
  return ScaleVector::Unit(place);
}

Estimate rise_at(const FieldKnowledge& field, double half_width) {
  const auto part = [&](const Estimate& log_part) { return half_width * std::exp(log_part.value); };
  return outline_rise(
      field, {half_width, part(log_rounding(field, half_width)), part(log_softness(field, half_width))});
}

/// Nothing where no metres are known, or those that are leave the camera under the rows.
std::optional<Scale> scale_of(const Pencil& pencil, const FieldKnowledge& field, const Estimate& height) {
  Scale s;
  s.value.head<3>() = pencil.value.segment<3>(kPencilA);
  s.covariance.topLeftCorner<3, 3>() = pencil.covariance.block<3, 3>(kPencilA, kPencilA);
  const double b = s.value[kB], g = s.value[kG];
  const Estimate &spacing = field.row_spacing_m, &width = field.half_width_m;
  const bool by_spacing = spacing.usable() && pencil.rows >= 2;
  const bool by_width = !by_spacing && width.usable() && g > 0.0;
  if (!by_spacing && !by_width && !height.usable()) return std::nullopt;
  double drop = by_spacing ? -spacing.value / b : height.usable() ? height.value : width.value / g;
  Estimate rise = rise_at(field, g * drop);
  if (!by_spacing && height.usable()) {
    drop = height.value - rise.value;
    rise = rise_at(field, g * drop);
    drop = height.value - rise.value;
  }
  if (!(drop > 0.0)) return std::nullopt;
  s.value[kRise] = rise.value;
  s.covariance(kRise, kRise) = rise.sigma * rise.sigma;
  if (by_spacing) {
    s.set_drop(drop, spacing.value / (b * b) * unit(kB), spacing.sigma / b);
    if (height.usable()) s.measure(unit(kDrop) + unit(kRise), height.value - drop - rise.value, height.sigma);
    return s;
  }
  if (height.usable()) {
    s.set_drop(drop, -unit(kRise), height.sigma);
    if (by_width) s.measure(drop * unit(kG) + g * unit(kDrop), width.value - g * drop, width.sigma);
    return s;
  }
  s.set_drop(drop, -width.value / (g * g) * unit(kG), width.sigma / g);
  return s;
}

SpacingHeight in_metres(const Pencil& pencil, const FieldKnowledge& field, const Estimate& height) {
  const geom::Attitude attitude = attitude_from(pencil.angles());
  const Eigen::Matrix3d turn = attitude_jacobian(pencil.angles());
  const Eigen::Matrix3d angles = turn * pencil.covariance.topLeftCorner<3, 3>() * turn.transpose();
  const int n = pencil.observations;
  SpacingHeight result;
  result.pitch_rad = {attitude.pitch_rad, std::sqrt(angles(0, 0)), n};
  result.yaw_rad = {attitude.yaw_rad, std::sqrt(angles(2, 2)), n};
  const double over_spacing = -1.0 / pencil.value[kPencilB];
  if (pencil.rows >= 2) {
    const double b_sigma = std::sqrt(pencil.covariance(kPencilB, kPencilB));
    result.height_over_spacing = {over_spacing, b_sigma * over_spacing * over_spacing, n};
  }
  const std::optional<Scale> scale = scale_of(pencil, field, height);
  if (!scale) return result;
  const double a = scale->value[kA], b = scale->value[kB], drop = scale->value[kDrop];
  const ScaleVector to_cross = -drop * unit(kA) - a * unit(kDrop);    // c = -a H
  const ScaleVector to_spacing = -drop * unit(kB) - b * unit(kDrop);  // S = -b H
  const ScaleVector to_height = unit(kDrop) + unit(kRise);
  result.height_above_canopy_m = {drop + scale->value[kRise], scale->sigma_of(to_height), n};
  result.cross_track_m = {-a * drop, scale->sigma_of(to_cross), n};
  if (pencil.rows < 2) return result;
  result.row_spacing_m = {-b * drop, scale->sigma_of(to_spacing), n};
  result.cross_track_spacing_covariance_m2 = scale->covariance_of(to_cross, to_spacing);
  return result;
}

}  // namespace

Result<SpacingHeight> from_spacing(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                   const AttitudePrior& prior) {
  FURROW_DO(sound_field(field));
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(prior));
  FURROW_TRY(const Pencil pencil, fit_pencil(rows, field, gimbal));
  FieldKnowledge known = field;
  if (!field.row_spacing_m.usable()) known.half_width_m = {};
  return in_metres(pencil, known, {});
}

Result<SpacingHeight> from_any_scale(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                     const AttitudePrior& prior, const Estimate& height_above_canopy_m) {
  FURROW_DO(sound_field(field));
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(prior));
  FURROW_TRY(const Pencil pencil, fit_pencil(rows, field, gimbal, 1));
  return in_metres(pencil, field, height_above_canopy_m);
}

}  // namespace furrow::altitude
