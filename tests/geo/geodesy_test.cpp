#include "furrow/geo/geodesy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "furrow/base/random.h"

namespace furrow::geo {
namespace {

double degrees(double d, double minutes, double seconds) {
  return d + minutes / 60.0 + seconds / 3600.0;
}

// CartConvert(1) of GeographicLib, EXAMPLES: `echo 33.3 44.4 6000 | CartConvert -l 33 44 20` => 37288.97
// 33374.29 5783.64. The page's last digit of "up" is cut, not rounded: the ECEF difference turned by hand
// with WGS84's a and f gives the digits below.
TEST(LocalFrame, ForwardMatchesCartConvertManPage) {
  const LocalFrame frame({33.0, 44.0, 20.0});
  const Eigen::Vector3d x = frame.x_in_world({33.3, 44.4, 6000.0});
  EXPECT_NEAR(x[0], 37288.97, 0.01);
  EXPECT_NEAR(x[1], 33374.29, 0.01);
  EXPECT_NEAR(x[2], 5783.64, 0.01);
  EXPECT_NEAR(x[0], 37288.97319662, 1e-6);
  EXPECT_NEAR(x[1], 33374.29494690, 1e-6);
  EXPECT_NEAR(x[2], 5783.64661552, 1e-6);
}

// GeodSolve(1) of GeographicLib, EXAMPLES: JFK to Singapore Changi => 003:18:29.9 177:29:09.2 15347628
TEST(Geodesic, InverseMatchesGeodSolveManPage) {
  const Geodetic jfk{degrees(40, 38, 23), -degrees(73, 46, 44), 0.0};
  const Geodetic changi{degrees(1, 21, 33), degrees(103, 59, 22), 0.0};
  const Geodesic line = geodesic(jfk, changi);
  EXPECT_NEAR(line.distance_m, 15347628.0, 0.5);
  EXPECT_NEAR(line.azimuth_deg, degrees(3, 18, 29.9), 0.05 / 3600.0);
}

TEST(LocalFrame, RoundTripIsExactToNanometresOverAField) {
  base::Random random(20260531);
  for (int i = 0; i < 1000; ++i) {
    const LocalFrame frame(
        {random.uniform(-89.0, 89.0), random.uniform(-180.0, 180.0), random.uniform(-100.0, 4000.0)});
    const Eigen::Vector3d x(random.uniform(-2000.0, 2000.0), random.uniform(-2000.0, 2000.0),
                            random.uniform(-100.0, 500.0));
    EXPECT_LT((frame.x_in_world(frame.geodetic(x)) - x).norm(), 2e-8) << "trial " << i;
  }
}

// The axes themselves: a step in latitude goes north, in longitude east, in height up; lengths against the
// radii of curvature.
TEST(LocalFrame, AxesAreEastNorthUpWithTheEllipsoidsRadii) {
  const double latitude_deg = 48.0, step_deg = 1e-6;
  constexpr double kA_m = 6378137.0, kE2 = 6.69437999014e-3;  // WGS84 (NIMA TR8350.2)
  const double phi = latitude_deg * std::numbers::pi / 180.0, step = step_deg * std::numbers::pi / 180.0;
  const double w = std::sqrt(1.0 - kE2 * std::sin(phi) * std::sin(phi));
  const LocalFrame frame({latitude_deg, 11.0, 0.0});
  const Eigen::Vector3d north = frame.x_in_world({latitude_deg + step_deg, 11.0, 0.0});
  const Eigen::Vector3d east = frame.x_in_world({latitude_deg, 11.0 + step_deg, 0.0});
  EXPECT_NEAR(north[1], kA_m * (1.0 - kE2) / (w * w * w) * step, 1e-6);
  EXPECT_NEAR(east[0], kA_m / w * std::cos(phi) * step, 1e-6);
  EXPECT_NEAR(north[0], 0.0, 1e-9);
  EXPECT_NEAR(east[1], 0.0, 1e-6);
  EXPECT_NEAR(frame.x_in_world({latitude_deg, 11.0, 7.5})[2], 7.5, 1e-9);
}

TEST(Geodesic, NaNGoesInAndComesOut) {
  const double nan = std::nan("");
  EXPECT_TRUE(std::isnan(geodesic({nan, 0, 0}, {1, 1, 0}).distance_m));
  EXPECT_FALSE(LocalFrame({0, 0, 0}).x_in_world({nan, nan, nan}).allFinite());
}

}  // namespace
}  // namespace furrow::geo
