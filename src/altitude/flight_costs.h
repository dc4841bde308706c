#pragma once
#include <cmath>

#include "flight_system.h"

namespace furrow::altitude {

// What a flight minimises, observation by observation: for Ceres, and on jets for the normal equations.

/// One row of one shot; parameter blocks pose, farm and flight.
struct FlightRowCost {
  const WeightedBlock* block = nullptr;
  template <class T>
  bool operator()(const T* pose, const T* farm, const T* flight, T* residuals) const {
    if (!sane_pose(pose)) return false;
    whitened_residuals(*block, pose, farm, residuals, T(1.0 + flight[kFocal]));
    return true;
  }
};

/// Log pitch = theta + bias + direction x slope; log roll = lambda + bias (eq. 9.2).
struct GimbalCost {
  const FlightMember* member = nullptr;
  template <class T>
  bool operator()(const T* pose, const T* flight, T* residuals) const {
    residuals[0] = residuals[1] = T(0.0);
    if (member->log_theta.usable()) {
      residuals[0] = (pose[kTheta] + flight[kPitchBias] + member->direction * flight[kTerrainSlope] -
                      member->log_theta.value) /
                     member->log_theta.sigma;
    }
    if (member->log_lambda.usable()) {
      residuals[1] =
          (pose[kLambda] + flight[kRollBias] - member->log_lambda.value) / member->log_lambda.sigma;
    }
    return true;
  }
};

/// The step of the height between two neighbours; parameter blocks their poses (eq. 9.3).
struct TieCost {
  HeightTie tie;
  template <class T>
  bool operator()(const T* first, const T* second, T* residual) const {
    using std::exp;
    if (!sane_pose(first) || !sane_pose(second)) return false;
    residual[0] = (exp(second[kLogHeight]) - exp(first[kLogHeight]) - tie.step_m) / tie.sigma_m;
    return true;
  }
};

}  // namespace furrow::altitude
