#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "furrow/telemetry/formats.h"
#include "samples.h"

namespace furrow::telemetry {
namespace {

/// One cue with verbatim text from 1 s to 2 s.
Result<Track> one_cue(const std::string& body) {
  return parse_track("1\n00:00:01,000 --> 00:00:02,000\n" + body + "\n\n", "clip.SRT");
}

struct Dialect {
  const char* name;
  const char* body;
  double latitude_deg, longitude_deg, height_m;
  const char* local;  ///< "" when the cue has no date
};

// First cues verbatim from real files (docs/telemetry.md names the aircraft).
const Dialect kDialects[] = {
    {"A",
     "HOME(149.0251,-20.2532) 2017.08.05 14:11:51\nGPS(149.0251,-20.2533,16) BAROMETER:1.9\nISO:100 "
     "Shutter:60 EV: Fnum:2.2",
     -20.2533, 149.0251, 1.9, "2017-08-05T14:11:51.000Z"},
    {"A'",
     "HOME(149.0251,-20.2532) 2017.8.5 14:11:51\nGPS(149.0251,-20.2533,16) Hb:1.9 Hs:1.9\nISO:100 TV:60 EV: "
     "0 IR:F2.8",
     -20.2533, 149.0251, 1.9, "2017-08-05T14:11:51.000Z"},
    {"B",
     "F/3.2, SS 160, ISO 100, EV 0, GPS (8.2090, 47.4692, 18), D 49.21m, H 45.60m, H.S 0.00m/s, V.S 0.00m/s ",
     47.4692, 8.2090, 45.6, ""},
    {"B'",
     "F/2.8, SS 1950.57, ISO 100, EV 0, DZOOM 1.000, GPS (-121.1689, 38.7225, 21), D 118.43m, H -1.50m, H.S "
     "0.00m/s, V.S -0.00m/s ",
     38.7225, -121.1689, -1.5, ""},
    {"B\"",
     "F/5.6, SS 400, ISO 100, EV 0, GPS (-58.851745, -34.237922, 15), HOME (-58.847509, -34.232707, "
     "-57.98m), D 698.70m, H 85.80m, "
     "H.S 0.00m/s, V.S 0.00m/s, F.PRY (2.7\xC2\xB0, -7.0\xC2\xB0, 110.1\xC2\xB0), G.PRY (-24.4\xC2\xB0, "
     "0.0\xC2\xB0, 110.4\xC2\xB0)",
     -34.237922, -58.851745, 85.8, ""},
    {"C", "2022.06.21 16:06:17\nGPS(36.6146,-6.1120,0.0M) BAROMETER:0.3M", 36.6146, -6.1120, 0.3,
     "2022-06-21T16:06:17.000Z"},
    {"C'", "GPS(39.906217,116.391305,69.800) BAROMETER(91.2) HOME(39.906206,116.391400)", 39.906217,
     116.391305, 91.2, ""},
    {"D'",
     "<font size=\"36\">FrameCnt : 1, DiffTime : 39ms\n2018-02-19 08:04:51,265,847\n[iso : 100] [shutter : "
     "1/240.0] [fnum : 280] [ev : 0] "
     "[ct : 5627] [latitude : 31.452012] [longtitude : 74.398751] [altitude: 213.983002] </font>",
     31.452012, 74.398751, kMissing, "2018-02-19T08:04:51.266Z"},
    {"E",
     "<font size=\"28\">SrtCnt : 1, DiffTime : 33ms\n2022-08-07 13:40:40,774,808\n[fnum : 280] [focal_len : "
     "240] [dzoom_ratio: 10000, "
     "delta:0],[latitude: 41.424724] [longitude: 2.234156] [altitude: 117.000000] </font>",
     41.424724, 2.234156, kMissing, "2022-08-07T13:40:40.775Z"},
    {"F",
     "<font size=\"28\">FrameCnt: 1, DiffTime: 20ms\n2021-12-25 12:27:52.373\n[iso: 220] [shutter: 1/8000.0] "
     "[fnum: 3.2] [ev: 0] [ct: 5115] "
     "[color_md : default] [focal_len: 24.00] [latitude: 3.41531] [longitude: -3.37440] [rel_alt: -2.400 "
     "abs_alt: 0.401] </font>",
     3.41531, -3.37440, -2.4, "2021-12-25T12:27:52.373Z"},
};

TEST(DjiSrt, EveryDialectGivesItsPlaceHeightAndTime) {
  for (const Dialect& d : kDialects) {
    const auto track = one_cue(d.body);
    ASSERT_TRUE(track.ok()) << d.name << ": " << track.error().message();
    ASSERT_EQ(track->samples.size(), 1u) << d.name;
    EXPECT_EQ(track->variant, d.name);
    const Sample& s = track->samples[0];
    EXPECT_EQ(s.t_log_ns, base::kNanosecondsPerSecond) << d.name;
    EXPECT_NEAR(s.latitude_deg, d.latitude_deg, 1e-9) << d.name;
    EXPECT_NEAR(s.longitude_deg, d.longitude_deg, 1e-9) << d.name;
    if (std::isnan(d.height_m)) {
      EXPECT_TRUE(std::isnan(s.height_takeoff_m)) << d.name;
    } else {
      EXPECT_NEAR(s.height_takeoff_m, d.height_m, 1e-9) << d.name;
    }
    EXPECT_EQ(s.t_local_ns ? base::format_utc(*s.t_local_ns) : "", d.local) << d.name;
    EXPECT_TRUE(std::isnan(s.height_ellipsoid_m) && std::isnan(s.height_geoid_m)) << d.name;
  }
}

TEST(DjiSrt, P4RtkGivesAircraftAndGimbalAngles) {
  const auto track = one_cue(kDialects[4].body);
  ASSERT_TRUE(track.ok());
  const Sample& s = track->samples[0];
  EXPECT_NEAR(s.pitch_deg, 2.7, 1e-9);
  EXPECT_NEAR(s.roll_deg, -7.0, 1e-9);
  EXPECT_NEAR(s.yaw_deg, 110.1, 1e-9);
  EXPECT_NEAR(s.gimbal_pitch_deg, -24.4, 1e-9);
  EXPECT_NEAR(s.gimbal_heading_deg, 110.4, 1e-9);
  EXPECT_NEAR(s.speed_mps, 0.0, 1e-12);
}

TEST(DjiSrt, DegreeSignsInLatin1AndUnknownSpeedDoNotMatter) {
  const auto track = one_cue(
      "F/5.6, SS 400, ISO 100, EV 0, GPS (-58.851745, -34.237922, 15), D 698.70m, H 85.80m, H.S n/a, V.S "
      "n/a, G.PRY (-24.4\xB0, 0.0\xB0, 110.4\xB0)");
  ASSERT_TRUE(track.ok());
  EXPECT_NEAR(track->samples[0].gimbal_pitch_deg, -24.4, 1e-9);
  EXPECT_TRUE(std::isnan(track->samples[0].speed_mps));
}

// G' has a blank line and a lone number inside each cue, verbatim.
TEST(DjiSrt, CuesAreCutAtTimeCodesNotAtBlankLines) {
  const std::string body =
      "FrameCnt: 1, DiffTime: 33ms\n2024-01-02 03:04:05.678\n[drone_speedx: 0.0 drone_speedy: 0.0 "
      "drone_speedz: 0.0]\n"
      "[drone_yaw: 1.9 drone_pitch: 0.0 drone_roll: -1.0]\n[gb_yaw: -3.6 gb_pitch: -7.5 gb_roll: 0.0]\n\n0\n"
      "[ae_meter_md : 0] [dzoom_ratio: 10000, delta:0] [latitude: 45.1] [longitude: 7.2] [rel_alt: 20.160 "
      "abs_alt: 169.523]\n\n";
  const auto track = parse_track(
      "1\r\n00:00:00,000 --> 00:00:00,033\r\n" + body + "2\n00:00:00,033 --> 00:00:00,066\n" + body, "x");
  ASSERT_TRUE(track.ok()) << track.error().message();
  ASSERT_EQ(track->samples.size(), 2u);
  EXPECT_EQ(track->variant, "G'");
  for (const Sample& s : track->samples) {
    EXPECT_NEAR(s.yaw_deg, 1.9, 1e-9);
    EXPECT_NEAR(s.gimbal_pitch_deg, -7.5, 1e-9);
    EXPECT_NEAR(s.gimbal_heading_deg, 356.4, 1e-9);
    EXPECT_NEAR(s.height_takeoff_m, 20.16, 1e-9);
    EXPECT_NEAR(s.latitude_deg, 45.1, 1e-9);
  }
}

// 50 cues a second, a new value every 0.2 s, then a hover of 4 s: the climb is straight at every cue, the
// hover stays level.
TEST(DjiSrt, ValuesHeldOverCuesAreBridged) {
  std::string text;
  const auto cue = [&](int i, double height_m) {
    char line[200];
    std::snprintf(line, sizeof line,
                  "%d\n00:00:%02d,%03d --> 00:00:%02d,%03d\n[latitude: 45.1] [longitude: 7.2] [rel_alt: %.3f "
                  "abs_alt: 0.0]\n\n",
                  i + 1, i / 50, i % 50 * 20, i / 50, i % 50 * 20 + 20, height_m);
    text += line;
  };
  for (int i = 0; i < 100; ++i) cue(i, 10.0 + 0.1 * (i / 10));
  for (int i = 100; i < 300; ++i) cue(i, 11.0);
  cue(300, 12.0);
  const auto track = parse_track(text, "clip.SRT");
  ASSERT_TRUE(track.ok()) << track.error().message();
  ASSERT_EQ(track->samples.size(), 301u);
  for (std::size_t i = 0; i < 100; ++i)
    EXPECT_NEAR(track->samples[i].height_takeoff_m, 10.0 + 0.01 * static_cast<double>(i), 1e-9) << i;
  for (std::size_t i = 100; i < 300; ++i) EXPECT_NEAR(track->samples[i].height_takeoff_m, 11.0, 1e-9) << i;
}

TEST(DjiSrt, FilesWithoutPositionAreRefusedWithAReason) {
  const auto goggles = one_cue("signal:4 ch:2 flightTime:14 uavBat:16.2V glsBat:12.1V");
  ASSERT_FALSE(goggles.ok());
  EXPECT_NE(goggles.error().found.find("goggles"), std::string::npos);
  const auto mavic_air = one_cue(
      "<font size=\"36\">FrameCnt : 1, DiffTime : 39ms\n2018-02-19 08:04:51,265,847\n[iso : 100] </font>");
  ASSERT_FALSE(mavic_air.ok());
  EXPECT_EQ(mavic_air.error().code, "telemetry_empty");
}

TEST(DjiSrt, RealFiles) {
  struct File {
    const char* name;
    const char* variant;
    std::size_t cues;
    double latitude_deg, longitude_deg, height_m;
    const char* local;
  };
  const File files[] = {
      {"Avata360.SRT", "H", 5, 53.365080, 6.460739, 5.4, "2026-05-27T13:10:00.015Z"},
      {"Mini5PRO.SRT", "F", 5, 53.365108, 6.460719, 6.0, "2026-05-27T13:14:22.911Z"},
      {"air3S.SRT", "F", 5, 34.270373, -84.176160, 0.0, "2026-05-17T08:28:30.219Z"},
      {"neo2.SRT", "F", 5, 45.607181, 13.753860, 0.0, "2026-05-15T08:24:18.623Z"},
      {"MICK_folsomlake_DJI_0031-01.srt", "B'", 39, 38.7225, -121.1689, -1.5, ""},
  };
  for (const File& f : files) {
    const auto path = furrow_data(std::string("telemetry/srt/") + f.name);
    FURROW_NEEDS_DATA(path);
    const auto track = read_track(path);
    ASSERT_TRUE(track.ok()) << track.error().message();
    EXPECT_EQ(track->variant, f.variant) << f.name;
    ASSERT_EQ(track->samples.size(), f.cues) << f.name;
    const Sample& s = track->samples.front();
    EXPECT_NEAR(s.latitude_deg, f.latitude_deg, 1e-9) << f.name;
    EXPECT_NEAR(s.longitude_deg, f.longitude_deg, 1e-9) << f.name;
    EXPECT_NEAR(s.height_takeoff_m, f.height_m, 1e-9) << f.name;
    EXPECT_EQ(s.t_local_ns ? base::format_utc(*s.t_local_ns) : "", f.local) << f.name;
    // Subtitles name gimbal angles only when there is a gimbal: a level one is level, not unknown.
    if (f.variant == std::string("H")) {
      EXPECT_EQ(s.gimbal_pitch_deg, 0.0);
    }
  }
}

TEST(DjiSrt, ZeroIsNoFix) {
  const auto path = furrow_data("telemetry/srt/neo2_nogps.SRT");
  FURROW_NEEDS_DATA(path);
  const auto track = read_track(path);
  ASSERT_TRUE(track.ok());
  EXPECT_TRUE(std::isnan(track->samples.front().latitude_deg));
  EXPECT_NEAR(track->samples.back().latitude_deg, 32.848932, 1e-9);
}

}  // namespace
}  // namespace furrow::telemetry
