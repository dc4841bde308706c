#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

namespace furrow::target {

/// picture_from_board: the homography that carries points of a plane to pixels, by the normalised direct
/// linear transform (Hartley and Zisserman, Multiple View Geometry, alg. 4.2), scaled to unit Frobenius norm.
/// Nothing for fewer than 4 points, or points in a line.
std::optional<Eigen::Matrix3d> fit_homography(const std::vector<Eigen::Vector2d>& board,
                                              const std::vector<Eigen::Vector2d>& px);

}  // namespace furrow::target
