#include "surface_labels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace furrow::altitude {
namespace {

/// Leaves and soil, as places.
constexpr std::array<Seen, 2> kSurfaces = {Seen::canopy, Seen::soil};
/// How far a climb carries the aircraft where nothing else follows it, m/s.
constexpr double kClimbSigma = 0.5;
/// What soil costs more than leaves, so that readings on one level are taken for leaves.
constexpr double kSoilCost = 1e-3;

bool uses(const FuseOptions& options, HeightSource source) {
  return options.use[static_cast<std::size_t>(source)];
}

double squared(double x) {
  return x * x;
}

/// Squared distance in sigmas; beyond the gate it is an outlier and says no more.
double cost_of(double difference, double variance, const FuseOptions& options) {
  return std::min(squared(difference) / variance, squared(options.gate_sigmas));
}

/// Against the height that vision or depth states.
double own_cost(const HeightSample& s, std::size_t surface, const FuseOptions& options) {
  Estimate height;
  if (uses(options, HeightSource::depth) && s.depth_above_canopy_m.usable()) {
    height = s.depth_above_canopy_m;
    height.sigma = std::hypot(height.sigma, options.depth_bias_sigma_m);
  }
  if (uses(options, HeightSource::vision) && s.vision_above_canopy_m.usable())
    height = s.vision_above_canopy_m;
  const double soil = static_cast<double>(surface);
  if (!height.usable()) return soil * kSoilCost;
  const double variance =
      squared(options.vps_sigma_m) + squared(height.sigma) + soil * squared(options.row_height_m.sigma);
  return soil * kSoilCost +
         cost_of(s.vps_height_m - height.value - soil * options.row_height_m.value, variance, options);
}

/// From one reading to the next, less what the surface's change makes of it.
double step_cost(const HeightSample& a, const HeightSample& b, double rise_m, const FuseOptions& options) {
  const double dt = b.t_s - a.t_s;
  double climb = b.baro_height_m - a.baro_height_m, sigma = options.baro_sigma_m,
         drift = options.baro_drift_m_per_sqrt_s;
  if (!std::isfinite(climb) || !uses(options, HeightSource::baro)) {
    climb = b.gnss_height_m - a.gnss_height_m;
    sigma = options.gnss_sigma_m, drift = options.gnss_drift_m_per_sqrt_s;
  }
  double variance = 2.0 * squared(options.vps_sigma_m) + squared(options.ground_rate_sigma * dt);
  if (std::isfinite(climb) && (uses(options, HeightSource::baro) || uses(options, HeightSource::gnss))) {
    variance += 2.0 * squared(sigma) + squared(drift) * dt;
  } else {
    climb = 0.0, variance += squared(kClimbSigma * dt);
  }
  return cost_of(b.vps_height_m - a.vps_height_m - climb - rise_m, variance, options);
}

/// One reading's best costs up to it, and for each surface the one before.
struct Trellis {
  std::size_t sample = 0;
  std::array<double, 2> cost = {};
  std::array<std::size_t, 2> from = {};
};

Trellis next_of(const Trellis& before, std::size_t sample, const std::vector<HeightSample>& samples,
                const FuseOptions& options) {
  Trellis next{sample, {}, {}};
  for (std::size_t to = 0; to < 2; ++to) {
    next.cost[to] = HUGE_VAL;
    for (std::size_t from = 0; from < 2; ++from) {
      const double rise = (static_cast<double>(to) - static_cast<double>(from)) * options.row_height_m.value;
      const double cost =
          before.cost[from] + step_cost(samples[before.sample], samples[sample], rise, options);
      if (cost < next.cost[to]) next.cost[to] = cost, next.from[to] = from;
    }
    next.cost[to] += own_cost(samples[sample], to, options);
  }
  return next;
}

}  // namespace

std::vector<Seen> likely_surfaces(const std::vector<HeightSample>& samples, const FuseOptions& options) {
  std::vector<Seen> seen(samples.size(), Seen::nothing);
  std::vector<Trellis> trellis;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!uses(options, HeightSource::vps) || !std::isfinite(samples[i].vps_height_m)) continue;
    seen[i] = Seen::canopy;
    if (!options.row_height_m.usable()) continue;
    if (trellis.empty()) {
      trellis.push_back({i, {own_cost(samples[i], 0, options), own_cost(samples[i], 1, options)}, {}});
    } else {
      trellis.push_back(next_of(trellis.back(), i, samples, options));
    }
  }
  if (trellis.empty()) return seen;
  std::size_t surface = trellis.back().cost[1] < trellis.back().cost[0] ? 1 : 0;
  for (auto at = trellis.rbegin(); at != trellis.rend(); ++at) {
    seen[at->sample] = kSurfaces[surface];
    surface = at->from[surface];
  }
  return seen;
}

}  // namespace furrow::altitude
