#include "furrow/base/whole.h"

#include <gtest/gtest.h>

#include <limits>

namespace furrow::base {
namespace {

TEST(Whole, RoundsInsideItsBounds) {
  EXPECT_EQ(ceil_between(2.1, 0, 9), 3);
  EXPECT_EQ(floor_between(2.9, 0, 9), 2);
  EXPECT_EQ(ceil_between(-2.9, -9, 9), -2);
  EXPECT_EQ(floor_between(-2.1, -9, 9), -3);
  EXPECT_EQ(ceil_between(4.0, 0, 9), 4);
  EXPECT_EQ(floor_between(4.0, 0, 9), 4);
  EXPECT_EQ(ceil_between(-0.5, 0, 9), 0);
  EXPECT_EQ(floor_between(-0.5, -1, 9), -1);
  EXPECT_EQ(ceil_between(9.5, 0, 9), 9);
  EXPECT_EQ(floor_between(9.5, 0, 9), 9);
}

TEST(Whole, NumbersThatNoIntHoldsStayInTheBounds) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const double far : {3e9, 1e300, kInfinite}) {
    EXPECT_EQ(ceil_between(far, -5, 7), 7) << far;
    EXPECT_EQ(floor_between(far, -5, 7), 7) << far;
    EXPECT_EQ(ceil_between(-far, -5, 7), -5) << far;
    EXPECT_EQ(floor_between(-far, -5, 7), -5) << far;
  }
  EXPECT_EQ(ceil_between(kNaN, -5, 7), -5);
  EXPECT_EQ(floor_between(kNaN, -5, 7), -5);
}

}  // namespace
}  // namespace furrow::base
