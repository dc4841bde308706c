#include "furrow/geo/geoid.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "damaged.h"
#include "furrow/base/random.h"

namespace furrow::geo {
namespace {

void append_big_endian(std::string& out, std::uint64_t word, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<char>((word >> (8 * i)) & 255));
}
void append_double(std::string& out, double value) {
  append_big_endian(out, std::bit_cast<std::uint64_t>(value), 8);
}

/// A 45-degree grid whose height is a smooth function of the place.
std::string small_gtx(double (*height_m)(double latitude_deg, double longitude_deg)) {
  std::string out;
  append_double(out, -90.0);
  append_double(out, -180.0);
  append_double(out, 5.0);
  append_double(out, 5.0);
  append_big_endian(out, 37, 4);
  append_big_endian(out, 72, 4);
  for (int r = 0; r < 37; ++r)
    for (int c = 0; c < 72; ++c)
      append_big_endian(
          out, std::bit_cast<std::uint32_t>(static_cast<float>(height_m(-90.0 + 5.0 * r, -180.0 + 5.0 * c))),
          4);
  return out;
}
double smooth_m(double latitude_deg, double longitude_deg) {
  const double d = std::acos(-1.0) / 180.0;
  return 20.0 * std::cos(latitude_deg * d) * std::cos((longitude_deg - 30.0) * d) +
         5.0 * std::sin(latitude_deg * d);
}

// Published EGM96 heights: NGA's F477 test points (OUTPUT.DAT) and the GeoidEval(1) man page; the 15' grid
// adds interpolation error, 7 mm RMS and 0.17 m at most (GeographicLib manual), so 25 mm is three sigma here.
TEST(Geoid, Egm96MatchesPublishedPoints) {
  const auto grid = egm96();
  if (!grid.ok()) GTEST_SKIP() << grid.error().message();
  struct Point {
    double latitude_deg, longitude_deg, height_m;
  };
  const Point points[] = {{38.6281550, 269.7791550, -31.628},
                          {-14.6212170, 305.0211140, -2.969},
                          {46.8743190, 102.4487290, -43.575},
                          {-23.6174460, 133.8747120, 15.871},
                          {38.6254730, 359.9995, 50.066},
                          {-0.466744, 0.0023, 17.329},
                          {16.0 + 46.55 / 60.0, -(3.0 + 34.0 / 3600.0), 28.7068}};
  for (const Point& p : points)
    EXPECT_NEAR(geoid_height_m(*grid, p.latitude_deg, p.longitude_deg), p.height_m, 0.025)
        << p.latitude_deg << " " << p.longitude_deg;
  EXPECT_NEAR(geoid_height_m(*grid, 90.0, 123.0), 13.606, 0.005);
  EXPECT_NEAR(geoid_height_m(*grid, -90.0, -7.0), -29.534, 0.005);
}

TEST(Geoid, InterpolationIsExactAtNodesAndGoodBetween) {
  const auto grid = parse_gtx(small_gtx(smooth_m), "small");
  ASSERT_TRUE(grid.ok()) << grid.error().message();
  EXPECT_NEAR(geoid_height_m(*grid, 40.0, -35.0), smooth_m(40.0, -35.0), 1e-5);
  base::Random random(7);
  for (int i = 0; i < 2000; ++i) {
    const double latitude_deg = random.uniform(-90.0, 90.0), longitude_deg = random.uniform(-200.0, 400.0);
    EXPECT_NEAR(geoid_height_m(*grid, latitude_deg, longitude_deg), smooth_m(latitude_deg, longitude_deg),
                0.005)
        << latitude_deg << " " << longitude_deg;
  }
}

TEST(Geoid, IsContinuousAcrossDateLineAndPole) {
  const auto grid = egm96();
  if (!grid.ok()) GTEST_SKIP() << grid.error().message();
  EXPECT_NEAR(geoid_height_m(*grid, 10.1, 180.0 - 1e-9), geoid_height_m(*grid, 10.1, -180.0 + 1e-9), 1e-6);
  EXPECT_NEAR(geoid_height_m(*grid, 90.0 - 1e-9, 20.0), geoid_height_m(*grid, 90.0 - 1e-9, -160.0), 1e-6);
  EXPECT_TRUE(std::isnan(geoid_height_m(*grid, 90.1, 0.0)));
  EXPECT_TRUE(std::isnan(geoid_height_m(*grid, 0.0, INFINITY)));
}

TEST(Geoid, MalformedGridsAreErrors) {
  const std::string good = small_gtx(smooth_m);
  EXPECT_EQ(parse_gtx("", "x").error().code, "geoid_malformed");
  EXPECT_EQ(parse_gtx(good.substr(0, 39), "x").error().code, "geoid_malformed");
  EXPECT_EQ(parse_gtx(good.substr(0, good.size() - 1), "x").error().code, "geoid_malformed");
  std::string huge = good;
  for (int i = 32; i < 40; ++i) huge[static_cast<std::size_t>(i)] = '\x7f';
  EXPECT_EQ(parse_gtx(huge, "x").error().code, "geoid_malformed");
  EXPECT_EQ(parse_gtx(small_gtx([](double, double) { return std::nan(""); }), "x").error().code,
            "geoid_malformed");
  EXPECT_EQ(parse_gtx(small_gtx([](double, double) { return 1e6; }), "x").error().code, "geoid_malformed");
}

TEST(Geoid, DamagedGridsAreGridsOrErrors) {
  const std::string good = small_gtx(smooth_m);
  base::Random random(27112026);
  for (int i = 0; i < 1000; ++i) {
    const auto grid = parse_gtx(testing::damaged(good, random), "x");
    if (grid.ok()) {
      EXPECT_TRUE(std::isfinite(geoid_height_m(*grid, 48.0, 11.0)));
    } else {
      EXPECT_EQ(grid.error().code, "geoid_malformed");
    }
  }
}

}  // namespace
}  // namespace furrow::geo
