#include "furrow/geom/rigid3.h"

#include <cmath>

namespace furrow::geom {

Rigid3 inverse(const Rigid3& b_from_a) {
  const Eigen::Quaterniond a_from_b = b_from_a.rotation.conjugate();
  return {a_from_b, -(a_from_b * b_from_a.translation)};
}

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  const Eigen::Vector3d axis_times_sine = sign * rotation.vec();
  const double sine = axis_times_sine.norm();
  // Below this sine the angle equals twice the sine to double precision.
  if (sine < 1e-10) return 2.0 * axis_times_sine;
  return axis_times_sine * (2.0 * std::atan2(sine, sign * rotation.w()) / sine);
}

Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& rotation_vector_rad) {
  const double angle = rotation_vector_rad.norm();
  if (angle < 1e-10) {
    return Eigen::Quaterniond(1.0, 0.5 * rotation_vector_rad.x(), 0.5 * rotation_vector_rad.y(),
                              0.5 * rotation_vector_rad.z())
        .normalized();
  }
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, rotation_vector_rad / angle));
}

}  // namespace furrow::geom
