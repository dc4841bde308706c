#include "furrow/sync/align.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/random.h"
#include "telemetry/samples.h"

namespace furrow::sync {
namespace {

using telemetry::Sample;
using telemetry::Track;

double height_at(double t_s) {
  return 10.0 + 6.0 * std::sin(t_s / 23.0) + 2.0 * std::sin(t_s / 7.1);
}
double speed_at(double t_s) {
  return std::abs(3.0 * std::sin(t_s / 11.0));
}
double tenth(double x) {
  return std::round(x * 10.0) / 10.0;
}

Track make(double from_s, double to_s, double step_s) {
  Track track;
  for (double t_s = from_s; t_s <= to_s; t_s += step_s) {
    Sample s;
    s.t_log_ns = base::seconds_to_ns(t_s - from_s);
    s.height_takeoff_m = tenth(height_at(t_s));
    s.speed_mps = tenth(speed_at(t_s));
    track.samples.push_back(s);
  }
  return track;
}

TEST(AlignClip, FindsTheShiftToHundredthsAndKnowsHowWell) {
  base::Random random(5);
  const Track log = make(0.0, 600.0, 0.1);
  const int trials = 150;
  int inside_1 = 0, inside_2 = 0;
  for (int i = 0; i < trials; ++i) {
    const double start_s = random.uniform(10.0, 500.0);
    const auto found = align_clip(make(start_s, start_s + 60.0, 0.04), log);
    ASSERT_TRUE(found.ok()) << found.error().message();
    const double error_s = std::abs(base::ns_to_seconds(found->shift_ns) - start_s);
    EXPECT_LT(error_s, 0.06) << i;
    EXPECT_LT(found->height_rms_m, 0.08);
    inside_1 += error_s < found->sigma_s;
    inside_2 += error_s < 2.0 * found->sigma_s;
  }
  RecordProperty("inside_1", inside_1);
  RecordProperty("inside_2", inside_2);
  // At least as often as claimed; 150 trials have a standard error of 4 %.
  EXPECT_GT(inside_1, trials * 60 / 100);
  EXPECT_GT(inside_2, trials * 90 / 100);
}

TEST(AlignClip, AHoverIsAmbiguous) {
  Track log = make(0.0, 300.0, 0.1), clip = make(0.0, 30.0, 0.1);
  for (auto* track : {&log, &clip})
    for (Sample& s : track->samples) {
      s.height_takeoff_m = 5.0;
      s.speed_mps = 0.0;
    }
  EXPECT_EQ(align_clip(clip, log).error().code, "alignment_ambiguous");
}

TEST(AlignClip, NothingToCompareIsSaid) {
  Track log = make(0.0, 300.0, 0.1);
  EXPECT_EQ(align_clip(Track{}, log).error().code, "alignment_no_data");
  EXPECT_EQ(align_clip(log, Track{}).error().code, "alignment_no_data");
  Track blank = log;
  for (Sample& s : blank.samples) s.height_takeoff_m = s.speed_mps = telemetry::kMissing;
  EXPECT_EQ(align_clip(blank, log).error().code, "alignment_no_data");
}

// A real clip and log of one flight. By hand, height, speed and distance each put the clip's start at 228.9
// s; the log's video flag rises at 228.3 s, 0.6 s too early.
TEST(AlignClip, RealPair) {
  const auto clip_file = furrow_data("telemetry/srt/MICK_folsomlake_DJI_0031-01.srt");
  const auto log_file = furrow_data("telemetry/airdata/sitrec_Dec-22nd-2023-11-56AM-Flight-Airdata.csv");
  FURROW_NEEDS_DATA(clip_file);
  FURROW_NEEDS_DATA(log_file);
  const auto clip = telemetry::read_track(clip_file), log = telemetry::read_track(log_file);
  ASSERT_TRUE(clip.ok() && log.ok());
  const auto found = align_clip(*clip, *log);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_NEAR(base::ns_to_seconds(found->shift_ns), 228.9, 0.1);
  EXPECT_LT(found->height_rms_m, 0.03);
  EXPECT_LT(found->speed_rms_mps, 0.06);
  RecordProperty("shift_s", std::to_string(base::ns_to_seconds(found->shift_ns)));
  RecordProperty("sigma_s", std::to_string(found->sigma_s));
  RecordProperty("margin", std::to_string(found->margin));
}

}  // namespace
}  // namespace furrow::sync
