#pragma once
#include <numbers>

namespace furrow::geom {

inline constexpr double kPi = std::numbers::pi;
constexpr double deg_to_rad(double degrees) {
  return degrees * (kPi / 180.0);
}
constexpr double rad_to_deg(double radians) {
  return radians * (180.0 / kPi);
}

/// The same angle in [-pi, pi).
double wrap_angle(double radians);

}  // namespace furrow::geom
