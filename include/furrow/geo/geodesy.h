#pragma once
#include <Eigen/Core>

namespace furrow::geo {

/// WGS84.
struct Geodetic {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double height_ellipsoid_m = 0.0;
};

/// East-north-up frame ("world") at an origin. Exact (GeographicLib's LocalCartesian), not a flat-earth
/// approximation.
class LocalFrame {
 public:
  explicit LocalFrame(const Geodetic& origin) : origin_(origin) {}
  Eigen::Vector3d x_in_world(const Geodetic& point) const;
  Geodetic geodetic(const Eigen::Vector3d& x_in_world) const;
  const Geodetic& origin() const { return origin_; }

 private:
  Geodetic origin_;
};

/// Length (m) and starting azimuth (deg clockwise from north) of the geodesic from a to b on the ellipsoid.
struct Geodesic {
  double distance_m = 0.0;
  double azimuth_deg = 0.0;
};
Geodesic geodesic(const Geodetic& a, const Geodetic& b);

}  // namespace furrow::geo
