#include <gtest/gtest.h>

#include <cmath>

#include "furrow/sync/locate.h"
#include "furrow/telemetry/sample_fields.h"

namespace furrow::sync {
namespace {

using telemetry::Sample;
using telemetry::Track;

Track two_rows() {
  Track track;
  track.samples.resize(2);
  Sample &a = track.samples[0], &b = track.samples[1];
  a.t_log_ns = 1'000'000'000;
  b.t_log_ns = 1'100'000'000;
  a.t_utc_ns = 5'000'000'000;
  b.t_utc_ns = 5'100'000'000;
  a.height_takeoff_m = 3.0;
  b.height_takeoff_m = 4.0;
  a.gimbal_heading_deg = 350.0;
  b.gimbal_heading_deg = 20.0;
  a.longitude_deg = 179.9;
  b.longitude_deg = -179.9;
  a.roll_deg = -170.0;
  b.roll_deg = 170.0;
  a.height_vps_m = 2.0;
  b.is_video = true;
  return track;
}

TEST(Interpolate, NumbersGoStraightAndAnglesTheShortWay) {
  const auto s = interpolate(two_rows(), 1'025'000'000);
  ASSERT_TRUE(s.has_value());
  EXPECT_EQ(s->t_log_ns, 1'025'000'000);
  EXPECT_EQ(*s->t_utc_ns, 5'025'000'000);
  EXPECT_NEAR(s->height_takeoff_m, 3.25, 1e-12);
  EXPECT_NEAR(s->gimbal_heading_deg, 357.5, 1e-9);
  EXPECT_NEAR(s->longitude_deg, 179.95, 1e-9);
  EXPECT_NEAR(s->roll_deg, -175.0, 1e-9);
  EXPECT_NEAR(interpolate(two_rows(), 1'080'000'000)->gimbal_heading_deg, 14.0, 1e-9);
  EXPECT_NEAR(interpolate(two_rows(), 1'080'000'000)->longitude_deg, -179.94, 1e-9);
}

TEST(Interpolate, FlagsComeFromTheNearerRow) {
  EXPECT_FALSE(interpolate(two_rows(), 1'049'000'000)->is_video);
  EXPECT_TRUE(interpolate(two_rows(), 1'051'000'000)->is_video);
}

TEST(Interpolate, AnUnknownNeighbourLeavesTheNumberUnknownExceptAtTheRow) {
  EXPECT_TRUE(std::isnan(interpolate(two_rows(), 1'001'000'000)->height_vps_m));
  EXPECT_NEAR(interpolate(two_rows(), 1'000'000'000)->height_vps_m, 2.0, 1e-12);
  EXPECT_TRUE(std::isnan(interpolate(two_rows(), 1'100'000'000)->height_vps_m));
}

TEST(Interpolate, NothingOutsideTheLog) {
  EXPECT_FALSE(interpolate(two_rows(), 999'999'999).has_value());
  EXPECT_FALSE(interpolate(two_rows(), 1'100'000'001).has_value());
  EXPECT_TRUE(interpolate(two_rows(), 1'100'000'000).has_value());
  EXPECT_FALSE(interpolate(Track{}, 0).has_value());
}

// A field that is added to Sample but to no list would silently not be interpolated: all its doubles are in
// the three lists.
TEST(Interpolate, EveryNumberOfASampleIsInOneList) {
  constexpr std::size_t kFields = telemetry::kLinearFields.size() + telemetry::kHeadingFields.size() +
                                  telemetry::kSignedAngleFields.size();
  const Sample blank;
  const auto* first = &blank.latitude_deg;
  const auto* last = &blank.gimbal_roll_deg;
  EXPECT_EQ(static_cast<std::size_t>(last - first) + 1, kFields);
}

}  // namespace
}  // namespace furrow::sync
