#include "furrow/sync/clock_map.h"

#include <algorithm>
#include <cmath>

#include "furrow/stats/robust.h"

namespace furrow::sync {
namespace {

using base::Nanoseconds;

/// Huber's bound: 95 % efficiency for Gaussian data (Huber 1981).
constexpr double kHuber = 1.345;
constexpr double kOutlierSigmas = 3.0;
constexpr int kRounds = 50;

/// y = offset + drift x over centred x; readings in seconds.
struct Line {
  double offset = 0.0, drift = 0.0;
};

struct Points {
  std::vector<double> x, y;
};

std::vector<double> residuals(const Points& p, const Line& line) {
  std::vector<double> r(p.x.size());
  for (std::size_t i = 0; i < r.size(); ++i) r[i] = p.y[i] - line.offset - line.drift * p.x[i];
  return r;
}

/// Least squares with weights; a plain weighted mean when the drift is not asked for or cannot be told.
Line weighted_line(const Points& p, const std::vector<double>& weights, bool drift) {
  double w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    w += weights[i];
    wx += weights[i] * p.x[i];
    wy += weights[i] * p.y[i];
    wxx += weights[i] * p.x[i] * p.x[i];
    wxy += weights[i] * p.x[i] * p.y[i];
  }
  const double spread = w * wxx - wx * wx;
  Line line;
  line.drift = drift && spread > 0.0 ? (w * wxy - wx * wy) / spread : 0.0;
  line.offset = (wy - line.drift * wx) / w;
  return line;
}

/// Sigma of (offset, drift) by Huber's asymptotic formula (1981, eq. 7.6.4 without its small-sample factor).
Line sigmas(const Points& p, const std::vector<double>& r, double scatter_s, bool drift) {
  const double n = static_cast<double>(r.size()), unknowns = drift ? 2.0 : 1.0;
  double psi2 = 0.0, inside = 0.0, xx = 0.0;
  for (std::size_t i = 0; i < r.size(); ++i) {
    const double psi = std::clamp(r[i], -kHuber * scatter_s, kHuber * scatter_s);
    psi2 += psi * psi;
    if (std::abs(r[i]) <= kHuber * scatter_s) inside += 1.0;
    xx += p.x[i] * p.x[i];
  }
  const double share = std::max(inside / n, 0.5);
  // With hardly more pairs than unknowns the residuals say nothing: the scatter's floor does.
  const double spread_s = n > unknowns ? std::sqrt(psi2 / (n - unknowns)) / share : 0.0;
  const double sigma_s = std::max(spread_s, n > unknowns ? 0.0 : scatter_s);
  return {sigma_s / std::sqrt(n), drift && xx > 0.0 ? sigma_s / std::sqrt(xx) : 0.0};
}

}  // namespace

Result<ClockMap> fit_clock(const std::vector<std::pair<Nanoseconds, Nanoseconds>>& pairs,
                           const ClockFitOptions& options) {
  check(options.step_s > 0.0, "fit_clock: step_s must be above 0");
  const std::size_t needed = options.drift ? 3 : 1;
  if (pairs.size() < needed)
    return Error{"not_enough_pairs", "clock fit", std::to_string(pairs.size()) + " pairs of readings",
                 std::to_string(needed) + " or more", ""};
  ClockMap map;
  map.pairs = static_cast<int>(pairs.size());
  // Differences to the first pair keep nanoseconds exact in doubles.
  const auto [t0, c0] = pairs.front();
  double mean_s = 0.0;
  for (const auto& [t, c] : pairs) mean_s += base::ns_to_seconds(t - t0) / static_cast<double>(pairs.size());
  map.at_ns = t0 + base::seconds_to_ns(mean_s);
  Points p;
  for (const auto& [t, c] : pairs) {
    p.x.push_back(base::ns_to_seconds(t - map.at_ns));
    p.y.push_back(base::ns_to_seconds((c - c0) - (t - t0)));
  }
  const double least_scatter_s = options.step_s / std::sqrt(12.0);
  Line line{stats::median(p.y), 0.0};
  std::vector<double> r = residuals(p, line), weights(r.size());
  for (int round = 0; round < kRounds; ++round) {
    map.scatter_s = std::max(stats::mad_sigma(r), least_scatter_s);
    for (std::size_t i = 0; i < r.size(); ++i)
      weights[i] = std::min(1.0, kHuber * map.scatter_s / std::max(std::abs(r[i]), 1e-300));
    line = weighted_line(p, weights, options.drift);
    r = residuals(p, line);
  }
  const Line sigma = sigmas(p, r, map.scatter_s, options.drift);
  map.offset_ns = (c0 - t0) + base::seconds_to_ns(line.offset);
  map.drift = line.drift;
  map.offset_sigma_s = std::max(sigma.offset, least_scatter_s / std::sqrt(static_cast<double>(pairs.size())));
  map.drift_sigma = sigma.drift;
  map.outliers = static_cast<int>(std::count_if(
      r.begin(), r.end(), [&](double x) { return std::abs(x) > kOutlierSigmas * map.scatter_s; }));
  return map;
}

Nanoseconds map_time(const ClockMap& map, Nanoseconds t_ns) {
  return t_ns + map.offset_ns + base::seconds_to_ns(map.drift * base::ns_to_seconds(t_ns - map.at_ns));
}

double map_sigma_s(const ClockMap& map, Nanoseconds t_ns) {
  return std::hypot(map.offset_sigma_s, map.drift_sigma * base::ns_to_seconds(t_ns - map.at_ns));
}

}  // namespace furrow::sync
