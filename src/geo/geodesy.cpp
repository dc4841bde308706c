#include "furrow/geo/geodesy.h"

#include <GeographicLib/Geodesic.hpp>
#include <GeographicLib/LocalCartesian.hpp>

namespace furrow::geo {
namespace {

GeographicLib::LocalCartesian local_cartesian(const Geodetic& origin) {
  return {origin.latitude_deg, origin.longitude_deg, origin.height_ellipsoid_m,
          GeographicLib::Geocentric::WGS84()};
}

}  // namespace

Eigen::Vector3d LocalFrame::x_in_world(const Geodetic& point) const {
  Eigen::Vector3d x;
  local_cartesian(origin_).Forward(point.latitude_deg, point.longitude_deg, point.height_ellipsoid_m, x[0],
                                   x[1], x[2]);
  return x;
}

Geodetic LocalFrame::geodetic(const Eigen::Vector3d& x_in_world) const {
  Geodetic point;
  local_cartesian(origin_).Reverse(x_in_world[0], x_in_world[1], x_in_world[2], point.latitude_deg,
                                   point.longitude_deg, point.height_ellipsoid_m);
  return point;
}

Geodesic geodesic(const Geodetic& a, const Geodetic& b) {
  Geodesic result;
  double azimuth_at_b_deg = 0.0;
  GeographicLib::Geodesic::WGS84().Inverse(a.latitude_deg, a.longitude_deg, b.latitude_deg, b.longitude_deg,
                                           result.distance_m, result.azimuth_deg, azimuth_at_b_deg);
  return result;
}

}  // namespace furrow::geo
