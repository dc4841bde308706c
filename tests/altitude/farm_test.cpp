#include "altitude/farm.h"

#include <gtest/gtest.h>
#include <cmath>

namespace furrow::altitude {
namespace {

// By hand from eq. 8.8: a vine's row, and one of young corn that is narrower than a leaf's reach.
TEST(Farm, OutlinesAreRaggedByALeafWhateverTheRowsWidth) {
  const Estimate vine = outline_rise({}, {0.6, 0.3, 0.03});
  EXPECT_NEAR(vine.value, 0.6 * 0.12 + 0.2146 * 0.3, 1e-4);
  EXPECT_NEAR(vine.sigma, std::hypot(0.4 * 0.12 + 3.5 * 0.03, 0.3 / (2.0 * std::sqrt(12.0))), 1e-4);
  EXPECT_NEAR(outline_rise({}, {0.3, 0.3, 0.03}).value, vine.value, 1e-12);

  const Estimate corn = outline_rise({}, {0.1, 0.05, 0.005});
  EXPECT_NEAR(corn.value, 0.6 * 0.1 + 0.2146 * 0.05, 1e-4);
  EXPECT_NEAR(corn.sigma, std::hypot(0.4 * 0.1 + 3.5 * 0.005, 0.05 / (2.0 * std::sqrt(12.0))), 1e-4);
}

TEST(Farm, NoOutlineIsRaggedByMoreThanALeafAndAHalf) {
  EXPECT_NEAR(outline_rise({}, {0.6, 0.0, 0.2}).sigma, 1.5 * 0.12, 1e-12);
  EXPECT_NEAR(outline_rise({}, {0.1, 0.0, 0.2}).sigma, 1.5 * 0.1, 1e-12);
}

// By hand from eq. 8.9 and 8.10.
TEST(Farm, OverASmoothCanopyNothingRagged) {
  const double flat = 0.7 * 0.12 * (1.0 - 0.12 / 0.42);
  const Estimate smooth = outline_rise({}, {0.6, 0.12, 0.0, 0.0});
  EXPECT_NEAR(smooth.value, flat, 1e-9);
  EXPECT_NEAR(smooth.sigma, std::hypot(0.4 * 0.12, 0.12 / (2.0 * std::sqrt(12.0)), 0.35 * 0.12), 1e-9);
  EXPECT_EQ(outline_rise({}, {0.6, 0.9, 0.0, 0.0}).value, 0.0);  // a ridge is its own top

  const double ragged = outline_rise({}, {0.6, 0.12, 0.0}).value;
  EXPECT_NEAR(outline_rise({}, {0.6, 0.12, 0.0, 0.015}).value, 0.5 * (flat + ragged), 1e-9);
  EXPECT_NEAR(outline_rise({}, {0.6, 0.12, 0.0, 0.05}).value, ragged, 1e-9);

  FieldKnowledge field;
  field.rounding_m = {0.12, 0.01, 1};
  EXPECT_EQ(outline_rise(field, {0.6, 0.12, 0.0, 0.0}).value, 0.0);  // told to be round
}

TEST(Farm, AToldRiseIsTakenAsTold) {
  FieldKnowledge field;
  field.outline_rise_m = {0.3, 0.035, 1};
  const Estimate told = outline_rise(field, {0.6, 0.3, 0.03});
  EXPECT_EQ(told.value, 0.3);
  EXPECT_EQ(told.sigma, 0.035);
}

}  // namespace
}  // namespace furrow::altitude
