#include "furrow/geom/attitude.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>

namespace furrow::geom {
namespace {

/// Forward-left-up to right-down-forward.
Eigen::Matrix3d cam_from_body() {
  Eigen::Matrix3d m;
  m << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return m;
}

}  // namespace

Eigen::Matrix3d cam_from_level(const Attitude& attitude) {
  const Eigen::Matrix3d level_from_body = (Eigen::AngleAxisd(attitude.yaw_rad, Eigen::Vector3d::UnitZ()) *
                                           Eigen::AngleAxisd(-attitude.pitch_rad, Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(attitude.roll_rad, Eigen::Vector3d::UnitX()))
                                              .toRotationMatrix();
  return cam_from_body() * level_from_body.transpose();
}

Attitude attitude_of(const Eigen::Matrix3d& cam_from_level_rotation) {
  const Eigen::Matrix3d m =
      (cam_from_body().transpose() * cam_from_level_rotation).transpose();  // level_from_body
  const double sine = std::clamp(m(2, 0), -1.0, 1.0);
  const double cosine = std::hypot(m(0, 0), m(1, 0));
  // Straight up or down: only yaw - roll (or + roll) is defined.
  if (cosine < 1e-9) return {std::atan2(-m(0, 1), m(1, 1)), std::copysign(std::acos(0.0), sine), 0.0};
  return {std::atan2(m(1, 0), m(0, 0)), std::atan2(sine, cosine), std::atan2(m(2, 1), m(2, 2))};
}

}  // namespace furrow::geom
