#pragma once
#include <Eigen/Core>
#include <optional>

namespace furrow::rows {

/// Equally spaced rows on a plane, as a picture shows them: one model for all rows
/// (docs/formulation/rows.md).
///
/// With t = (v - v0) / L, D(t) = 1 + g t (the spacing on picture row v, relative to the one at v0) and y = t
/// / D (depth along the rows),
///     u_k(v) = u0 + D (offset + slope y + bend y^2 + bend2 y^3 + k spacing).
/// g > 0: the rows converge upwards and meet where D = 0, the horizon of the plane; g = 0: a view straight
/// down, rows parallel in the picture. Nothing is singular there, so one parametrisation serves oblique and
/// nadir views.
struct PlanarField {
  double u0 = 0.0, v0 = 0.0;  ///< anchor: middle column, bottom row of the picture, px
  double length = 1.0;        ///< L: height of the picture, px
  double convergence = 0.0;   ///< g
  double spacing = 1.0;       ///< between neighbours on the bottom row, px
  double offset = 0.0;        ///< of row 0 on the bottom row from u0, px
  double slope = 0.0;         ///< px per picture height
  double bend = 0.0;          ///< common curvature, px
  double bend2 = 0.0;         ///< its change along the rows, px

  double t(double v) const { return (v - v0) / length; }
  double scale(double v) const { return 1.0 + convergence * t(v); }
  /// Distance between neighbours along the picture row, px; zero or less at and above the horizon.
  double spacing_at(double v) const { return spacing * scale(v); }
  /// Centre of row k (any real number) on picture row v. Only below the horizon: scale(v) > 0.
  double u_at(double v, double k) const;
  /// Real-valued row number at (u, v); whole numbers are row centres. Only below the horizon.
  double k_at(double u, double v) const;
  /// Picture row of the horizon, or nothing when g is 0.
  std::optional<double> horizon_v() const;
  /// Where straight rows meet, or nothing when they are parallel within `least_convergence`.
  std::optional<Eigen::Vector2d> vanishing_point(double least_convergence = 0.02) const;
};

}  // namespace furrow::rows
