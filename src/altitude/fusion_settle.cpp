#include "fusion_settle.h"

#include <algorithm>
#include <cmath>

#include "fusion_filter.h"

namespace furrow::altitude {
namespace {

/// How many readings a claimed sigma is worth against the noise that is seen, as for one shot (eq. 8.2).
constexpr double kClaimWeight = 20.0;

/// The noise of one source over its claim: residuals against what is left of its variance once its own pull
/// is taken out (eq. 11.5). Readings that are about to be left out tell nothing of it.
double seen_noise(const std::vector<HeightSample>& samples, const std::vector<Belief>& beliefs,
                  const std::vector<Labels>& labels, const std::vector<Labels>& next, HeightSource source,
                  const FusionSetup& setup) {
  constexpr double kLeastLeft = 0.05;  // readings that nothing else checks say nothing of their noise
  const double scale = setup.noise_scale[place(source)];
  double sum = kClaimWeight, count = kClaimWeight;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto reading = reading_of(samples[i], source, labels[i].vps, setup);
    if (!reading || !takes_part(labels[i], source) || !takes_part(next[i], source)) continue;
    const double r = reading->sigma * reading->sigma;
    const double left = r - reading->row.dot(beliefs[i].covariance * reading->row);
    if (left < kLeastLeft * r) continue;
    const double residual = reading->value - reading->row.dot(beliefs[i].mean);
    sum += scale * scale * residual * residual / left;
    count += 1.0;
  }
  return std::sqrt(sum / count);
}

std::array<double, kHeightSources> seen_noises(const std::vector<HeightSample>& samples,
                                               const std::vector<Belief>& beliefs,
                                               const std::vector<Labels>& labels,
                                               const std::vector<Labels>& next, const FusionSetup& setup) {
  std::array<double, kHeightSources> scales = {};
  for (const HeightSource source : kAllHeightSources)
    scales[place(source)] = seen_noise(samples, beliefs, labels, next, source, setup);
  return scales;
}

bool same(const std::array<double, kHeightSources>& a, const std::array<double, kHeightSources>& b) {
  constexpr double kAlike = 0.01;
  return std::equal(a.begin(), a.end(), b.begin(),
                    [](double x, double y) { return std::abs(x - y) < kAlike * y; });
}

/// Smooths from these labels and claimed noise until both stay.
Settled settle_from(const std::vector<HeightSample>& samples, std::vector<Labels> labels,
                    const FusionSetup& setup) {
  constexpr int kMostPasses = 20;  // readings that still change sides then are left where they are
  Settled now{std::move(labels), setup};
  while (now.passes < kMostPasses) {
    ++now.passes;
    const std::vector<Belief> beliefs = smooth(samples, now.labels, now.setup);
    std::vector<Labels> next = next_labels(samples, beliefs, now.labels, now.setup);
    const auto noise = seen_noises(samples, beliefs, now.labels, next, now.setup);
    if (same(next, now.labels) && same(noise, now.setup.noise_scale)) break;
    now.labels = std::move(next);
    now.setup.noise_scale = noise;
  }
  return now;
}

/// -2 ln likelihood of all readings but for a constant, those left out counted as standing at the gate.
double misfit(const std::vector<HeightSample>& samples, const Settled& settled) {
  const FusionSetup& setup = settled.setup;
  double sum = filter(samples, settled.labels, setup).minus_2_log_likelihood;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (const HeightSource source : kAllHeightSources) {
      const Labels& labels = settled.labels[i];
      const auto reading = reading_of(samples[i], source, labels.vps, setup);
      if (!reading || takes_part(labels, source)) continue;
      sum += std::pow(setup.options.gate_sigmas, 2) + 2.0 * std::log(reading->sigma);
    }
  }
  return sum;
}

/// Settles from the likeliest surfaces, and from those that a downward sensor's own changes of level tell,
/// pictures aside; the second is kept where all readings are likelier so (eq. 11.8): rows found on grass are
/// wrong by the rows' height in every shot, and had turned soil into leaves.
Settled settle_by_two_starts(const std::vector<HeightSample>& samples, const FusionSetup& setup) {
  Settled first = settle_from(samples, first_labels(samples, setup.options), setup);
  FuseOptions blind = setup.options;
  blind.use[place(HeightSource::vision)] = blind.use[place(HeightSource::depth)] = false;
  std::vector<Labels> own_steps = first_labels(samples, blind);
  if (on_one_level(own_steps)) return first;
  Settled second = settle_from(samples, std::move(own_steps), setup);
  first.passes = second.passes += first.passes;
  return misfit(samples, second) < misfit(samples, first) ? second : first;
}

/// The curvature of the ground under which the flight's readings are likeliest; 0 unless they say so by more
/// than a free number gains by itself (Akaike: 2 in -2 ln likelihood) (eq. 11.7).
double likeliest_curvature(const std::vector<HeightSample>& samples, const Settled& settled) {
  FusionSetup setup = settled.setup;
  setup.curvature_sigma = 0.0;
  double best = 0.0, least = filter(samples, settled.labels, setup).minus_2_log_likelihood - 2.0;
  for (const double curvature : {0.0005, 0.001, 0.002, 0.004, 0.008, 0.016}) {
    setup.curvature_sigma = curvature;
    const double value = filter(samples, settled.labels, setup).minus_2_log_likelihood;
    if (value < least) least = value, best = curvature;
  }
  return best;
}

}  // namespace

Settled settle(const std::vector<HeightSample>& samples, const FusionSetup& setup) {
  Settled level = settle_by_two_starts(samples, setup);
  FusionSetup curved = setup;
  curved.curvature_sigma = likeliest_curvature(samples, level);
  if (!(curved.curvature_sigma > 0.0)) return level;
  // What was taken for noise of the others may have been the ground.
  Settled over_waves = settle_by_two_starts(samples, curved);
  over_waves.passes += level.passes;
  return over_waves;
}

}  // namespace furrow::altitude
