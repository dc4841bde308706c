#include "furrow/follow/follower.h"

#include <gtest/gtest.h>

#include <cmath>

namespace furrow::follow {
namespace {

constexpr double kSpacing = 3.0, kPxPerM = 60.0;

/// The picture of a camera `left_m` to the left of the first row, from straight above.
Sighting seen_from(double left_m, double t_s) {
  Sighting s;
  s.t_video_ns = base::seconds_to_ns(t_s);
  s.status = "ok";
  // Row 0 is the nearest to the middle; the camera is so much to its left.
  const double from_nearest = left_m - kSpacing * std::round(left_m / kSpacing);
  s.place = {319.5 + kPxPerM * from_nearest, kPxPerM * kSpacing, 640, 360};
  s.deviation_px = kPxPerM * from_nearest;
  s.offset = {from_nearest, 0.05, 10};
  s.spacing = kSpacing;
  s.heading_rad = {0.02, 0.01, 10};
  return s;
}

Sighting nothing(double t_s) {
  Sighting s;
  s.t_video_ns = base::seconds_to_ns(t_s);
  s.status = "no_rows";
  s.reason = "no pattern of rows";
  return s;
}

TEST(Follower, DriftPastTheMiddleKeepsTheRow) {
  Following f;
  for (int i = 0; i <= 80; ++i) {
    const double left = 0.05 * i;  // 0 to 4 m: one row and a third
    f = follow_step(f, seen_from(left, 0.1 * i), {});
    ASSERT_EQ(f.row, 0) << i;
    ASSERT_NEAR(f.measured.value, left, 1e-9) << i;
    EXPECT_EQ(f.event, i == 0 ? RowEvent::started : RowEvent::none) << i;
  }
  EXPECT_EQ(f.nearest_row, -1);  // the camera flew to the left, over the left neighbour
  EXPECT_NEAR(f.offset->value, 4.0, 0.1);
}

TEST(Follower, TheNearestRowIsTakenAndSaidWhenAskedFor) {
  FollowerOptions options;
  options.hold = Hold::nearest;
  Following f;
  int changes = 0;
  for (int i = 0; i <= 80; ++i) {
    f = follow_step(f, seen_from(0.05 * i, 0.1 * i), options);
    changes += f.event == RowEvent::changed;
  }
  EXPECT_EQ(changes, 1);
  EXPECT_EQ(f.row, -1);
  EXPECT_NEAR(f.offset->value, 1.0, 0.1);
}

TEST(Follower, NothingSeenIsPredictedThenHeldWithItsReason) {
  Following f;
  for (int i = 0; i < 30; ++i) f = follow_step(f, seen_from(0.2, i / 30.0), {});
  const double sigma = f.offset->sigma;
  f = follow_step(f, nothing(1.2), {});
  ASSERT_TRUE(f.offset.has_value());
  EXPECT_GT(f.offset->sigma, sigma);
  EXPECT_FALSE(f.is_hold);
  f = follow_step(f, nothing(3.0), {});
  EXPECT_TRUE(f.is_hold);
  EXPECT_FALSE(f.offset.has_value());
  EXPECT_EQ(f.hold_reason, "no pattern of rows");
  EXPECT_EQ(f.guidance.velocity.right_mps, 0.0);
}

TEST(Follower, ARowIsFoundAgainWhereItMustBe) {
  Following f;
  for (int i = 0; i < 30; ++i) f = follow_step(f, seen_from(1.2, i / 30.0), {});
  // Too many pictures without rows for their places to tell; the filter still knows.
  for (int i = 30; i < 36; ++i) f = follow_step(f, nothing(i / 30.0), {});
  f = follow_step(f, seen_from(1.25, 36 / 30.0), {});
  EXPECT_EQ(f.row, 0);
  EXPECT_EQ(f.event, RowEvent::none);
  EXPECT_NEAR(f.measured.value, 1.25, 1e-9);
}

TEST(Follower, ALostRowIsSaidAndCountedAnew) {
  Following f;
  for (int i = 0; i < 10; ++i) f = follow_step(f, seen_from(0.2, 0.1 * i), {});
  for (int i = 10; i < 80; ++i) f = follow_step(f, nothing(0.1 * i), {});
  EXPECT_EQ(f.count, 0);
  f = follow_step(f, seen_from(0.2, 8.0), {});
  EXPECT_EQ(f.event, RowEvent::started);
  EXPECT_EQ(f.count, 1);
  EXPECT_EQ(f.row, 0);
}

TEST(Follower, OneStrangePictureDoesNotLoseTheRow) {
  Following f;
  for (int i = 0; i < 20; ++i) f = follow_step(f, seen_from(0.2, 0.1 * i), {});
  Sighting strange = seen_from(0.2, 2.0);
  strange.place.spacing_px *= 2.0;
  strange.offset.value += 0.5 * kSpacing;
  f = follow_step(f, strange, {});
  EXPECT_EQ(f.event, RowEvent::none);
  f = follow_step(f, seen_from(0.2, 2.1), {});
  EXPECT_EQ(f.row, 0);
  EXPECT_EQ(f.event, RowEvent::none);
  EXPECT_EQ(f.count, 0);
}

TEST(Follower, ARowAloneIsFollowed) {
  Following f;
  for (int i = 0; i < 20; ++i) {
    Sighting s = seen_from(0.2 + 0.01 * i, 0.1 * i);
    s.place.spacing_px = s.spacing = std::numeric_limits<double>::quiet_NaN();
    f = follow_step(f, s, {});
  }
  EXPECT_EQ(f.row, 0);
  EXPECT_EQ(f.count, 0);
  ASSERT_TRUE(f.offset.has_value());
  EXPECT_NEAR(f.offset->value, 0.39, 0.03);
  EXPECT_FALSE(f.guidance.is_hold);
}

// Blown two rows to the left: the spacing's sigma counts twice, and what it shares with the offset.
TEST(Follower, ARowFartherAwayCarriesTheSpacingsSigma) {
  Following f;
  for (int i = 0; i <= 60; ++i) {
    Sighting s = seen_from(0.1 * i, 0.1 * i);
    s.spacing_sigma = 0.03, s.offset_spacing_covariance = 0.0005;
    f = follow_step(f, s, {});
  }
  EXPECT_EQ(f.nearest_row, -2);
  EXPECT_NEAR(f.measured.value, 6.0, 1e-9);
  EXPECT_NEAR(f.measured.sigma, std::sqrt(0.05 * 0.05 + 2.0 * 2.0 * 0.0005 + 4.0 * 0.03 * 0.03), 1e-12);
}

TEST(Follower, TheThesisRuleHoldsAtOnceAndNeedsNoMetres) {
  FollowerOptions options;
  options.rule = Rule::thesis;
  options.half_width = HalfWidth::given;
  options.half_width_px = 40.0;
  Sighting s = seen_from(0.0, 0.0);
  s.deviation_px = 5.59998;
  Following f = follow_step({}, s, options);
  EXPECT_NEAR(*f.deviation_cm, 8.40, 5e-4);  // thesis, section 4
  EXPECT_NEAR(f.guidance.velocity.right_mps, 0.5 * 0.084, 1e-4);
  f = follow_step(f, nothing(0.1), options);
  EXPECT_TRUE(f.is_hold);
  EXPECT_FALSE(f.steer_cm.has_value());
}

TEST(Follower, TheThesisHalfWidthGrowsWithThePicture) {
  Sighting s = seen_from(0.0, 0.0);
  s.deviation_px = 30.0;  // at 640 px of width 30 px are 60 cm
  EXPECT_NEAR(*follow_step({}, s, {}).deviation_cm, 60.0, 1e-12);
}

TEST(Follower, MeasuredHalfWidthOrNoCentimetres) {
  FollowerOptions options;
  options.half_width = HalfWidth::measured;
  Sighting s = seen_from(0.1, 0.0);
  EXPECT_FALSE(follow_step({}, s, options).deviation_cm.has_value());
  s.half_width_px = Estimate{36.0, 1.0, 10};
  EXPECT_NEAR(*follow_step({}, s, options).deviation_cm, 10.0, 1e-9);
}

TEST(Follower, PixelsAreFilteredButDoNotSteer) {
  FollowerOptions options;
  options.is_metric = false;
  Following f;
  for (int i = 0; i < 20; ++i) {
    Sighting s = seen_from(0.2, 0.1 * i);
    s.offset = {*s.deviation_px, 2.0, 1};
    s.spacing = s.place.spacing_px;
    f = follow_step(f, s, options);
  }
  ASSERT_TRUE(f.offset.has_value());
  EXPECT_NEAR(f.offset->value, 12.0, 0.5);
  EXPECT_TRUE(f.guidance.is_hold);
  EXPECT_FALSE(f.is_hold);
}

}  // namespace
}  // namespace furrow::follow
