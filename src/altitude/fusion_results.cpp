#include "fusion_results.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fusion_filter.h"

namespace furrow::altitude {
namespace {

FusedHeight describe(const HeightSample& sample, const Belief& belief, const Labels& labels,
                     const FusionSetup& setup, bool surface_open) {
  const FuseOptions& options = setup.options;
  FusedHeight fused;
  fused.t_s = sample.t_s;
  fused.residual_m.fill(std::numeric_limits<double>::quiet_NaN());
  fused.left_out = labels.left_out;
  fused.vps_seen = labels.vps;
  int readings = 0;
  for (const HeightSource source : kAllHeightSources) {
    const auto reading = reading_of(sample, source, labels.vps, setup);
    if (!reading) continue;
    fused.residual_m[place(source)] = reading->value - reading->row.dot(belief.mean);
    readings += takes_part(labels, source);
  }
  const double guess = surface_open ? options.row_height_m.value : 0.0;
  const double sigma = std::hypot(std::sqrt(std::max(0.0, belief.covariance(kHeight, kHeight))), guess);
  fused.above_canopy_m = {belief.mean[kHeight], sigma, readings};
  if (options.row_height_m.usable()) {
    State lifted = State::Zero(state_size(setup));
    lifted[kHeight] = lifted[kRowHeight] = 1.0;
    fused.above_ground_m = {
        lifted.dot(belief.mean) + options.row_height_m.value,
        std::hypot(std::sqrt(std::max(0.0, lifted.dot(belief.covariance * lifted))), guess), readings};
  }
  return fused;
}

void count_sources(FusedFlight& flight) {
  std::array<double, kHeightSources> squares = {};
  for (const FusedHeight& height : flight.heights) {
    for (std::size_t i = 0; i < squares.size(); ++i) {
      if (std::isnan(height.residual_m[i])) continue;
      if (height.left_out[i]) {
        ++flight.gated[i];
      } else {
        ++flight.used[i];
        squares[i] += height.residual_m[i] * height.residual_m[i];
      }
    }
  }
  for (std::size_t i = 0; i < squares.size(); ++i) {
    flight.residual_rms_m[i] = flight.used[i] > 0 ? std::sqrt(squares[i] / flight.used[i])
                                                  : std::numeric_limits<double>::quiet_NaN();
  }
}

/// At the last sample.
void describe_biases(const Belief& last, FusedFlight& flight) {
  const auto bias = [&](int at, HeightSource source) {
    return Estimate{last.mean[at], std::sqrt(last.covariance(at, at)), flight.used[place(source)]};
  };
  flight.baro_bias_m = bias(kBaroBias, HeightSource::baro);
  flight.gnss_bias_m = bias(kGnssBias, HeightSource::gnss);
  flight.depth_bias_m = bias(kDepthBias, HeightSource::depth);
}

/// At the last sample: they are the same at all.
void describe_causes(const Belief& last, const FusionSetup& setup, FusedFlight& flight) {
  for (std::size_t i = 0; i < setup.causes.size(); ++i) {
    const Eigen::Index at = kFirstCause + static_cast<Eigen::Index>(i);
    const double sigma = std::sqrt(std::max(0.0, last.covariance(at, at)));
    flight.causes.push_back(
        {setup.causes[i], {last.mean[at], sigma, flight.used[place(HeightSource::vision)]}});
  }
}

}  // namespace

FusedFlight describe(const std::vector<HeightSample>& samples, const Settled& settled) {
  const FusionSetup& setup = settled.setup;
  const std::vector<Labels>& labels = settled.labels;
  const std::vector<Belief> beliefs = smooth(samples, labels, setup);
  FusedFlight flight;
  flight.passes = settled.passes;
  flight.ground_curvature_per_m = setup.curvature_sigma;
  flight.noise_scale = setup.noise_scale;
  flight.surface_open = !any_absolute(samples, setup) && on_one_level(labels);
  for (std::size_t i = 0; i < samples.size(); ++i)
    flight.heights.push_back(describe(samples[i], beliefs[i], labels[i], setup, flight.surface_open));
  count_sources(flight);
  describe_biases(beliefs.back(), flight);
  describe_causes(beliefs.back(), setup, flight);
  return flight;
}

}  // namespace furrow::altitude
