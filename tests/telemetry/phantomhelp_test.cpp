#include <gtest/gtest.h>

#include <cmath>

#include "furrow/telemetry/formats.h"

namespace furrow::telemetry {
namespace {

// Column names verbatim from a TXTlogToCSV export, cut to those that are read and some that must not be.
constexpr const char* kHeader =
    "sep=,\r\n"
    "CUSTOM.date [local],CUSTOM.updateTime [local],OSD.flyTime,OSD.flyTime "
    "[s],OSD.latitude,OSD.longitude,OSD.height [ft],"
    "OSD.heightMax [ft],OSD.vpsHeight [ft],OSD.altitude [ft],OSD.hSpeed "
    "[MPH],OSD.pitch,OSD.roll,OSD.yaw,OSD.yaw [360],"
    "OSD.isSwaveWork,GIMBAL.pitch,GIMBAL.roll,GIMBAL.yaw,GIMBAL.yaw [360],CAMERA.isPhoto,CAMERA.isVideo\r\n";

std::string row(const std::string& time, double fly_s, double height_ft, double vps_ft, bool swave,
                bool photo) {
  return "5/31/2026," + time + ",0m 1s," + std::to_string(fly_s) + ",48.1,11.2," + std::to_string(height_ft) +
         ",100.0," + std::to_string(vps_ft) + ",1500.0,2.2,-3.1,0.4,-170.5,189.5," +
         (swave ? "True" : "False") + ",-12.4,0.0,-171.0,189.0," + (photo ? "True" : "False") + ",False\r\n";
}

TEST(PhantomHelp, ReadsUnitsTimesAndFlags) {
  const std::string text = kHeader + row("12:59:58.100 PM", 0.0, 0.0, 0.3, true, false) +
                           row("12:59:58.200 PM", 0.1, 10.0, 9.0, true, true) +
                           row("12:59:58.300 PM", 0.2, 20.0, 9.0, false, true) +
                           row("12:59:58.400 PM", 0.3, 20.0, 83.7, true, false);
  const auto track = parse_track(text, "phantom.csv");
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_EQ(track->format, "phantomhelp");
  ASSERT_EQ(track->samples.size(), 4u);
  const Sample& s = track->samples[1];
  EXPECT_EQ(s.t_log_ns, 100'000'000);
  EXPECT_EQ(base::format_utc(*s.t_local_ns), "2026-05-31T12:59:58.200Z");
  EXPECT_FALSE(s.t_utc_ns.has_value());
  EXPECT_NEAR(s.height_takeoff_m, 3.048, 1e-12);
  EXPECT_NEAR(s.height_vps_m, 9.0 * 0.3048, 1e-12);
  EXPECT_NEAR(s.speed_mps, 2.2 * 0.44704, 1e-12);
  EXPECT_NEAR(s.yaw_deg, 189.5, 1e-9);
  EXPECT_NEAR(s.gimbal_pitch_deg, -12.4, 1e-12);
  EXPECT_NEAR(s.gimbal_heading_deg, 189.0, 1e-9);
  EXPECT_TRUE(s.is_photo);
  EXPECT_FALSE(track->samples[2].is_photo);
  EXPECT_TRUE(std::isnan(track->samples[2].height_vps_m)) << "isSwaveWork is False";
  EXPECT_TRUE(std::isnan(track->samples[3].height_vps_m)) << "83.7 ft is the byte's 25.5 m ceiling";
  EXPECT_TRUE(std::isnan(s.height_ellipsoid_m)) << "OSD.altitude is pressure altitude";
}

TEST(PhantomHelp, MidnightAndNoon) {
  const auto at = [](const std::string& time) {
    const auto track = parse_track(kHeader + row(time, 0.0, 0, 0, true, false), "x.csv");
    return base::format_utc(*track->samples.at(0).t_local_ns).substr(11, 12);
  };
  EXPECT_EQ(at("12:00:01.000 AM"), "00:00:01.000");
  EXPECT_EQ(at("12:00:01.000 PM"), "12:00:01.000");
  EXPECT_EQ(at("1:02:03.456 PM"), "13:02:03.456");
  EXPECT_EQ(at("13:02:03.456"), "13:02:03.456");
}

TEST(PhantomHelp, SpreadsheetTimesLeaveTheFlightTime) {
  const auto track = parse_track(
      kHeader + row("29:12.9", 0.0, 3, 3, true, false) + row("29:13.0", 0.1, 3, 3, true, false), "x.csv");
  ASSERT_TRUE(track.ok());
  EXPECT_EQ(track->samples.size(), 2u);
  EXPECT_FALSE(track->samples[0].t_local_ns.has_value());
  EXPECT_FALSE(track->warnings.empty());
}

TEST(PhantomHelp, DjiLogParserHasUtcAndMetres) {
  const std::string text =
      "CUSTOM.dateTime,OSD.flyTime,OSD.latitude,OSD.longitude,OSD.height,OSD.vpsHeight,OSD.hSpeed,OSD.yaw,"
      "GIMBAL.pitch\n"
      "2026-05-31T10:00:00.250Z,10.0,48.1,11.2,4.0,3.1,1.0,-90,-13.8\n"
      "2026-05-31T10:00:00.350Z,10.1,48.1,11.2,4.1,3.2,1.0,-90,-13.8\n";
  const auto track = parse_track(text, "x.csv");
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_NEAR(track->samples[0].height_takeoff_m, 4.0, 1e-12);
  EXPECT_NEAR(track->samples[0].yaw_deg, 270.0, 1e-12);
  EXPECT_EQ(base::format_utc(*track->samples[1].t_utc_ns), "2026-05-31T10:00:00.350Z");
}

TEST(PhantomHelp, MissingColumnsAreNamed) {
  const auto track = parse_track("OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.yaw\n0,1,2,3\n", "x.csv");
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, "telemetry_column_missing");
  EXPECT_NE(track.error().found.find("OSD.height"), std::string::npos);
}

}  // namespace
}  // namespace furrow::telemetry
