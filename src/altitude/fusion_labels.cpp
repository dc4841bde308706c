#include "fusion_labels.h"

#include <algorithm>
#include <cmath>

#include "surface_labels.h"

namespace furrow::altitude {
namespace {

/// How many sigmas a reading is from what the rest says. A reading that took part is first taken back out of
/// the belief (eq. 11.3).
double distance_from_rest(const Belief& belief, const Reading& reading, bool took_part) {
  const double own = reading.row.dot(belief.covariance * reading.row);
  const double r = reading.sigma * reading.sigma;
  const double residual = reading.value - reading.row.dot(belief.mean);
  if (!took_part) return std::abs(residual) / std::sqrt(r + own);
  return std::abs(residual) / std::sqrt(std::max(r - own, 1e-3 * r));
}

Seen label_vps(const HeightSample& sample, const Belief& belief, Seen before, const FusionSetup& setup) {
  double best = setup.options.gate_sigmas;
  Seen label = Seen::outlier;
  for (const Seen seen : {Seen::canopy, Seen::soil}) {
    if (seen == Seen::soil && !setup.options.row_height_m.usable()) continue;
    const auto reading = reading_of(sample, HeightSource::vps, seen, setup);
    const double away = distance_from_rest(belief, *reading, false);
    // The side it was on wins a tie, so that the passes end.
    if (away < (seen == before ? best + 1e-9 : best)) best = away, label = seen;
  }
  return label;
}

Labels label(const HeightSample& sample, const Belief& belief, const Labels& before,
             const FusionSetup& setup) {
  Labels labels = before;
  for (const HeightSource source : kAllHeightSources) {
    const auto reading = reading_of(sample, source, Seen::canopy, setup);
    if (!reading) continue;
    const std::size_t i = place(source);
    if (source == HeightSource::vps) {
      labels.vps = label_vps(sample, belief, before.vps, setup);
      labels.left_out[i] = labels.vps == Seen::outlier;
    } else {
      labels.left_out[i] =
          distance_from_rest(belief, *reading, takes_part(before, source)) > setup.options.gate_sigmas;
    }
  }
  return labels;
}

}  // namespace

bool takes_part(const Labels& labels, HeightSource source) {
  if (source == HeightSource::vps) return labels.vps == Seen::canopy || labels.vps == Seen::soil;
  return !labels.left_out[place(source)];
}

std::vector<Labels> first_labels(const std::vector<HeightSample>& samples, const FuseOptions& options) {
  std::vector<Labels> labels(samples.size());
  const std::vector<Seen> seen = likely_surfaces(samples, options);
  for (std::size_t i = 0; i < samples.size(); ++i) labels[i].vps = seen[i];
  return labels;
}

std::vector<Labels> next_labels(const std::vector<HeightSample>& samples, const std::vector<Belief>& beliefs,
                                const std::vector<Labels>& before, const FusionSetup& setup) {
  std::vector<Labels> next;
  for (std::size_t i = 0; i < samples.size(); ++i)
    next.push_back(label(samples[i], beliefs[i], before[i], setup));
  return next;
}

bool same(const std::vector<Labels>& a, const std::vector<Labels>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].left_out != b[i].left_out || a[i].vps != b[i].vps) return false;
  }
  return true;
}

bool on_one_level(const std::vector<Labels>& labels) {
  const auto saw = [&](Seen seen) {
    return std::any_of(labels.begin(), labels.end(), [seen](const Labels& l) { return l.vps == seen; });
  };
  return !(saw(Seen::canopy) && saw(Seen::soil));
}

}  // namespace furrow::altitude
