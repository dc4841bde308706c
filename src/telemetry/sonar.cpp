#include "sonar.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/text.h"

namespace furrow::telemetry {
namespace {

/// Whether samples [begin, end), all with the same reading, are a lost sensor's last value.
bool is_held(const std::vector<Sample>& samples, std::size_t begin, std::size_t end, const SonarRule& rule) {
  double low = kMissing, high = kMissing;
  for (std::size_t i = begin; i < end; ++i) {
    low = std::fmin(low, samples[i].height_takeoff_m);
    high = std::fmax(high, samples[i].height_takeoff_m);
  }
  if (std::isnan(low))
    return base::ns_to_seconds(samples[end - 1].t_log_ns - samples[begin].t_log_ns) > rule.held_unseen_s;
  return high - low > rule.held_change_m;
}

}  // namespace

void distrust_held_sonar(Track& track, const SonarRule& rule) {
  auto& samples = track.samples;
  std::size_t readings = 0, dropped = 0, begin = 0;
  while (begin < samples.size()) {
    const double reading_m = samples[begin].height_vps_m;
    if (std::isnan(reading_m)) {
      ++begin;
      continue;
    }
    std::size_t end = begin + 1;
    while (end < samples.size() && samples[end].height_vps_m == reading_m) ++end;
    const bool useless = reading_m <= 0.0 || reading_m > rule.ceiling_m || is_held(samples, begin, end, rule);
    for (std::size_t i = begin; i < end; ++i) {
      ++readings;
      if (!useless && !(samples[i].height_takeoff_m > rule.ceiling_m)) continue;
      samples[i].height_vps_m = kMissing;
      ++dropped;
    }
    begin = end;
  }
  if (dropped > 0)
    track.warnings.push_back("sonar/vision height not used in " + std::to_string(dropped) + " of " +
                             std::to_string(readings) + " rows: out of range (over " +
                             base::format_fixed(rule.ceiling_m, 0) +
                             " m), zero, or the last value held while the barometer moved");
}

}  // namespace furrow::telemetry
