#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace furrow::geom {

/// Rigid motion `b_from_a`: x_in_b = rotation * x_in_a + translation. Products cancel by eye: c_from_a =
/// c_from_b * b_from_a.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< unit quaternion
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< metres

  Eigen::Vector3d operator*(const Eigen::Vector3d& x_in_a) const { return rotation * x_in_a + translation; }
  Rigid3 operator*(const Rigid3& a_from_z) const {
    return {(rotation * a_from_z.rotation).normalized(), rotation * a_from_z.translation + translation};
  }
};

/// a_from_b for b_from_a.
Rigid3 inverse(const Rigid3& b_from_a);

/// Rotation vector (axis x angle, radians; angle in [0, pi]) of a unit quaternion, and back.
Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation);
Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& rotation_vector_rad);

}  // namespace furrow::geom

namespace furrow {
using geom::Rigid3;
}
