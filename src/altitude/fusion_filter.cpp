#include "fusion_filter.h"

#include <cmath>
#include <Eigen/Cholesky>

namespace furrow::altitude {
namespace {

/// Returns what the reading adds to -2 ln likelihood, but for a constant.
double update(Belief& belief, const Reading& reading) {
  const State gain_numerator = belief.covariance * reading.row;
  const double variance = reading.row.dot(gain_numerator) + reading.sigma * reading.sigma;
  const State gain = gain_numerator / variance;
  const double surprise = reading.value - reading.row.dot(belief.mean);
  belief.mean += gain * surprise;
  // Joseph's form keeps the covariance positive over long flights.
  const StateMatrix rest = StateMatrix::Identity(gain.size(), gain.size()) - gain * reading.row.transpose();
  belief.covariance =
      rest * belief.covariance * rest.transpose() + reading.sigma * reading.sigma * gain * gain.transpose();
  return std::log(variance) + surprise * surprise / variance;
}

}  // namespace

Filtered filter(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                const FusionSetup& setup) {
  const std::size_t n = samples.size();
  Filtered result{std::vector<Belief>(n), std::vector<Belief>(n), 0.0};
  for (std::size_t i = 0; i < n; ++i) {
    Belief& predicted = result.predicted[i];
    predicted = i == 0 ? start_belief(setup) : result.filtered[i - 1];
    if (i > 0) {
      const Step step = step_of(samples[i].t_s - samples[i - 1].t_s, setup);
      predicted.mean = step.transition * predicted.mean;
      predicted.covariance =
          step.transition * predicted.covariance * step.transition.transpose() + step.noise;
    }
    result.filtered[i] = predicted;
    for (const HeightSource source : kAllHeightSources) {
      const auto reading = reading_of(samples[i], source, labels[i].vps, setup);
      if (reading && takes_part(labels[i], source))
        result.minus_2_log_likelihood += update(result.filtered[i], *reading);
    }
  }
  return result;
}

std::vector<Belief> smooth(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                           const FusionSetup& setup) {
  const Filtered forward = filter(samples, labels, setup);
  std::vector<Belief> smoothed = forward.filtered;
  for (std::size_t i = samples.size() - 1; i-- > 0;) {
    const Step step = step_of(samples[i + 1].t_s - samples[i].t_s, setup);
    const Belief& next = forward.predicted[i + 1];
    const StateMatrix back =
        next.covariance.ldlt().solve(step.transition * forward.filtered[i].covariance).transpose();
    smoothed[i].mean += back * (smoothed[i + 1].mean - next.mean);
    smoothed[i].covariance += back * (smoothed[i + 1].covariance - next.covariance) * back.transpose();
  }
  return smoothed;
}

}  // namespace furrow::altitude
