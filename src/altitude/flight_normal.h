#pragma once
#include <Eigen/Core>
#include <vector>

#include "arrow.h"
#include "flight_system.h"

namespace furrow::altitude {

/// Derivatives of a member's residuals: by its pose, then by what the flight shares.
inline constexpr int kAllSize = kPoseSize + kSharedSize;

/// A member's residuals (rows, then gimbal) with derivatives by pose, farm and flight.
struct MemberJacobian {
  Eigen::VectorXd residuals;
  Eigen::Matrix<double, Eigen::Dynamic, kAllSize> jacobian;
  Eigen::Index row_residuals = 0;
};

MemberJacobian linearise(const FlightMember& member, const SharedVector& shared);

/// The flight's normal equations at the solution (eq. 9.4), with the misfit that scales them (eq. 8.2).
struct FlightNormal {
  ArrowMatrix matrix;
  double noise_scale2 = 1.0, residual_rms = 0.0;
  std::vector<double> member_rms;  ///< of each member's own residuals
};

/// `repeats` shots in a row tell the shared quantities no more than one (eq. 9.7).
FlightNormal normal_of(const FlightSystem& flight, double repeats);

}  // namespace furrow::altitude
