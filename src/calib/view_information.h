#pragma once
#include <optional>
#include <vector>

#include "calib/model.h"

namespace furrow::calib {

/// Derivative of the mean focal length on the axis (px) by the intrinsics.
Eigen::VectorXd focal_by_intrinsics(const Camera& camera);

/// What one view of a board tells about (intrinsics, the board's aspect, its warp) with its own pose unknown:
/// their information matrix for residuals of 1 px, over those that its corners depend on. A splined lens has
/// hundreds, of which a board covers a few dozen.
struct ViewInformation {
  std::vector<Eigen::Index> place;  ///< among all, of each row and column of `matrix`
  Eigen::MatrixXd matrix;
};

/// A board held as `pose` before a camera; `ids` as in SeenCorners, `weight` one a corner or
/// none. Nothing where a corner has no pixel or the corners allow no pose.
std::optional<ViewInformation> view_information(const Camera& camera, const target::BoardSpec& board,
                                                const Eigen::Vector2d& warp_m, const PoseVector& pose,
                                                const std::vector<int>& ids,
                                                const std::vector<double>& weight = {});

/// The part of a matrix over all parameters that a view's own are about.
Eigen::MatrixXd part_of(const Eigen::MatrixXd& all, const std::vector<Eigen::Index>& place);

/// How a covariance C of all parameters changes when a view is added (sign +1) or taken away (-1):
/// C - sign C_s E C_s' with C_s the view's columns of C and E = G (1 + sign C_ss G)^-1, which this returns.
/// Nothing where the rest would not determine the lens.
std::optional<Eigen::MatrixXd> information_step(const ViewInformation& view,
                                                const Eigen::MatrixXd& covariance, double sign);

}  // namespace furrow::calib
