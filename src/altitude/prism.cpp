#include "prism.h"

#include <algorithm>
#include <Eigen/Geometry>

#include "furrow/geom/angles.h"

namespace furrow::altitude {

Eigen::Matrix3d cam_from_row(const GimbalAngles& angles) {
  const RowAxes<double> axes = row_axes(angles.theta, angles.lambda, angles.psi);
  const Eigen::Vector3d m(axes.m.x, axes.m.y, axes.m.z), q(axes.q.x, axes.q.y, axes.q.z);
  Eigen::Matrix3d rotation;
  rotation << m.cross(q), m, q;
  return rotation;
}

geom::Attitude attitude_from(const GimbalAngles& angles) {
  return geom::attitude_of(cam_from_row(angles));
}

Eigen::Matrix3d attitude_jacobian(const GimbalAngles& angles) {
  // Central differences: a step of 1e-6 rad leaves 1e-10 of rounding and 1e-12 of curvature.
  constexpr double kStep = 1e-6;
  Eigen::Matrix3d jacobian;
  for (int i = 0; i < 3; ++i) {
    GimbalAngles plus = angles, minus = angles;
    double GimbalAngles::*const part[] = {&GimbalAngles::theta, &GimbalAngles::lambda, &GimbalAngles::psi};
    plus.*part[i] += kStep;
    minus.*part[i] -= kStep;
    const geom::Attitude a = attitude_from(plus), b = attitude_from(minus);
    jacobian.col(i) =
        Eigen::Vector3d(geom::wrap_angle(a.pitch_rad - b.pitch_rad),
                        geom::wrap_angle(a.roll_rad - b.roll_rad), geom::wrap_angle(a.yaw_rad - b.yaw_rad)) /
        (2.0 * kStep);
  }
  return jacobian;
}

double lambda_of(double pitch_rad, double roll_rad) {
  return std::asin(std::clamp(std::sin(roll_rad) * std::cos(pitch_rad), -1.0, 1.0));
}

}  // namespace furrow::altitude
