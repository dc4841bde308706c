#pragma once
#include <array>
#include <cstddef>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "furrow/altitude/fuse.h"

namespace furrow::altitude {

/// Places in the state: height above canopy, climb rate, each source's bias, the error of the stated row
/// height, of the leaves' level under a downward sensor, what the plants of this stretch do to the pictures
/// (in their own sigmas), the canopy's level with its rate, and its curvature. Behind them each cause that
/// the flight's pictures share, in its sigma.
inline constexpr int kHeight = 0, kClimb = 1, kBaroBias = 2, kGnssBias = 3, kDepthBias = 4, kRowHeight = 5,
                     kVpsCanopy = 6, kPlants = 7, kGround = 8, kGroundRate = 9, kCurvature = 10,
                     kFirstCause = 11;
using State = Eigen::VectorXd;
using StateMatrix = Eigen::MatrixXd;

inline std::size_t place(HeightSource source) {
  return static_cast<std::size_t>(source);
}

/// The options, the causes that the flight's pictures share, and the noise of each source over its claim.
struct FusionSetup {
  const FuseOptions& options;
  std::vector<std::string> causes;
  double curvature_sigma = 0.0;  ///< of the ground, 1/m
  std::array<double, kHeightSources> noise_scale = {1.0, 1.0, 1.0, 1.0, 1.0};
};

/// What is known of the state at one moment.
struct Belief {
  State mean;
  StateMatrix covariance;
};

Eigen::Index state_size(const FusionSetup& setup);

/// Before the first reading.
Belief start_belief(const FusionSetup& setup);

/// Transition and noise over `dt` (eq. 11.1): white acceleration, biases that walk.
struct Step {
  StateMatrix transition, noise;
};
Step step_of(double dt, const FusionSetup& setup);

}  // namespace furrow::altitude
