#include "furrow/follow/track_filter.h"

#include <cmath>

#include "furrow/base/result.h"

namespace furrow::follow {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A measurement z = value + common_sigma * common error + own error (docs/formulation/follow.md, eq. 2).
struct Measurement {
  double z, common_sigma, own_variance;
};

Measurement measurement_of(const Estimate& measured, const FilterOptions& options) {
  const double variance = measured.sigma * measured.sigma;
  return {measured.value, measured.sigma * std::sqrt(options.common_share),
          variance * (1.0 - options.common_share)};
}

/// Eq. 1.
Filtered predict(Filtered filtered, base::Nanoseconds t_ns, const FilterOptions& options) {
  const double dt = base::ns_to_seconds(t_ns - filtered.t_ns);
  const double kept = std::exp(-dt / options.common_time_s), q = options.agility * options.agility;
  Matrix3d step = Matrix3d::Identity(), noise = Matrix3d::Zero();
  step(0, 1) = dt;
  step(2, 2) = kept;
  noise(0, 0) = q * dt * dt * dt / 3.0;
  noise(0, 1) = noise(1, 0) = q * dt * dt / 2.0;
  noise(1, 1) = q * dt;
  noise(2, 2) = 1.0 - kept * kept;
  filtered.t_ns = t_ns;
  filtered.state = step * filtered.state;
  filtered.covariance = step * filtered.covariance * step.transpose() + noise;
  return filtered;
}

Filtered start(base::Nanoseconds t_ns, const Measurement& m, const FilterOptions& options) {
  Filtered filtered;
  filtered.has_started = true;
  filtered.t_ns = filtered.last_used_ns = t_ns;
  filtered.state = {m.z, 0.0, 0.0};
  filtered.covariance(0, 0) = m.common_sigma * m.common_sigma + m.own_variance;
  filtered.covariance(0, 2) = filtered.covariance(2, 0) = -m.common_sigma;
  filtered.covariance(1, 1) = options.start_rate_sigma * options.start_rate_sigma;
  filtered.covariance(2, 2) = 1.0;
  filtered.intake = Intake::restarted;
  filtered.used = 1;
  return filtered;
}

/// Joseph's form keeps the covariance symmetric and positive over hours of updates.
Filtered update(Filtered filtered, const Measurement& m, const Vector3d& h, double variance) {
  const Vector3d gain = filtered.covariance * h / variance;
  const Matrix3d rest = Matrix3d::Identity() - gain * h.transpose();
  filtered.state += gain * (m.z - h.dot(filtered.state));
  filtered.covariance =
      rest * filtered.covariance * rest.transpose() + gain * m.own_variance * gain.transpose();
  filtered.intake = Intake::used;
  filtered.last_used_ns = filtered.t_ns;
  filtered.left_out_in_row = 0;
  ++filtered.used;
  return filtered;
}

}  // namespace

Filtered filter_step(const Filtered& before, base::Nanoseconds t_ns, const Estimate& measured,
                     const FilterOptions& options) {
  check(!before.has_started || t_ns >= before.t_ns, "filter_step: time runs forwards");
  const bool is_seen = measured.usable() && measured.sigma > 0.0;
  if (!before.has_started) return is_seen ? start(t_ns, measurement_of(measured, options), options) : before;
  Filtered now = predict(before, t_ns, options);
  now.intake = Intake::nothing;
  if (!is_seen) return now;
  const Measurement m = measurement_of(measured, options);
  const Vector3d h(1.0, 0.0, m.common_sigma);
  const double variance = h.dot(now.covariance * h) + m.own_variance;
  const double apart = std::abs(m.z - h.dot(now.state));
  if (apart <= options.gate_sigmas * std::sqrt(variance)) return update(now, m, h, variance);
  if (before.left_out_in_row + 1 >= options.restart_after) return start(t_ns, m, options);
  now.intake = Intake::left_out;
  ++now.left_out_in_row;
  return now;
}

std::optional<Estimate> filtered_value(const Filtered& filtered, const FilterOptions& options) {
  if (!filtered.has_started) return std::nullopt;
  const double sigma = std::sqrt(filtered.covariance(0, 0));
  const double silent_s = base::ns_to_seconds(filtered.t_ns - filtered.last_used_ns);
  if (!(sigma <= options.hold_sigma) || silent_s > options.hold_after_s) return std::nullopt;
  return Estimate{filtered.state[0], sigma, filtered.used};
}

Estimate filtered_rate(const Filtered& filtered) {
  if (!filtered.has_started) return {};
  return {filtered.state[1], std::sqrt(filtered.covariance(1, 1)), filtered.used};
}

Filtered shifted(Filtered filtered, double shift) {
  filtered.state[0] += shift;
  return filtered;
}

}  // namespace furrow::follow
