#include <algorithm>
#include <cmath>

#include "furrow/sync/locate.h"
#include "furrow/telemetry/sample_fields.h"

namespace furrow::sync {
namespace {

using base::Nanoseconds;
using telemetry::Sample;

/// a + w (b - a) the short way round, in [low, low + 360).
double mix_angle(double a_deg, double b_deg, double w, double low_deg) {
  const double mixed = a_deg + w * std::remainder(b_deg - a_deg, 360.0) - low_deg;
  const double wrapped = mixed - 360.0 * std::floor(mixed / 360.0) + low_deg;
  return wrapped >= low_deg + 360.0 ? low_deg : wrapped;
}

std::optional<Nanoseconds> mix_time(const std::optional<Nanoseconds>& a, const std::optional<Nanoseconds>& b,
                                    double w) {
  if (!a || !b) return std::nullopt;
  return *a + static_cast<Nanoseconds>(std::llround(w * static_cast<double>(*b - *a)));
}

/// State at the share `w` in (0, 1) of the way from a to b; a number that one of them lacks stays unknown.
Sample mix(const Sample& a, const Sample& b, double w) {
  Sample s = w < 0.5 ? a : b;
  s.t_utc_ns = mix_time(a.t_utc_ns, b.t_utc_ns, w);
  s.t_local_ns = mix_time(a.t_local_ns, b.t_local_ns, w);
  for (const auto field : telemetry::kLinearFields) s.*field = a.*field + w * (b.*field - a.*field);
  for (const auto field : telemetry::kHeadingFields) s.*field = mix_angle(a.*field, b.*field, w, 0.0);
  for (const auto field : telemetry::kSignedAngleFields) s.*field = mix_angle(a.*field, b.*field, w, -180.0);
  return s;
}

}  // namespace

std::optional<Sample> interpolate(const telemetry::Track& track, Nanoseconds t_log_ns) {
  const auto& samples = track.samples;
  const auto after =
      std::lower_bound(samples.begin(), samples.end(), t_log_ns,
                       [](const Sample& sample, Nanoseconds t) { return sample.t_log_ns < t; });
  if (after == samples.end()) return std::nullopt;
  if (after->t_log_ns == t_log_ns) return *after;
  if (after == samples.begin()) return std::nullopt;
  const Sample& before = *(after - 1);
  const double w = static_cast<double>(t_log_ns - before.t_log_ns) /
                   static_cast<double>(after->t_log_ns - before.t_log_ns);
  Sample state = mix(before, *after, w);
  state.t_log_ns = t_log_ns;
  return state;
}

}  // namespace furrow::sync
