#include "fusion_readings.h"

#include <algorithm>
#include <cmath>

namespace furrow::altitude {
namespace {

/// Share of a shot's own variance that lasts over a stretch (eq. 11.6): heights of neighbouring shots in
/// rendered flights correlate by 0.2 to 0.25 once what their flight shares is taken off.
constexpr double kLastingShare = 0.5;

Reading reading_on(int bias, double value, double sigma, const FusionSetup& setup) {
  Reading reading;
  reading.row = State::Zero(state_size(setup));
  reading.row[kHeight] = 1.0;
  if (bias >= 0) reading.row[bias] = 1.0;
  // Heights above a fixed level see the ground's rise as a loss of height above the canopy.
  if (bias == kBaroBias || bias == kGnssBias) reading.row[kGround] = 1.0;
  reading.value = value;
  reading.sigma = sigma;
  return reading;
}

Reading vps_reading(double value, Seen seen, const FusionSetup& setup) {
  const FuseOptions& options = setup.options;
  if (seen == Seen::soil)
    return reading_on(kRowHeight, value - options.row_height_m.value, options.vps_sigma_m, setup);
  return reading_on(kVpsCanopy, value, options.vps_sigma_m, setup);
}

/// What the flight's shots share are states, so that many shots do not average it away. What is left is the
/// shot's own.
Reading shared_reading(int bias, const Estimate& height, const std::vector<SigmaShare>& shared,
                       const FusionSetup& setup) {
  constexpr double kLeastOwnShare = 0.1;
  Reading reading = reading_on(bias, height.value, height.sigma, setup);
  double own2 = height.sigma * height.sigma;
  for (const SigmaShare& cause : shared) {
    const auto at = std::find(setup.causes.begin(), setup.causes.end(), cause.cause) - setup.causes.begin();
    reading.row[kFirstCause + at] = cause.sigma_m;
    own2 -= cause.sigma_m * cause.sigma_m;
  }
  reading.sigma = std::max(std::sqrt(std::max(0.0, own2)), kLeastOwnShare * height.sigma);
  return reading;
}

/// Part of a picture's own error is that of the plants of a stretch, and lasts (eq. 11.6).
Reading vision_reading(const HeightSample& s, const FusionSetup& setup) {
  Reading reading = shared_reading(-1, s.vision_above_canopy_m, s.vision_shared, setup);
  const double lasting = setup.options.shots_per_stretch > 1.0 ? kLastingShare : 0.0;
  reading.row[kCurvature] = 0.5 * s.vision_reach_m * s.vision_reach_m;
  reading.row[kPlants] = reading.sigma * std::sqrt(lasting);
  reading.sigma *= std::sqrt(1.0 - lasting);
  return reading;
}

/// A source's reading at a sample with its claimed noise, or nothing when it is silent or not used.
std::optional<Reading> claimed_reading(const HeightSample& s, HeightSource source, Seen vps,
                                       const FusionSetup& setup) {
  const FuseOptions& options = setup.options;
  if (!options.use[place(source)]) return std::nullopt;
  const auto plain = [&](int bias, double value, double sigma) -> std::optional<Reading> {
    if (!std::isfinite(value)) return std::nullopt;
    return reading_on(bias, value, sigma, setup);
  };
  switch (source) {
    case HeightSource::vision:
      if (!s.vision_above_canopy_m.usable()) return std::nullopt;
      return vision_reading(s, setup);
    case HeightSource::depth:
      if (!s.depth_above_canopy_m.usable()) return std::nullopt;
      return shared_reading(kDepthBias, s.depth_above_canopy_m, s.depth_shared, setup);
    case HeightSource::baro:
      return plain(kBaroBias, s.baro_height_m, options.baro_sigma_m);
    case HeightSource::gnss:
      return plain(kGnssBias, s.gnss_height_m, options.gnss_sigma_m);
    case HeightSource::vps:
      if (!std::isfinite(s.vps_height_m)) return std::nullopt;
      return vps_reading(s.vps_height_m, vps, setup);
  }
  return std::nullopt;
}

}  // namespace

std::optional<Reading> reading_of(const HeightSample& s, HeightSource source, Seen vps,
                                  const FusionSetup& setup) {
  auto reading = claimed_reading(s, source, vps, setup);
  if (!reading) return reading;
  const double scale = setup.noise_scale[place(source)];
  reading->sigma *= scale;
  reading->row[kPlants] *= scale;
  return reading;
}

bool any(const std::vector<HeightSample>& samples, HeightSource source, const FusionSetup& setup) {
  for (const HeightSample& sample : samples) {
    if (claimed_reading(sample, source, Seen::canopy, setup)) return true;
  }
  return false;
}

bool any_absolute(const std::vector<HeightSample>& samples, const FusionSetup& setup) {
  return any(samples, HeightSource::vision, setup) || any(samples, HeightSource::depth, setup);
}

}  // namespace furrow::altitude
