#pragma once
#include <Eigen/Core>

namespace furrow::geom {

/// Where a camera points, as three angles against a level frame with x along the rows, y left, z up (`row`)
/// or east-north-up
/// (`world`, with yaw counter-clockwise from east).
struct Attitude {
  double yaw_rad = 0.0;  ///< about z, positive to the left (counter-clockwise from above)
  double pitch_rad =
      0.0;  ///< elevation of the optical axis: 0 at the horizon, negative below it, -pi/2 straight down
  double roll_rad =
      0.0;  ///< about the optical axis, positive right side down (picture content turns counter-clockwise)
};

/// Rotation matrix cam_from_row = cam_from_body (Rz(yaw) Ry(-pitch) Rx(roll))^T, with cam_from_body mapping
/// forward-left-up to right-down-forward. (docs/conventions.md)
Eigen::Matrix3d cam_from_level(const Attitude& attitude);

/// The inverse of cam_from_level. At pitch -+pi/2 yaw and roll cannot be told apart; roll is then 0.
Attitude attitude_of(const Eigen::Matrix3d& cam_from_level_rotation);

}  // namespace furrow::geom
