#include "furrow/stats/agreement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/stats/robust.h"

namespace furrow::stats {
namespace {
/// Two-sided 95 % point of the Gaussian.
constexpr double kNormal95 = 1.959963984540054;
}  // namespace

Agreement agreement(std::span<const double> estimates, std::span<const double> references) {
  check(estimates.size() == references.size(), "agreement: as many estimates as references are needed");
  std::vector<double> kept;
  std::vector<double> kept_references;
  std::vector<double> errors;
  std::vector<double> magnitudes;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const double error = estimates[i] - references[i];
    if (!std::isfinite(error)) continue;
    kept.push_back(estimates[i]);
    kept_references.push_back(references[i]);
    errors.push_back(error);
    magnitudes.push_back(std::abs(error));
  }
  Agreement result;
  result.pairs = static_cast<int>(errors.size());
  result.left_out = static_cast<int>(estimates.size() - errors.size());
  result.mean_estimate = mean(kept);
  result.mean_reference = mean(kept_references);
  result.mean_error = mean(errors);
  result.sd_error = standard_deviation(errors);
  result.rmse = root_mean_square(errors);
  result.mean_abs_error = mean(magnitudes);
  result.max_abs_error = magnitudes.empty() ? std::numeric_limits<double>::quiet_NaN()
                                            : *std::max_element(magnitudes.begin(), magnitudes.end());
  result.limit_low = result.mean_error - kNormal95 * result.sd_error;
  result.limit_high = result.mean_error + kNormal95 * result.sd_error;
  return result;
}

Coverage coverage(std::span<const Estimate> estimates, std::span<const double> truths) {
  check(estimates.size() == truths.size(), "coverage: as many estimates as truths are needed");
  Coverage result;
  int in_1 = 0;
  int in_2 = 0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (!estimates[i].usable() || !std::isfinite(truths[i])) continue;
    const double error = std::abs(estimates[i].value - truths[i]);
    ++result.count;
    in_1 += error <= estimates[i].sigma ? 1 : 0;
    in_2 += error <= 2.0 * estimates[i].sigma ? 1 : 0;
  }
  const double count = result.count > 0 ? result.count : std::numeric_limits<double>::quiet_NaN();
  result.within_1_sigma = in_1 / count;
  result.within_2_sigma = in_2 / count;
  return result;
}

}  // namespace furrow::stats
