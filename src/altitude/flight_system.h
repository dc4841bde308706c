#pragma once
#include <cstddef>
#include <Eigen/Core>
#include <vector>

#include "furrow/altitude/flight.h"
#include "shot_system.h"

namespace furrow::altitude {

/// Places in the flight block, which follows the farm block in the shared vector.
inline constexpr int kPitchBias = 0, kRollBias = 1, kTerrainSlope = 2, kFocal = 3, kFlightSize = 4;
inline constexpr int kSharedSize = kFarmSize + kFlightSize;
inline constexpr const char* kSharedNames[kSharedSize] = {
    "row_spacing", "half_width", "foliage_depth", "base_ratio",    "rounding",
    "softness",    "pitch_bias", "roll_bias",     "terrain_slope", "focal_factor"};

using SharedVector = Eigen::Matrix<double, kSharedSize, 1>;

/// One shot that takes part.
struct FlightMember {
  std::size_t input = 0;  ///< place in the flight's shots
  PreparedShot shot;
  Estimate log_theta, log_lambda;  ///< gimbal's reading with its shot-to-shot sigma
  double direction = 1.0;
  RefinedShot alone;  ///< by this shot alone
};

/// A tie between the heights of two neighbours in `members`.
struct HeightTie {
  std::size_t first = 0;  ///< place of the first; the second follows
  double step_m = 0.0, sigma_m = 1.0;
};

/// Everything that the refinement of a flight minimises (eq. 9.1 to 9.3).
struct FlightSystem {
  std::vector<FlightMember> members;
  std::vector<HeightTie> ties;
  std::vector<ParameterPrior> shared_priors;  ///< parameter is a place in the shared vector
  SharedVector shared = SharedVector::Zero();
};

/// Priors on what the shots share: the farm's numbers, then the flight's.
std::vector<ParameterPrior> shared_priors(const Farm& farm, const std::vector<ShotInput>& shots,
                                          const FlightOptions& options);

/// Ties of neighbouring members' heights by the log's steps and by the random walk (eq. 9.3).
std::vector<HeightTie> ties_of(const std::vector<FlightMember>& members, const std::vector<ShotInput>& shots,
                               const FlightOptions& options);

/// Least squares over the whole flight; members and shared quantities then stand at the solution.
SolveReport solve(FlightSystem& flight, const FlightOptions& options);

}  // namespace furrow::altitude
