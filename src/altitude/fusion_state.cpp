#include "fusion_state.h"

#include <algorithm>
#include <cmath>

namespace furrow::altitude {
namespace {

/// Spread of a quantity of which nothing is known, metres or metres a second: far beyond any flight.
constexpr double kUnknownSigma = 1e4;

/// What is left of the plants' error at the next shot: sums over r alike shots grow as those of a process
/// whose neighbours correlate by (r - 1) / (r + 1) (eq. 11.6).
double kept_of_plants(const FuseOptions& options) {
  const double repeats = std::max(1.0, options.shots_per_stretch);
  return (repeats - 1.0) / (repeats + 1.0);
}

}  // namespace

Eigen::Index state_size(const FusionSetup& setup) {
  return kFirstCause + static_cast<Eigen::Index>(setup.causes.size());
}

Belief start_belief(const FusionSetup& setup) {
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

Step step_of(double dt, const FusionSetup& setup) {
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

}  // namespace furrow::altitude
