#pragma once
#include <optional>
#include <vector>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// What a person asks of a camera.
struct Description {
  Eigen::Vector2d focal_px = Eigen::Vector2d::Zero();  ///< on the axis, across and down
  /// Angles that the picture spans, from border to border through its middle and from corner to corner,
  /// distortion counted; nothing where a border has no ray.
  std::optional<double> horizontal_rad, vertical_rad, diagonal_rad;
  /// How far the corner farthest from the principal point lies from where a pinhole of the same focal length
  /// would have it, px; negative towards the middle (barrel). Nothing when it has no ray, or one at 90
  /// degrees and more.
  std::optional<double> corner_distortion_px;
  /// Share of the picture without an inverse (see unproject_ray), from 0 to 1, on a grid of 64 x 48 places.
  double without_inverse = 0.0;
  /// Distance from the principal point beyond which the first such place lies, px; nothing when there is
  /// none.
  std::optional<double> inverse_reach_px;
};
Description describe(const Camera& camera);

/// One place on the way from the principal point to the farthest corner.
struct DistortionPoint {
  double radius_px = 0.0;  ///< from the principal point
  double angle_rad = 0.0;  ///< of its ray from the axis
  double shift_px =
      0.0;  ///< radius minus that of a pinhole of the same focal length, NaN at 60 degrees and more
};
/// `count` places, as far as the camera has rays.
std::vector<DistortionPoint> distortion_curve(const Camera& camera, int count = 100);

}  // namespace furrow::camera
