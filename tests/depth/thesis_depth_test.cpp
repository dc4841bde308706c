// The thesis's section 6, number by number, and what is known since.
#include "furrow/depth/thesis.h"

#include <gtest/gtest.h>
#include <cmath>

#include "furrow/geom/angles.h"

namespace furrow::depth {
namespace {

DepthMap flat_map(int width, int height, float value) {
  return {width, height, std::vector<float>(static_cast<std::size_t>(width * height), value)};
}

// By hand: scaled = 0.01 + 9.99 disparity, metres = 5.4 / scaled.
TEST(ThesisDepth, SigmoidDisparityBecomesMetres) {
  EXPECT_NEAR(thesis_metres(0.0), 540.0, 1e-9);
  EXPECT_NEAR(thesis_metres(1.0), 0.54, 1e-12);
  EXPECT_NEAR(thesis_metres(0.1), 5.4 / 1.009, 1e-12);      // 5.3518
  EXPECT_NEAR(thesis_metres(0.03), 5.4 / 0.3097, 1e-12);    // 17.4362
  EXPECT_NEAR(thesis_metres(0.0970), 5.4 / 0.97903, 1e-9);  // 5.5157: L of a flight at 1.31 m, -13.8 deg
  EXPECT_TRUE(std::isnan(thesis_metres(1.01)));
  EXPECT_TRUE(std::isnan(thesis_metres(-0.01)));
  EXPECT_TRUE(std::isnan(thesis_metres(std::nan(""))));
}

TEST(ThesisDepth, TheValueIsTheOneAt512And160) {
  DepthMap map = flat_map(1024, 320, 9.0F);
  map.values[160 * 1024 + 512] = 5.5F;
  EXPECT_NEAR(*thesis_slant_distance_m(map), 5.5, 1e-6);
  // The small networks' 640 x 192: the same place.
  DepthMap small = flat_map(640, 192, 9.0F);
  small.values[96 * 640 + 320] = 5.5F;
  EXPECT_NEAR(*thesis_slant_distance_m(small), 5.5, 1e-6);
  map.values[160 * 1024 + 512] = std::nanf("");
  EXPECT_EQ(thesis_slant_distance_m(map).error().code, "no_depth");
}

// Slant distance 5.5 at -13.8 deg is 1.31 m above the canopy (docs/formulation/altitude.md, section 0).
TEST(ThesisDepth, ADisparityMapGivesTheThesisHeight) {
  const double slant = *thesis_slant_distance_m(thesis_metres(flat_map(1024, 320, 0.0970F)));
  EXPECT_NEAR(slant * std::sin(geom::deg_to_rad(13.8)), 1.3157, 2e-4);
}

TEST(ThesisDepth, AnotherCameraNeedsItsFocalLength) {
  Camera camera;
  camera.width = 1280, camera.height = 720;
  camera.fx = 874.33, camera.fy = 872.39, camera.cx = 639.5, camera.cy = 359.5;
  const DepthMap scaled = for_focal_length(flat_map(4, 4, 2.0F), camera);
  EXPECT_NEAR(static_cast<double>(scaled.at(1, 1)), 2.0 * 874.33 / 1280.0 / 0.58, 1e-5);  // 2.3554
}

TEST(ThesisDepth, ZDepthIsTheRangeAtThePrincipalPointOnly) {
  Camera camera;
  camera.width = 1280, camera.height = 720;
  camera.fx = camera.fy = 800.0, camera.cx = 640.0, camera.cy = 360.0;
  EXPECT_NEAR(*range_m(5.0, camera, 640.0, 360.0), 5.0, 1e-9);
  // (600, 0) / 800 = 0.75: the ray is 1.25 times as long.
  EXPECT_NEAR(*range_m(5.0, camera, 1240.0, 360.0), 6.25, 1e-9);
}

}  // namespace
}  // namespace furrow::depth
