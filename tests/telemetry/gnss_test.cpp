#include <gtest/gtest.h>

#include <cmath>

#include "furrow/telemetry/formats.h"
#include "samples.h"
#include "telemetry/gps_time.h"

namespace furrow::telemetry {
namespace {

const std::filesystem::path kPos = furrow_data("telemetry/ppk/single_dms.pos");
const std::filesystem::path kNmea = furrow_data("telemetry/ppk/single.nmea");

// Both files hold one and the same solution, written by RTKLIB in two formats: they must agree to their last
// digits.
TEST(Gnss, PosAndNmeaOfOneSolutionAgree) {
  FURROW_NEEDS_DATA(kPos);
  FURROW_NEEDS_DATA(kNmea);
  const auto pos = read_track(kPos);
  const auto nmea = read_track(kNmea);
  ASSERT_TRUE(pos.ok()) << pos.error().message();
  ASSERT_TRUE(nmea.ok()) << nmea.error().message();
  EXPECT_EQ(pos->format, "rtklib_pos");
  EXPECT_EQ(nmea->format, "nmea");
  ASSERT_EQ(pos->samples.size(), 115u);
  ASSERT_EQ(nmea->samples.size(), 115u);
  constexpr double kGeoidInFile_m = 36.478;  // GGA field 11
  for (std::size_t i = 0; i < pos->samples.size(); ++i) {
    const Sample &p = pos->samples[i], &n = nmea->samples[i];
    EXPECT_LE(std::abs(*p.t_utc_ns - *n.t_utc_ns), 10'000'000) << i;
    EXPECT_NEAR(p.latitude_deg, n.latitude_deg, 2.5e-9) << i;
    EXPECT_NEAR(p.longitude_deg, n.longitude_deg, 2.5e-9) << i;
    EXPECT_NEAR(p.height_ellipsoid_m, n.height_geoid_m + kGeoidInFile_m, 1e-3) << i;
    EXPECT_TRUE(std::isnan(n.height_ellipsoid_m)) << "a single-point solution";
  }
  // 00:00:00 GPST on 2005-04-02, 13 leap seconds before UTC's midnight.
  EXPECT_EQ(base::format_utc(*pos->samples[0].t_utc_ns), "2005-04-01T23:59:47.000Z");
  EXPECT_NEAR(pos->samples[0].height_ellipsoid_m, 83.8246, 1e-9);
}

TEST(Gnss, PosInDegreesWeeksAndSouthWest) {
  const auto track = parse_track(
      "% (lat/lon/height=WGS84/geodetic,Q=1:fix,2:float)\n"
      "%  GPST          latitude(deg) longitude(deg)  height(m)   Q  ns\n"
      "2211 296288.250   -0.500000000  -58.851745000   512.9980   1  12\n"
      "2211 296288.450   -0.500001000  -58.851746000   512.9990   2  12\n",
      "x.pos");
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_NEAR(track->samples[0].latitude_deg, -0.5, 1e-12);
  EXPECT_NEAR(track->samples[0].height_geoid_m, 512.998, 1e-9);
  EXPECT_TRUE(std::isnan(track->samples[0].height_ellipsoid_m));
  EXPECT_EQ(base::format_utc(*track->samples[0].t_utc_ns), "2022-05-25T10:17:50.250Z");
  EXPECT_EQ(track->samples[1].t_log_ns, 200'000'000);
}

TEST(Gnss, ASmallSouthernLatitudeInDmsKeepsItsSign) {
  const auto track = parse_track(
      "%  UTC   latitude(d'\") longitude(d'\")  height(m)   Q  ns\n"
      "2026/05/31 10:00:00.000  -0 30 00.00000  -58 51 06.28200  12.5 1 9\n",
      "x.pos");
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_NEAR(track->samples[0].latitude_deg, -0.5, 1e-12);
  EXPECT_NEAR(track->samples[0].longitude_deg, -58.851745, 1e-12);
  EXPECT_EQ(base::format_utc(*track->samples[0].t_utc_ns), "2026-05-31T10:00:00.000Z");
}

TEST(Gnss, NmeaChecksumsAndMidnight) {
  const auto track = parse_track(
      "$GNGGA,235959.50,4807.0380,N,01131.0000,W,4,08,0.9,545.4,M,46.9,M,,\r\n"
      "$GNGGA,235959.50,4807.0380,N,01131.0000,W,4,08,0.9,545.4,M,46.9,M,,*00\r\n"
      "$GNGGA,000000.50,4807.0380,N,01131.0000,W,4,08,0.9,545.4,M,46.9,M,,\r\n",
      "x.nmea");
  ASSERT_TRUE(track.ok()) << track.error().message();
  ASSERT_EQ(track->samples.size(), 2u);
  EXPECT_EQ(track->samples[1].t_log_ns, base::kNanosecondsPerSecond);
  EXPECT_FALSE(track->samples[0].t_utc_ns.has_value());
  EXPECT_NEAR(track->samples[0].latitude_deg, 48.1173, 1e-9);
  EXPECT_NEAR(track->samples[0].longitude_deg, -11.516666666667, 1e-9);
  EXPECT_NEAR(track->samples[0].height_geoid_m, 545.4, 1e-9);
  EXPECT_NEAR(track->samples[0].height_ellipsoid_m, 592.3, 1e-9);
}

TEST(Gnss, GpxSpreadsPointsThatShareASecond) {
  const auto file = furrow_data("telemetry/gpx/uavRmp_flighttrack.gpx");
  FURROW_NEEDS_DATA(file);
  const auto track = read_track(file);
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_EQ(track->format, "gpx");
  const auto& s = track->samples;
  ASSERT_GT(s.size(), 100u);
  EXPECT_NEAR(s[0].latitude_deg, 51.1619418, 1e-12);
  EXPECT_NEAR(s[0].height_geoid_m, 245.11, 1e-12);
  EXPECT_NEAR(s[1].speed_mps, 0.02, 1e-12);
  // 15:24:54 twice, 15:24:55 twice, ...
  EXPECT_EQ(base::format_utc(*s[0].t_utc_ns), "2017-05-10T15:24:54.000Z");
  EXPECT_EQ(base::format_utc(*s[1].t_utc_ns), "2017-05-10T15:24:54.500Z");
  EXPECT_EQ(base::format_utc(*s[2].t_utc_ns), "2017-05-10T15:24:55.000Z");
}

TEST(Gnss, GpxOfAnotherProgram) {
  const auto file = furrow_data("telemetry/gpx/mapillary_sf_30km_h.gpx");
  FURROW_NEEDS_DATA(file);
  const auto track = read_track(file);
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_NEAR(track->samples[0].longitude_deg, -122.461396, 1e-12);
  EXPECT_EQ(base::format_utc(*track->samples[0].t_utc_ns), "2025-03-14T07:00:00.000Z");
}

TEST(Gnss, MrkMarksEveryPicture) {
  const std::string line =
      "2\t296288.242869\t[2211]\t     3,N\t     0,E\t    "
      "75,V\t47.6436873208,Lat\t16.4759271684,Lon\t512.998,Ellh\t0.014391, 0.013698, "
      "0.029694\t50,Q\n";
  std::string next = line;
  next.replace(next.find("296288.242869"), 13, "296290.742869").replace(next.find("50,Q"), 4, "16,Q");
  const auto track = parse_track(line + next, "Timestamp.MRK");
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_EQ(track->format, "dji_mrk");
  ASSERT_EQ(track->samples.size(), 2u);
  EXPECT_TRUE(track->samples[0].is_photo && track->samples[1].is_photo);
  EXPECT_NEAR(track->samples[0].height_ellipsoid_m, 512.998, 1e-12);
  EXPECT_NEAR(track->samples[0].latitude_deg, 47.6436873208, 1e-12);
  EXPECT_EQ(track->samples[1].t_log_ns, 2'500'000'000);
  bool warned = false;
  for (const std::string& w : track->warnings)
    warned = warned || w.find("without a fixed RTK") != std::string::npos;
  EXPECT_TRUE(warned);
}

// IERS Bulletin C: GPS - UTC was 13 s from 1999, 17 s in 2016, 18 s from 2017-01-01.
TEST(Gnss, LeapSeconds) {
  const auto utc = [](const char* gps) {
    return base::format_utc(reader::utc_from_gps(*base::parse_date_time(gps)));
  };
  EXPECT_EQ(utc("1980-01-06 00:00:00"), "1980-01-06T00:00:00.000Z");
  EXPECT_EQ(utc("2005-04-02 00:00:13"), "2005-04-02T00:00:00.000Z");
  EXPECT_EQ(utc("2017-01-01 00:00:16"), "2016-12-31T23:59:59.000Z");
  EXPECT_EQ(utc("2017-01-01 00:00:18"), "2017-01-01T00:00:00.000Z");
  EXPECT_EQ(utc("2026-05-31 12:00:18"), "2026-05-31T12:00:00.000Z");
  EXPECT_EQ(reader::gps_time(0, 0.0), *base::parse_date_time("1980-01-06 00:00:00"));
}

}  // namespace
}  // namespace furrow::telemetry
