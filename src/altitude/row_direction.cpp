#include "row_direction.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

using geom::kPi;

/// Plane through the camera's centre and a line, as a unit normal.
Eigen::Vector3d plane_of(const EdgeLine& line) {
  return line.points[0].homogeneous().cross(line.points[1].homogeneous()).normalized();
}

}  // namespace

RowDirectionFit fit_direction(const std::vector<EdgeLine>& lines) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const EdgeLine& line : lines) {
    const Eigen::Vector3d normal = plane_of(line);
    const double half_length = 0.5 * (line.points[1] - line.points[0]).norm();
    information += half_length * half_length / line.variance.mean() * normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
  RowDirectionFit fit;
  fit.direction = eigen.eigenvectors().col(0);
  // Forward is the end of the row that the upper part of the picture shows.
  if (fit.direction.dot(Eigen::Vector3d(0, -1, 1)) < 0.0) fit.direction = -fit.direction;
  const Eigen::Vector3d& v = fit.direction;
  const Eigen::Vector3d nod = Eigen::Vector3d(0.0, v.z(), -v.y()).normalized();
  double variance = 0.0;
  for (int i = 1; i < 3; ++i) {
    const double part = nod.dot(eigen.eigenvectors().col(i));
    variance += part * part / std::max(eigen.eigenvalues()[i], 1e-300);
  }
  fit.pitch_sigma = std::sqrt(variance);
  return fit;
}

double yaw_at_pitch(const std::vector<EdgeLine>& lines, double theta) {
  double xx = 0.0, xm = 0.0, mm = 0.0;
  for (const EdgeLine& line : lines) {
    const Eigen::Vector3d l = plane_of(line);
    const double weight = (line.points[1] - line.points[0]).squaredNorm() / line.variance.mean();
    const double m = l.y() * std::sin(theta) + l.z() * std::cos(theta);
    xx += weight * l.x() * l.x();
    xm += weight * l.x() * m;
    mm += weight * m * m;
  }
  // The (sin psi, cos psi) of the smallest weighted sum of (l_x sin psi + m cos psi)^2.
  const double angle = 0.5 * std::atan2(2.0 * xm, xx - mm) + kPi / 2.0;
  return std::remainder(kPi / 2.0 - angle, kPi);
}

}  // namespace furrow::altitude
