#include "furrow/stats/robust.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace furrow::stats {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
/// 1 / Phi^-1(3/4): makes the median absolute deviation equal sigma for Gaussian data.
constexpr double kMadToSigma = 1.4826022185056018;

std::vector<double> finite(std::span<const double> values) {
  std::vector<double> kept;
  std::copy_if(values.begin(), values.end(), std::back_inserter(kept),
               [](double v) { return std::isfinite(v); });
  return kept;
}

}  // namespace

double median(std::span<const double> values) {
  return quantile(values, 0.5);
}

double mad_sigma(std::span<const double> values) {
  const double middle = median(values);
  std::vector<double> distances;
  for (const double value : finite(values)) distances.push_back(std::abs(value - middle));
  return kMadToSigma * median(distances);
}

double quantile(std::span<const double> values, double q) {
  std::vector<double> sorted = finite(values);
  std::sort(sorted.begin(), sorted.end());
  if (sorted.empty()) return kNaN;
  const double place = std::clamp(q, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double mean(std::span<const double> values) {
  const std::vector<double> kept = finite(values);
  if (kept.empty()) return kNaN;
  return std::accumulate(kept.begin(), kept.end(), 0.0) / static_cast<double>(kept.size());
}

double standard_deviation(std::span<const double> values) {
  const std::vector<double> kept = finite(values);
  if (kept.size() < 2) return kNaN;
  const double middle = mean(kept);
  double sum = 0.0;
  for (const double value : kept) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(kept.size() - 1));
}

double root_mean_square(std::span<const double> values) {
  const std::vector<double> kept = finite(values);
  if (kept.empty()) return kNaN;
  return std::sqrt(std::inner_product(kept.begin(), kept.end(), kept.begin(), 0.0) /
                   static_cast<double>(kept.size()));
}

}  // namespace furrow::stats
