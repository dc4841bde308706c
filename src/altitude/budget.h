#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "shot_system.h"

namespace furrow::altitude {

/// Adds a part to its cause's share, in squares; a new cause goes to the end.
void add_share(std::vector<SigmaShare>& shares, const std::string& cause, double sigma_m);

/// Adds what the noise of a shot's own rows does to a height, as picture and plants. `gain` is the height's
/// derivative by each of their whitened residuals (eq. 8.6).
void add_row_shares(std::vector<SigmaShare>& shares, const ShotSystem& system, const Eigen::RowVectorXd& gain,
                    double noise_scale2);

/// Adds what the camera's covariance does to a height with the derivative `by_intrinsics`, as focal and
/// distortion; their correlation goes half to each, as it enters the sum twice, so a share may be negative.
void add_camera_shares(std::vector<SigmaShare>& shares, const Eigen::RowVectorXd& by_intrinsics,
                       const Camera& camera);

}  // namespace furrow::altitude
