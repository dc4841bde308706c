#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// How far two cameras of one size disagree, after the turn between them that says nothing (nobody knows a
/// lens's own axes better than its calibration did) is taken out.
struct CameraDifference {
  Eigen::Vector3d b_from_a_rad = Eigen::Vector3d::Zero();  ///< that turn, as a rotation vector
  double rms_px = 0.0;   ///< root mean square distance over the places compared
  double mean_px = 0.0;  ///< mean distance
  double largest_px = 0.0;
  /// What the two covariances let one expect for rms_px; NaN when either is unknown.
  double expected_rms_px = 0.0;
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> at_px;  ///< places in a, row by row
  std::vector<Eigen::Vector2d>
      difference_px;            ///< b's pixel of the same direction minus a's; NaN where either has none
  double compared_share = 0.0;  ///< of the places
};

/// Compares on a grid of columns x rows places over the picture, at infinity; with a convex outline `within`
/// (geom::convex_hull, as of all corners that a's boards showed) only in there: elsewhere both extrapolate.
/// Errors: picture_sizes_differ; cameras_do_not_meet (fewer than 3 places have a ray in both).
Result<CameraDifference> compare_cameras(const Camera& a, const Camera& b, int columns = 24, int rows = 16,
                                         const std::vector<Eigen::Vector2d>& within = {});

/// How the picture bends when the intrinsics change: derivatives of the pixels, x and y in turn, of columns x
/// rows directions over the picture by the intrinsics, with what a turn of the camera would do as well taken
/// out (docs/formulation/camera.md, eq. 5). Directions without a ray are left out.
Eigen::MatrixXd picture_change(const Camera& camera, int columns = 24, int rows = 16);

}  // namespace furrow::camera
