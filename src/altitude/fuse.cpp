#include "furrow/altitude/fuse.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <optional>

#include "furrow/base/text.h"
#include "surface_labels.h"

namespace furrow::altitude {
namespace {

/// Places in the state: height above canopy, climb rate, each source's bias, the error of the stated row
/// height, of the leaves' level under a downward sensor, what the plants of this stretch do to the pictures
/// (in their own sigmas), the canopy's level with its rate, and its curvature. Behind them each cause that
/// the flight's pictures share, in its sigma.
constexpr int kHeight = 0, kClimb = 1, kBaroBias = 2, kGnssBias = 3, kDepthBias = 4, kRowHeight = 5,
              kVpsCanopy = 6, kPlants = 7, kGround = 8, kGroundRate = 9, kCurvature = 10, kFirstCause = 11;
using State = Eigen::VectorXd;
using StateMatrix = Eigen::MatrixXd;

/// Spread of a quantity of which nothing is known, metres or metres a second: far beyond any flight.
constexpr double kUnknownSigma = 1e4;
/// Passes after which readings that still change sides are left where they are.
constexpr int kMaxPasses = 20;
/// Share of a shot's own variance that lasts over a stretch (eq. 11.6): heights of neighbouring shots in
/// rendered flights correlate by 0.2 to 0.25 once what their flight shares is taken off.
constexpr double kLastingShare = 0.5;
/// How many readings a claimed sigma is worth against the noise that is seen, as for one shot (eq. 8.2).
constexpr double kClaimWeight = 20.0;

int place(HeightSource source) {
  return static_cast<int>(source);
}

/// One source's reading as a scalar measurement of the state.
struct Reading {
  State row;
  double value = 0.0, sigma = 1.0;
};

/// What each reading was taken for in the last pass.
struct Labels {
  std::array<bool, kHeightSources> left_out = {};
  Seen vps = Seen::nothing;
};

/// The options, the causes that the flight's pictures share, and the noise of each source over its claim.
struct Setup {
  const FuseOptions& options;
  std::vector<std::string> causes;
  double curvature_sigma = 0.0;  ///< of the ground, 1/m
  std::array<double, kHeightSources> noise_scale = {1.0, 1.0, 1.0, 1.0, 1.0};
};

struct Belief {
  State mean;
  StateMatrix covariance;
};

Eigen::Index state_size(const Setup& setup) {
  return kFirstCause + static_cast<Eigen::Index>(setup.causes.size());
}

Reading reading_on(int bias, double value, double sigma, const Setup& setup) {
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

Reading vps_reading(double value, Seen seen, const Setup& setup) {
  const FuseOptions& options = setup.options;
  if (seen == Seen::soil)
    return reading_on(kRowHeight, value - options.row_height_m.value, options.vps_sigma_m, setup);
  return reading_on(kVpsCanopy, value, options.vps_sigma_m, setup);
}

/// What the flight's shots share are states, so that many shots do not average it away. What is left is the
/// shot's own.
Reading shared_reading(int bias, const Estimate& height, const std::vector<SigmaShare>& shared,
                       const Setup& setup) {
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
Reading vision_reading(const HeightSample& s, const Setup& setup) {
  Reading reading = shared_reading(-1, s.vision_above_canopy_m, s.vision_shared, setup);
  const double lasting = setup.options.shots_per_stretch > 1.0 ? kLastingShare : 0.0;
  reading.row[kCurvature] = 0.5 * s.vision_reach_m * s.vision_reach_m;
  reading.row[kPlants] = reading.sigma * std::sqrt(lasting);
  reading.sigma *= std::sqrt(1.0 - lasting);
  return reading;
}

/// A source's reading at a sample with its claimed noise, or nothing when it is silent or not used.
std::optional<Reading> claimed_reading(const HeightSample& s, HeightSource source, Seen vps,
                                       const Setup& setup) {
  const FuseOptions& options = setup.options;
  if (!options.use[static_cast<std::size_t>(place(source))]) return std::nullopt;
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

std::optional<Reading> reading_of(const HeightSample& s, HeightSource source, Seen vps, const Setup& setup) {
  auto reading = claimed_reading(s, source, vps, setup);
  if (!reading) return reading;
  const double scale = setup.noise_scale[static_cast<std::size_t>(place(source))];
  reading->sigma *= scale;
  reading->row[kPlants] *= scale;
  return reading;
}

bool takes_part(const Labels& labels, HeightSource source) {
  if (source == HeightSource::vps) return labels.vps == Seen::canopy || labels.vps == Seen::soil;
  return !labels.left_out[static_cast<std::size_t>(place(source))];
}

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

/// Transition and noise over `dt` (eq. 11.1): white acceleration, biases that walk.
struct Step {
  StateMatrix transition, noise;
};

/// What is left of the plants' error at the next shot: sums over r alike shots grow as those of a process
/// whose neighbours correlate by (r - 1) / (r + 1) (eq. 11.6).
double kept_of_plants(const FuseOptions& options) {
  const double repeats = std::max(1.0, options.shots_per_stretch);
  return (repeats - 1.0) / (repeats + 1.0);
}

Step step_of(double dt, const Setup& setup) {
  const FuseOptions& options = setup.options;
  const Eigen::Index n = state_size(setup);
  Step step{StateMatrix::Identity(n, n), StateMatrix::Zero(n, n)};
  const double kept = kept_of_plants(options);
  step.transition(kPlants, kPlants) = kept;
  step.noise(kPlants, kPlants) = 1.0 - kept * kept;
  step.transition(kCurvature, kCurvature) = kept;
  step.noise(kCurvature, kCurvature) = (1.0 - kept * kept) * setup.curvature_sigma * setup.curvature_sigma;
  step.transition(kHeight, kClimb) = dt;
  const double q = options.acceleration_sigma * options.acceleration_sigma;
  step.noise(kHeight, kHeight) = q * dt * dt * dt / 3.0;
  step.noise(kHeight, kClimb) = step.noise(kClimb, kHeight) = q * dt * dt / 2.0;
  step.noise(kClimb, kClimb) = q * dt;
  step.transition(kGround, kGroundRate) = dt;
  step.noise(kGroundRate, kGroundRate) = std::pow(options.ground_rate_drift, 2) * dt;
  step.noise(kBaroBias, kBaroBias) = std::pow(options.baro_drift_m_per_sqrt_s, 2) * dt;
  step.noise(kGnssBias, kGnssBias) = std::pow(options.gnss_drift_m_per_sqrt_s, 2) * dt;
  return step;
}

Belief start_belief(const Setup& setup) {
  const FuseOptions& options = setup.options;
  const Eigen::Index n = state_size(setup);
  Belief belief{State::Zero(n), StateMatrix::Identity(n, n)};  // plants and causes count in sigmas
  for (const int unknown : {kHeight, kBaroBias, kGnssBias})
    belief.covariance(unknown, unknown) = kUnknownSigma * kUnknownSigma;
  belief.covariance(kClimb, kClimb) = 100.0;  // no aircraft over a crop climbs faster than 10 m/s
  belief.covariance(kDepthBias, kDepthBias) = options.depth_bias_sigma_m * options.depth_bias_sigma_m;
  belief.covariance(kRowHeight, kRowHeight) =
      options.row_height_m.usable() ? options.row_height_m.sigma * options.row_height_m.sigma : 0.0;
  belief.covariance(kCurvature, kCurvature) = setup.curvature_sigma * setup.curvature_sigma;
  belief.covariance(kVpsCanopy, kVpsCanopy) = options.vps_canopy_sigma_m * options.vps_canopy_sigma_m;
  belief.covariance(kGround, kGround) = 0.0;  // a constant is in the biases already
  belief.covariance(kGroundRate, kGroundRate) = options.ground_rate_sigma * options.ground_rate_sigma;
  return belief;
}

/// What the readings up to each sample say of it, with what was expected before its own.
struct Filtered {
  std::vector<Belief> predicted, filtered;
  double minus_2_log_likelihood = 0.0;
};

/// Forward Kalman filter (eq. 11.2).
Filtered filter(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                const Setup& setup) {
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

/// Forward, then backward by Rauch, Tung and Striebel (eq. 11.2).
std::vector<Belief> smooth(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                           const Setup& setup) {
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

/// The curvature of the ground under which the flight's readings are likeliest; 0 unless they say so by more
/// than a free number gains by itself (Akaike: 2 in -2 ln likelihood) (eq. 11.7).
double likeliest_curvature(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                           Setup setup) {
  setup.curvature_sigma = 0.0;
  double best = 0.0, least = filter(samples, labels, setup).minus_2_log_likelihood - 2.0;
  for (const double curvature : {0.0005, 0.001, 0.002, 0.004, 0.008, 0.016}) {
    setup.curvature_sigma = curvature;
    const double value = filter(samples, labels, setup).minus_2_log_likelihood;
    if (value < least) least = value, best = curvature;
  }
  return best;
}

/// How many sigmas a reading is from what the rest says. A reading that took part is first taken back out of
/// the belief (eq. 11.3).
double distance_from_rest(const Belief& belief, const Reading& reading, bool took_part) {
  const double own = reading.row.dot(belief.covariance * reading.row);
  const double r = reading.sigma * reading.sigma;
  const double residual = reading.value - reading.row.dot(belief.mean);
  if (!took_part) return std::abs(residual) / std::sqrt(r + own);
  return std::abs(residual) / std::sqrt(std::max(r - own, 1e-3 * r));
}

Seen label_vps(const HeightSample& sample, const Belief& belief, Seen before, const Setup& setup) {
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

Labels label(const HeightSample& sample, const Belief& belief, const Labels& before, const Setup& setup) {
  Labels labels = before;
  for (const HeightSource source : kAllHeightSources) {
    const auto reading = reading_of(sample, source, Seen::canopy, setup);
    if (!reading) continue;
    const std::size_t i = static_cast<std::size_t>(place(source));
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

bool same(const std::vector<Labels>& a, const std::vector<Labels>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].left_out != b[i].left_out || a[i].vps != b[i].vps) return false;
  }
  return true;
}

bool any(const std::vector<HeightSample>& samples, HeightSource source, const Setup& setup) {
  for (const HeightSample& sample : samples) {
    if (claimed_reading(sample, source, Seen::canopy, setup)) return true;
  }
  return false;
}

bool any_absolute(const std::vector<HeightSample>& samples, const Setup& setup) {
  return any(samples, HeightSource::vision, setup) || any(samples, HeightSource::depth, setup);
}

Status check_input(const std::vector<HeightSample>& samples, const Setup& setup) {
  const FuseOptions& options = setup.options;
  if (samples.empty()) return Error{"no_samples", "fuse", "no samples", "one sample or more", ""};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool sound = std::isfinite(samples[i].t_s) && (i == 0 || samples[i].t_s > samples[i - 1].t_s);
    if (!sound) {
      return Error{"times_not_increasing", "sample " + std::to_string(i + 1),
                   base::format_double(samples[i].t_s) + " s", "a finite time after the one before", ""};
    }
  }
  for (const double sigma : {options.acceleration_sigma, options.baro_sigma_m, options.vps_sigma_m,
                             options.gnss_sigma_m, options.depth_bias_sigma_m, options.gate_sigmas}) {
    if (!(std::isfinite(sigma) && sigma > 0.0)) {
      return Error{"not_finite", "fuse options", base::format_double(sigma), "finite sigmas above 0", ""};
    }
  }
  if (any_absolute(samples, setup)) return Done{};
  if (!any(samples, HeightSource::vps, setup)) {
    return Error{"no_absolute_height", "fuse", "only barometer or GNSS, whose zero is not known",
                 "vision, depth or a downward sensor", ""};
  }
  if (options.row_height_m.usable()) return Done{};
  return Error{"no_row_height", "fuse", "a downward sensor alone, and no height of the rows",
               "the rows' height", ""};
}

/// Every cause that some picture shares, once.
std::vector<std::string> causes_of(const std::vector<HeightSample>& samples) {
  std::vector<std::string> causes;
  const auto add = [&causes](const std::vector<SigmaShare>& shares) {
    for (const SigmaShare& share : shares) {
      if (std::find(causes.begin(), causes.end(), share.cause) == causes.end()) causes.push_back(share.cause);
    }
  };
  for (const HeightSample& sample : samples) {
    add(sample.vision_shared);
    add(sample.depth_shared);
  }
  return causes;
}

/// Everything takes part at first; a downward sensor's surface is the likeliest by the sources of `options`.
std::vector<Labels> first_labels(const std::vector<HeightSample>& samples, const FuseOptions& options) {
  std::vector<Labels> labels(samples.size());
  const std::vector<Seen> seen = likely_surfaces(samples, options);
  for (std::size_t i = 0; i < samples.size(); ++i) labels[i].vps = seen[i];
  return labels;
}

/// Whether all downward readings were taken for one surface.
bool on_one_level(const std::vector<Labels>& labels) {
  const auto saw = [&](Seen seen) {
    return std::any_of(labels.begin(), labels.end(), [seen](const Labels& l) { return l.vps == seen; });
  };
  return !(saw(Seen::canopy) && saw(Seen::soil));
}

/// The noise of one source over its claim: residuals against what is left of its variance once its own pull
/// is taken out (eq. 11.5). Readings that are about to be left out tell nothing of it.
double seen_noise(const std::vector<HeightSample>& samples, const std::vector<Belief>& beliefs,
                  const std::vector<Labels>& labels, const std::vector<Labels>& next, HeightSource source,
                  const Setup& setup) {
  constexpr double kLeastLeft = 0.05;  // readings that nothing else checks say nothing of their noise
  const double scale = setup.noise_scale[static_cast<std::size_t>(place(source))];
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
                                               const std::vector<Labels>& next, const Setup& setup) {
  std::array<double, kHeightSources> scales = {};
  for (const HeightSource source : kAllHeightSources)
    scales[static_cast<std::size_t>(place(source))] =
        seen_noise(samples, beliefs, labels, next, source, setup);
  return scales;
}

bool same(const std::array<double, kHeightSources>& a, const std::array<double, kHeightSources>& b) {
  constexpr double kAlike = 0.01;
  return std::equal(a.begin(), a.end(), b.begin(),
                    [](double x, double y) { return std::abs(x - y) < kAlike * y; });
}

/// Smooths until labels and noise stay; counts the passes.
void settle(const std::vector<HeightSample>& samples, std::vector<Labels>& labels, Setup& setup,
            int& passes) {
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    ++passes;
    const std::vector<Belief> beliefs = smooth(samples, labels, setup);
    std::vector<Labels> next;
    for (std::size_t i = 0; i < samples.size(); ++i)
      next.push_back(label(samples[i], beliefs[i], labels[i], setup));
    const auto noise = seen_noises(samples, beliefs, labels, next, setup);
    if (same(next, labels) && same(noise, setup.noise_scale)) break;
    labels = std::move(next);
    setup.noise_scale = noise;
  }
}

/// -2 ln likelihood of all readings but for a constant, those left out counted as standing at the gate.
double misfit(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
              const Setup& setup) {
  double sum = filter(samples, labels, setup).minus_2_log_likelihood;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (const HeightSource source : kAllHeightSources) {
      const auto reading = reading_of(samples[i], source, labels[i].vps, setup);
      if (!reading || takes_part(labels[i], source)) continue;
      sum += std::pow(setup.options.gate_sigmas, 2) + 2.0 * std::log(reading->sigma);
    }
  }
  return sum;
}

/// Settles from the surfaces that a downward sensor's own changes of level tell, pictures aside, and keeps
/// them where all readings are likelier so (eq. 11.8): rows found on grass are wrong by the rows' height in
/// every shot, and had turned soil into leaves.
void settle_without_pictures_first(const std::vector<HeightSample>& samples, std::vector<Labels>& labels,
                                   Setup& setup, int& passes) {
  FuseOptions blind = setup.options;
  blind.use[static_cast<std::size_t>(place(HeightSource::vision))] = false;
  blind.use[static_cast<std::size_t>(place(HeightSource::depth))] = false;
  std::vector<Labels> others = first_labels(samples, blind);
  if (on_one_level(others)) return;
  Setup other = setup;
  other.noise_scale.fill(1.0);
  settle(samples, others, other, passes);
  if (!(misfit(samples, others, other) < misfit(samples, labels, setup))) return;
  labels = std::move(others);
  setup.noise_scale = other.noise_scale;
}

FusedHeight describe(const HeightSample& sample, const Belief& belief, const Labels& labels,
                     const Setup& setup, bool surface_open) {
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
    fused.residual_m[static_cast<std::size_t>(place(source))] =
        reading->value - reading->row.dot(belief.mean);
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

}  // namespace

std::string source_name(HeightSource source) {
  static const char* const kNames[kHeightSources] = {"vision", "depth", "baro", "vps", "gnss"};
  return kNames[place(source)];
}

Result<FusedFlight> fuse(const std::vector<HeightSample>& samples, const FuseOptions& options) {
  Setup setup{options, causes_of(samples), 0.0};
  FURROW_DO(check_input(samples, setup));
  std::vector<Labels> labels = first_labels(samples, options);
  FusedFlight flight;
  settle(samples, labels, setup, flight.passes);
  settle_without_pictures_first(samples, labels, setup, flight.passes);
  setup.curvature_sigma = likeliest_curvature(samples, labels, setup);
  if (setup.curvature_sigma > 0.0) {
    // What was taken for noise of the others may have been the ground.
    setup.noise_scale.fill(1.0);
    labels = first_labels(samples, options);
    settle(samples, labels, setup, flight.passes);
    settle_without_pictures_first(samples, labels, setup, flight.passes);
  }
  flight.ground_curvature_per_m = setup.curvature_sigma;
  const std::vector<Belief> beliefs = smooth(samples, labels, setup);
  flight.noise_scale = setup.noise_scale;
  flight.surface_open = !any_absolute(samples, setup) && on_one_level(labels);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    flight.heights.push_back(describe(samples[i], beliefs[i], labels[i], setup, flight.surface_open));
  }
  count_sources(flight);
  const Belief& last = beliefs.back();
  const auto bias = [&](int at, HeightSource source) {
    return Estimate{last.mean[at], std::sqrt(last.covariance(at, at)),
                    flight.used[static_cast<std::size_t>(place(source))]};
  };
  flight.baro_bias_m = bias(kBaroBias, HeightSource::baro);
  flight.gnss_bias_m = bias(kGnssBias, HeightSource::gnss);
  flight.depth_bias_m = bias(kDepthBias, HeightSource::depth);
  return flight;
}

}  // namespace furrow::altitude
