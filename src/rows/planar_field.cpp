#include "furrow/rows/planar_field.h"

#include <cmath>

namespace furrow::rows {

double PlanarField::u_at(double v, double k) const {
  const double d = scale(v);
  const double y = t(v) / d;
  return u0 + d * (offset + y * (slope + y * (bend + y * bend2)) + k * spacing);
}

double PlanarField::k_at(double u, double v) const {
  return (u - u_at(v, 0.0)) / spacing_at(v);
}

std::optional<double> PlanarField::horizon_v() const {
  if (convergence == 0.0) return std::nullopt;
  return v0 - length / convergence;
}

std::optional<Eigen::Vector2d> PlanarField::vanishing_point(double least_convergence) const {
  if (std::abs(convergence) < least_convergence) return std::nullopt;
  return Eigen::Vector2d{u0 - slope / convergence, v0 - length / convergence};
}

}  // namespace furrow::rows
