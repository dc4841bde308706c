#pragma once
#include <array>
#include <Eigen/Core>
#include <optional>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Whether the model bends points of the unit plane z = 1 (pinhole and OpenCV's), so that nothing at 90
/// degrees or more from the axis has a pixel; the others bend directions.
bool is_on_unit_plane(CameraModel model);

/// A point after the lens, before focal length and principal point, with its derivatives.
struct Bent {
  Eigen::Vector2d xy;
  Eigen::Matrix<double, 2, 3> d_point;
  /// By the coefficients it depends on, and their places in `distortion`.
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, kMaxActiveIntrinsics - 4> d_coefficients;
  std::array<int, kMaxActiveIntrinsics - 4> place;
};

/// The lens of a model that bends directions (docs/formulation/camera.md, eq. 6 to 9); nothing straight
/// behind.
std::optional<Bent> bend(const Camera& camera, const Eigen::Vector3d& x_in_cam);

/// The same by one patch of a splined model.
std::optional<Bent> bend_by_patch(const Camera& camera, const Eigen::Vector3d& x_in_cam,
                                  const SplinePatch& patch);

/// Unit vector that bends to `xy`; nothing where there is none.
std::optional<Eigen::Vector3d> straighten(const Camera& camera, const Eigen::Vector2d& xy);

/// Angle from the axis at which a fisheye's picture turns back, rad; pi when it does not.
double fisheye_fold_rad(const Camera& camera);

}  // namespace furrow::camera
