#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "furrow/camera/camera.h"
#include "furrow/geom/rigid3.h"
#include "furrow/target/board.h"

namespace furrow::calib {

/// The board's shape beside its counts and its square: what a solve may free.
inline constexpr int kBoardTerms = 3;  ///< aspect, warp along x, warp along y

/// How the free parameters that all views share make up a camera and a board: each entry of full = (fx, fy,
/// cx, cy, distortion..., aspect, warp_x, warp_y) is one of `shared`, or stays as it is.
struct SharedModel {
  Camera camera;            ///< model and size; its intrinsics are replaced
  target::BoardSpec board;  ///< counts and square
  Eigen::VectorXd full;     ///< of what is not free
  std::vector<int> column;  ///< place in `shared` of each entry of full; -1 where it is not free
  Eigen::Index count = 0;   ///< of `shared`
  /// Weak knowledge of `shared` beside the pictures: residuals prior_weight * (shared - prior_mean), px.
  /// Empty for none.
  Eigen::VectorXd prior_weight, prior_mean;

  Eigen::Index intrinsics_count() const { return full.size() - kBoardTerms; }
};

/// Which of the full parameters a solve frees.
struct FreeTerms {
  bool core = true;            ///< fx, fy, cx, cy; a splined model's knots do their work
  bool square_pixels = false;  ///< fx and fy are one parameter
  bool aspect = false;
  bool warp = false;
  int distortion = 0;  ///< the first so many coefficients
};

/// A model with `free`'s parameters; the rest stays as camera, aspect and warp_m say. `shared` of these
/// values: shared_of().
SharedModel make_shared_model(const Camera& camera, const target::BoardSpec& board,
                              const Eigen::Vector2d& warp_m, const FreeTerms& free);
Eigen::VectorXd shared_of(const SharedModel& model);

/// full, with what `shared` says put in.
Eigen::VectorXd full_of(const SharedModel& model, const Eigen::VectorXd& shared);

/// A covariance of `shared` as one of full, 0 for what is not free.
Eigen::MatrixXd full_covariance(const SharedModel& model, const Eigen::MatrixXd& shared);

/// What `shared` says.
Camera camera_of(const SharedModel& model, const Eigen::VectorXd& shared);
target::BoardSpec board_of(const SharedModel& model, const Eigen::VectorXd& shared);
Eigen::Vector2d warp_of(const SharedModel& model, const Eigen::VectorXd& shared);

/// Rotation vector (rad) and translation (m) of cam_from_board.
using PoseVector = Eigen::Matrix<double, 6, 1>;
PoseVector pose_vector(const Rigid3& cam_from_board);
Rigid3 pose_of(const PoseVector& pose);

/// d(turn, shift) / d(pose vector): a point x_in_cam that moves with the board moves by turn x x + shift.
Eigen::Matrix<double, 6, 6> drift_of_pose(const PoseVector& pose);

/// Residuals projected - observed, px, x and y in turn, and their derivatives, row-major so that Ceres can
/// own the memory.
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Corners seen in one view. `ids` as target::BoardDetection::corner_ids: empty means all of the board's.
struct SeenCorners {
  std::vector<int> ids;
  std::vector<Eigen::Vector2d> px;
};
inline int corner_id(const std::vector<int>& ids, std::size_t c) {
  return ids.empty() ? static_cast<int>(c) : ids[c];
}

/// Evaluates one view. `weight` has one entry a corner or none; `d_shared`, `d_pose` may be null. False when
/// a corner falls behind the camera or has no finite pixel.
bool evaluate_view(const SharedModel& model, const Eigen::VectorXd& shared, const PoseVector& pose,
                   const SeenCorners& seen, const std::vector<double>& weight, double* residual,
                   double* d_shared, double* d_pose);

/// One corner of a splined camera by the patch it is held to.
struct PatchCorner {
  std::optional<camera::Projection> seen;
  Eigen::Matrix<double, 2, 6> d_pose;
  Eigen::Matrix2d d_warp;
};
PatchCorner evaluate_patch_corner(const SharedModel& model, const Camera& camera, const PoseVector& pose,
                                  const Eigen::Vector2d& warp_m, int corner,
                                  const camera::SplinePatch& patch);

/// A corner of a warped board: z = warp_x (1 - x'^2) + warp_y (1 - y'^2) with x', y' from -1 to 1 across the
/// corners (mrcal's calobject_warp).
Eigen::Vector3d warped_corner(const target::BoardSpec& board, const Eigen::Vector2d& warp_m, int i, int j);

}  // namespace furrow::calib
