#include "furrow/sync/locate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace furrow::sync {
namespace {

using base::Nanoseconds;
using telemetry::Shot;
using telemetry::Track;

constexpr Nanoseconds kSecond = base::kNanosecondsPerSecond;
constexpr Nanoseconds kUtcStart = 1'700'000'000 * kSecond;
/// Camera clock against the log's: a zone of two hours and a clock that is wrong by 34.7 s.
constexpr double kCameraLessLog_s = 1'700'007'234.7;

/// A log of 10 rows a second whose height equals its time, with photo marks at `marks_s`.
Track make_track(const std::vector<double>& marks_s, double length_s = 300.0) {
  Track track;
  track.source = "flight.csv";
  for (int i = 0; i <= static_cast<int>(length_s * 10); ++i) {
    telemetry::Sample s;
    s.t_log_ns = i * (kSecond / 10);
    s.t_utc_ns = kUtcStart + s.t_log_ns;
    s.height_takeoff_m = 0.1 * i;
    s.gimbal_pitch_deg = -12.4;
    for (const double mark_s : marks_s)
      s.is_photo = s.is_photo || i == static_cast<int>(std::lround(mark_s * 10));
    track.samples.push_back(s);
  }
  return track;
}

/// Shots taken at these log times, with EXIF's whole seconds of the camera's own clock.
std::vector<Shot> make_shots(const std::vector<double>& t_log_s, bool local) {
  std::vector<Shot> shots;
  for (std::size_t i = 0; i < t_log_s.size(); ++i) {
    Shot shot;
    shot.shot_id = "DJI_" + std::to_string(i + 1);
    if (local)
      shot.t_camera_local_ns = static_cast<Nanoseconds>(std::floor(t_log_s[i] + kCameraLessLog_s)) * kSecond;
    shots.push_back(shot);
  }
  return shots;
}

TEST(LocateShots, ByTheirOwnUtc) {
  auto shots = make_shots({10.05, 20.0, 400.0}, false);
  const double at_s[] = {10.05, 20.0, 400.0};
  for (std::size_t i = 0; i < shots.size(); ++i)
    shots[i].metadata.t_utc_ns = kUtcStart + base::seconds_to_ns(at_s[i]);
  const auto located = locate_shots(shots, make_track({}));
  ASSERT_TRUE(located.ok()) << located.error().message();
  EXPECT_EQ(located->method, "picture time");
  EXPECT_TRUE(located->poses[0].located);
  EXPECT_NEAR(located->poses[0].state.height_takeoff_m, 10.05, 1e-6);
  EXPECT_NEAR(located->poses[1].state.height_takeoff_m, 20.0, 1e-6);
  EXPECT_FALSE(located->poses[2].located);
  EXPECT_NE(located->poses[2].reason.find("outside the log"), std::string::npos);
}

TEST(LocateShots, ByAsManyMarks) {
  const auto located = locate_shots(make_shots({5, 9, 30}, false), make_track({5, 9, 30}));
  ASSERT_TRUE(located.ok());
  EXPECT_EQ(located->method, "isPhoto marks");
  EXPECT_TRUE(located->warnings.empty());
  EXPECT_NEAR(located->poses[2].state.height_takeoff_m, 30.0, 1e-9);
  // The mark came somewhere in the 0.1 s since the row before.
  EXPECT_NEAR(located->poses[2].t_sigma_s, 0.1 / std::sqrt(12.0), 1e-12);
}

TEST(LocateShots, AsManyMarksButOtherTimesWarn) {
  const auto located = locate_shots(make_shots({5, 14, 30}, true), make_track({5, 9, 30}));
  ASSERT_TRUE(located.ok());
  ASSERT_EQ(located->warnings.size(), 1u);
  EXPECT_NE(located->warnings[0].find("DJI_2"), std::string::npos);
  const auto fits = locate_shots(make_shots({5, 9, 30}, true), make_track({5, 9, 30}));
  EXPECT_TRUE(fits->warnings.empty());
}

TEST(LocateShots, ShotsOutOfOrderAreOrderedByTime) {
  const auto located = locate_shots(make_shots({30, 5, 9}, true), make_track({5, 9, 30}));
  ASSERT_TRUE(located.ok());
  EXPECT_EQ(located->poses[0].shot_id, "DJI_1");
  EXPECT_NEAR(located->poses[0].state.height_takeoff_m, 30.0, 1e-9);
  EXPECT_NEAR(located->poses[1].state.height_takeoff_m, 5.0, 1e-9);
  EXPECT_EQ(located->warnings.size(), 1u);
}

TEST(LocateShots, ASubsetOfMarksByTheirPattern) {
  const std::vector<double> marks = {5, 9.3, 30, 41.2, 77, 80, 120};
  const auto located = locate_shots(make_shots({9.3, 41.2, 77, 120}, true), make_track(marks));
  ASSERT_TRUE(located.ok()) << located.error().message();
  EXPECT_EQ(located->method, "isPhoto marks by time pattern");
  ASSERT_EQ(located->warnings.size(), 1u);
  EXPECT_NE(located->warnings[0].find("4 shots"), std::string::npos);
  const double truth[] = {9.3, 41.2, 77, 120};
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(located->poses[i].state.height_takeoff_m, truth[i], 1e-6);
}

TEST(LocateShots, AnUnreadablePictureDoesNotSpoilThePattern) {
  auto shots = make_shots({9.3, 41.2, 50, 77, 120}, true);
  shots[2].t_camera_local_ns.reset();
  const auto located = locate_shots(shots, make_track({5, 9.3, 30, 41.2, 77, 80, 120}));
  ASSERT_TRUE(located.ok()) << located.error().message();
  EXPECT_FALSE(located->poses[2].located);
  EXPECT_NEAR(located->poses[3].state.height_takeoff_m, 77.0, 1e-6);
}

// A picture every 2 s: three of them fit anywhere, so nothing may be claimed.
TEST(LocateShots, ARegularPatternIsAmbiguous) {
  const auto located = locate_shots(make_shots({10, 12, 14}, true), make_track({8, 10, 12, 14, 16}));
  ASSERT_FALSE(located.ok());
  EXPECT_EQ(located.error().code, "shots_not_locatable");
  EXPECT_NE(located.error().found.find("3 shots"), std::string::npos);
  EXPECT_NE(located.error().found.find("5 photo marks"), std::string::npos);
}

TEST(LocateShots, OwnGimbalPitchWhenTheLogDoesNotHelp) {
  auto shots = make_shots({10, 12}, false);
  shots[0].metadata.gimbal_pitch_deg = -60.2;
  const auto located = locate_shots(shots, make_track({}));
  ASSERT_TRUE(located.ok());
  EXPECT_EQ(located->method, "picture metadata only");
  EXPECT_TRUE(located->poses[0].located);
  EXPECT_FALSE(located->poses[1].located);
  EXPECT_EQ(located->warnings.size(), 1u);
}

TEST(LocateShots, WithoutALogTheMetadataIsAll) {
  auto shots = make_shots({10, 12}, false);
  shots[0].metadata.gimbal_pitch_deg = -60.2;
  const auto located = locate_shots(shots, std::nullopt);
  ASSERT_TRUE(located.ok());
  EXPECT_EQ(located->poses.size(), 2u);
  EXPECT_TRUE(located->poses[0].located);
  EXPECT_NEAR(located->poses[0].state.gimbal_pitch_deg, -60.2, 1e-12);
  EXPECT_FALSE(located->poses[1].located);
  EXPECT_FALSE(located->poses[1].reason.empty());
}

TEST(LocateShots, PictureFillsWhatTheLogLacksAndDisagreementIsSaid) {
  auto shots = make_shots({5}, false);
  shots[0].metadata.roll_deg = 1.5;
  shots[0].metadata.gimbal_pitch_deg = -60.0;
  const auto located = locate_shots(shots, make_track({5}));
  ASSERT_TRUE(located.ok());
  EXPECT_NEAR(located->poses[0].state.roll_deg, 1.5, 1e-12);
  EXPECT_NEAR(located->poses[0].state.gimbal_pitch_deg, -12.4, 1e-12) << "the log has the word";
  ASSERT_EQ(located->warnings.size(), 1u);
  EXPECT_NE(located->warnings[0].find("gimbal pitch"), std::string::npos);
}

TEST(LocateShots, LocalTimesOfTheLogWhenItHasNoMarks) {
  Track track = make_track({});
  for (auto& s : track.samples) s.t_local_ns = s.t_log_ns + 1'700'007'200 * kSecond;
  auto shots = make_shots({}, true);
  shots.resize(2);
  shots[0].t_camera_local_ns = 1'700'007'210 * kSecond;
  shots[1].t_camera_local_ns = 1'700'007'220 * kSecond;
  const auto located = locate_shots(shots, track);
  ASSERT_TRUE(located.ok());
  EXPECT_EQ(located->method, "picture local time");
  EXPECT_NEAR(located->poses[1].state.height_takeoff_m, 20.0, 1e-6);
}

TEST(LocateShots, NothingInNothingOut) {
  EXPECT_TRUE(locate_shots({}, std::nullopt).ok());
  EXPECT_FALSE(locate_shots({}, make_track({5})).ok());
  EXPECT_FALSE(locate_shots(make_shots({5}, false), Track{}).ok());
}

}  // namespace
}  // namespace furrow::sync
