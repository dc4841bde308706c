#include "furrow/altitude/thesis.h"

#include <gtest/gtest.h>
#include <cmath>

#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

// Worked examples of the thesis, section 5: f 873.35 px, half width 0.60 m, pitch -13.8 deg, canopy 1.7 m.
TEST(Thesis, WorkedExampleOf95Px) {
  const double slant = thesis_slant_distance_m(0.60, 873.35, 95.0).value();
  EXPECT_NEAR(slant, 5.5, 0.05);  // the thesis prints 5.5
  EXPECT_NEAR(slant, 5.515894736842105, 1e-12);
  const double height = thesis_height_above_canopy_m(5.5, geom::deg_to_rad(-13.8)).value();
  EXPECT_NEAR(height, 1.31, 0.005);
  EXPECT_NEAR(height + 1.7, 3.0, 0.05);
}

TEST(Thesis, WorkedExampleOf35Px) {
  EXPECT_NEAR(thesis_slant_distance_m(0.60, 873.35, 35.0).value(), 14.97, 0.005);
  // The thesis goes on with L rounded to 15.
  const double height = thesis_height_above_canopy_m(15.0, geom::deg_to_rad(-13.8)).value();
  EXPECT_NEAR(height, 3.57, 0.01);
  EXPECT_NEAR(height + 1.7, 5.27, 0.01);
}

TEST(Thesis, StraightDownIsTheSlantDistanceItself) {
  EXPECT_DOUBLE_EQ(thesis_height_above_canopy_m(7.0, -geom::kPi / 2.0).value(), 7.0);
}

TEST(Thesis, RefusesWidthsAndPitchesThatMeanNothing) {
  for (const double bad : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    EXPECT_EQ(thesis_slant_distance_m(bad, 873.0, 95.0).error().code, "bad_width");
    EXPECT_EQ(thesis_slant_distance_m(0.6, bad, 95.0).error().code, "bad_width");
    EXPECT_EQ(thesis_slant_distance_m(0.6, 873.0, bad).error().code, "bad_width");
  }
  for (const double bad : {0.0, 0.2, -2.0, std::nan(""), -HUGE_VAL}) {
    EXPECT_EQ(thesis_height_above_canopy_m(5.0, bad).error().code, "bad_pitch");
  }
}

}  // namespace
}  // namespace furrow::altitude
