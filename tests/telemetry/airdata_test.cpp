#include <gtest/gtest.h>

#include <cmath>

#include "furrow/telemetry/formats.h"
#include "samples.h"

namespace furrow::telemetry {
namespace {

const std::filesystem::path kSitrec =
    furrow_data("telemetry/airdata/sitrec_Dec-22nd-2023-11-56AM-Flight-Airdata.csv");

/// A log in AirData's columns, cut to those that are read.
struct Row {
  double t_ms = 0, latitude = 48.0, longitude = 11.0, height = 0, sonar = 0, gimbal_pitch = -12.4;
  int photo = 0;
  std::string datetime = "2026-05-31 10:00:00";
};
std::string log_text(const std::vector<Row>& rows, const std::string& length = "feet",
                     const std::string& speed = "mph") {
  std::string text = "time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(" + length +
                     "),altitude_above_seaLevel(" + length + "),height_sonar(" + length + "),speed(" + speed +
                     "), pitch(degrees),isPhoto,gimbal_heading(degrees),gimbal_pitch(degrees),message\n";
  for (const Row& r : rows)
    text += std::to_string(r.t_ms) + "," + r.datetime + "," + std::to_string(r.latitude) + "," +
            std::to_string(r.longitude) + "," + std::to_string(r.height) + "," +
            std::to_string(r.height + 1000) + "," + std::to_string(r.sonar) + ",10, 2.7," +
            std::to_string(r.photo) + ",312.4," + std::to_string(r.gimbal_pitch) + ",\"one, two\"\n";
  return text;
}
bool warns(const Track& track, const std::string& words) {
  for (const std::string& warning : track.warnings)
    if (warning.find(words) != std::string::npos) return true;
  return false;
}

TEST(AirData, ReadsTheRealFlight) {
  FURROW_NEEDS_DATA(kSitrec);
  const auto track = read_track(kSitrec);
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_EQ(track->format, "airdata");
  // 6074 rows, of which the last repeats the time before it.
  ASSERT_EQ(track->samples.size(), 6073u);
  EXPECT_TRUE(warns(*track, "1 row (first: line 6075)"));
  std::vector<double> marks_s;
  for (const Sample& s : track->samples)
    if (s.is_photo) marks_s.push_back(base::ns_to_seconds(s.t_log_ns));
  ASSERT_EQ(marks_s.size(), 3u);
  EXPECT_NEAR(marks_s[0], 83.9, 1e-9);
  EXPECT_NEAR(marks_s[1], 295.7, 1e-9);
  EXPECT_NEAR(marks_s[2], 332.5, 1e-9);
  const Sample& first = track->samples.front();
  EXPECT_NEAR(first.latitude_deg, 38.7215258502576, 1e-12);
  EXPECT_NEAR(first.height_terrain_msl_m, 466.09744864215 * 0.3048, 1e-9);
  EXPECT_NEAR(first.yaw_deg, 325.9, 1e-9);
  EXPECT_NEAR(first.pitch_deg, 2.7, 1e-9);
  EXPECT_TRUE(first.is_video);
  // The second turns over between 800 and 900 ms: the log starts 0.1 to 0.2 s after 19:56:32.
  const auto t0 = base::parse_date_time("2023-12-22 19:56:32");
  EXPECT_NEAR(base::ns_to_seconds(*first.t_utc_ns - *t0), 0.1, 0.11);
  EXPECT_LT(track->utc_sigma_s, 0.1);
}

TEST(AirData, HeldSonarOfTheRealFlightIsNotTrusted) {
  FURROW_NEEDS_DATA(kSitrec);
  const auto track = read_track(kSitrec);
  ASSERT_TRUE(track.ok());
  std::size_t trusted = 0;
  for (const Sample& s : track->samples) {
    if (std::isnan(s.height_vps_m)) continue;
    ++trusted;
    EXPECT_LE(s.height_takeoff_m, 10.0);
    // The file repeats 9.9 m from 38.5 s to 103.2 s and 12.1 m from 281.4 s to 598.6 s.
    const double t_s = base::ns_to_seconds(s.t_log_ns);
    EXPECT_FALSE((t_s > 38.45 && t_s < 103.25) || (t_s > 281.35 && t_s < 598.65)) << t_s;
  }
  EXPECT_GT(trusted, 1500u);
  EXPECT_TRUE(warns(*track, "sonar/vision height not used"));
}

TEST(AirData, UnitsComeFromTheHeader) {
  const std::vector<Row> rows = {{.t_ms = 0, .height = 10, .sonar = 5},
                                 {.t_ms = 100, .height = 10, .sonar = 6}};
  const auto feet = read_airdata(log_text(rows), "feet.csv");
  const auto metres = read_airdata(log_text(rows, "meters", "m/s"), "metres.csv");
  ASSERT_TRUE(feet.ok() && metres.ok());
  EXPECT_NEAR(feet->samples[0].height_takeoff_m, 3.048, 1e-12);
  EXPECT_NEAR(feet->samples[0].height_vps_m, 1.524, 1e-12);
  EXPECT_NEAR(feet->samples[0].speed_mps, 4.4704, 1e-12);
  EXPECT_NEAR(metres->samples[0].height_takeoff_m, 10.0, 1e-12);
  EXPECT_NEAR(metres->samples[0].height_terrain_msl_m, 1010.0, 1e-12);
  EXPECT_NEAR(metres->samples[0].speed_mps, 10.0, 1e-12);
  const auto yards = read_airdata(log_text(rows, "yards"), "yards.csv");
  ASSERT_FALSE(yards.ok());
  EXPECT_EQ(yards.error().code, "telemetry_unit_unknown");
  EXPECT_NE(yards.error().found.find("yards"), std::string::npos);
  std::string bare_text = log_text(rows);
  bare_text.replace(bare_text.find("height_sonar(feet)"), 18, "height_sonar");
  const auto bare = read_airdata(bare_text, "bare.csv");
  ASSERT_FALSE(bare.ok()) << "a unit is never assumed";
  EXPECT_EQ(bare.error().code, "telemetry_unit_unknown");
  EXPECT_NE(bare.error().found.find("height_sonar"), std::string::npos);
}

// Ten rows a second, each with a datetime cut to the second: the constant must come out to a row's step,
// wherever in the second the log starts.
TEST(AirData, UtcIsFoundInsideTheSecond) {
  const auto start = *base::parse_date_time("2026-05-31 10:00:00");
  for (int phase_ms = 0; phase_ms < 1000; phase_ms += 137) {
    std::vector<Row> rows;
    for (int i = 0; i < 300; ++i) {
      // Steps of 0, 100 and 200 ms, as real files have them.
      const int t_ms = 100 * i + (i % 17 == 3 ? 100 : 0);
      Row row{.t_ms = static_cast<double>(t_ms)};
      row.datetime =
          base::format_utc(start + (t_ms + phase_ms) / 1000 * base::kNanosecondsPerSecond).substr(0, 19);
      row.datetime[10] = ' ';
      rows.push_back(row);
    }
    const auto track = read_airdata(log_text(rows), "x.csv");
    ASSERT_TRUE(track.ok());
    const double error_s = base::ns_to_seconds(*track->samples[0].t_utc_ns - start) - phase_ms / 1000.0;
    EXPECT_LE(std::abs(error_s), 0.05 + 1e-9) << phase_ms;
    EXPECT_LE(track->utc_sigma_s, 0.1 / std::sqrt(12.0) + 1e-9);
  }
}

TEST(AirData, AJumpOfTheDatetimeIsReportedAndOutvoted) {
  std::vector<Row> rows;
  for (int i = 0; i < 200; ++i) {
    Row row{.t_ms = 100.0 * i};
    const int second = i / 10 + (i >= 180 ? 3 : 0);
    row.datetime = "2026-05-31 10:00:" + std::string(second < 10 ? "0" : "") + std::to_string(second);
    rows.push_back(row);
  }
  const auto track = read_airdata(log_text(rows), "x.csv");
  ASSERT_TRUE(track.ok());
  EXPECT_TRUE(warns(*track, "20 of 200 rows"));
  EXPECT_NEAR(
      base::ns_to_seconds(*track->samples[0].t_utc_ns - *base::parse_date_time("2026-05-31 10:00:00")), 0.05,
      0.051);
}

TEST(AirData, PhotoMarksAreRisingEdges) {
  std::vector<Row> rows;
  for (int i = 0; i < 60; ++i)
    rows.push_back({.t_ms = 100.0 * i, .photo = (i >= 5 && i < 8) || i == 20 || i >= 40});
  const auto track = read_airdata(log_text(rows), "x.csv");
  ASSERT_TRUE(track.ok());
  std::vector<std::size_t> marks;
  for (std::size_t i = 0; i < track->samples.size(); ++i)
    if (track->samples[i].is_photo) marks.push_back(i);
  EXPECT_EQ(marks, (std::vector<std::size_t>{5, 20, 40}));
  EXPECT_TRUE(warns(*track, "photo mark stays on"));
}

TEST(AirData, MarksOnBothSidesOfAHoleAreTwoPictures) {
  std::vector<Row> rows;
  for (int i = 0; i < 30; ++i) {
    if (i > 10 && i < 20) continue;  // a second of the log is lost
    rows.push_back({.t_ms = 100.0 * i, .photo = i == 10 || i == 20 || i == 21});
  }
  const auto track = read_airdata(log_text(rows), "x.csv");
  ASSERT_TRUE(track.ok());
  std::vector<double> marks_s;
  for (const Sample& s : track->samples)
    if (s.is_photo) marks_s.push_back(base::ns_to_seconds(s.t_log_ns));
  EXPECT_EQ(marks_s, (std::vector<double>{1.0, 2.0}));
}

TEST(AirData, AMarkInADroppedRowIsKept) {
  const auto track =
      read_airdata(log_text({{.t_ms = 0}, {.t_ms = 100}, {.t_ms = 100, .photo = 1}, {.t_ms = 200}}), "x.csv");
  ASSERT_TRUE(track.ok());
  ASSERT_EQ(track->samples.size(), 3u);
  EXPECT_TRUE(track->samples[1].is_photo);
}

// A craft that hovers over level ground shows one sonar value too; only the barometer tells a lost sensor
// from a still one.
TEST(AirData, SonarThatStandsStillIsTrustedUntilTheBarometerMoves) {
  std::vector<Row> still, climbing;
  for (int i = 0; i < 100; ++i) {
    still.push_back({.t_ms = 100.0 * i, .height = 3.0 + 0.1 * (i % 3), .sonar = 2.9});
    climbing.push_back(
        {.t_ms = 100.0 * i, .height = 3.0 + 0.05 * i, .sonar = i < 20 ? 3.0 + 0.05 * i : 3.95});
  }
  const auto hover = read_airdata(log_text(still, "meters"), "x.csv");
  const auto climb = read_airdata(log_text(climbing, "meters"), "x.csv");
  ASSERT_TRUE(hover.ok() && climb.ok());
  for (const Sample& s : hover->samples) EXPECT_NEAR(s.height_vps_m, 2.9, 1e-12);
  EXPECT_NEAR(climb->samples[10].height_vps_m, 3.5, 1e-12);
  for (std::size_t i = 20; i < 100; ++i) EXPECT_TRUE(std::isnan(climb->samples[i].height_vps_m)) << i;
}

TEST(AirData, AConstantZeroGimbalIsUnknown) {
  const auto zero =
      read_airdata(log_text({{.t_ms = 0, .gimbal_pitch = 0}, {.t_ms = 100, .gimbal_pitch = 0}}), "x.csv");
  ASSERT_TRUE(zero.ok());
  EXPECT_TRUE(std::isnan(zero->samples[0].gimbal_pitch_deg));
  EXPECT_TRUE(warns(*zero, "gimbal pitch is 0 in every row"));
  const auto moves =
      read_airdata(log_text({{.t_ms = 0, .gimbal_pitch = 0}, {.t_ms = 100, .gimbal_pitch = -1}}), "x.csv");
  ASSERT_TRUE(moves.ok());
  EXPECT_EQ(moves->samples[0].gimbal_pitch_deg, 0.0);
}

TEST(AirData, HeightsThatNothingFliesAtAreUnknown) {
  const std::string text = log_text({{.t_ms = 0, .height = 60000},
                                     {.t_ms = 100, .height = 1e308, .sonar = 3},
                                     {.t_ms = 200, .height = -70000},
                                     {.t_ms = 300, .height = 10, .sonar = 1e9}});
  const auto track = read_airdata(text, "x.csv");
  ASSERT_TRUE(track.ok());
  ASSERT_EQ(track->samples.size(), 4u);
  EXPECT_NEAR(track->samples[0].height_takeoff_m, 18288.0, 1e-9);
  for (const std::size_t i : {1u, 2u}) {
    EXPECT_TRUE(std::isnan(track->samples[i].height_takeoff_m)) << i;
    EXPECT_TRUE(std::isnan(track->samples[i].height_terrain_msl_m)) << i;
  }
  EXPECT_NEAR(track->samples[3].height_takeoff_m, 3.048, 1e-9);
  EXPECT_TRUE(std::isnan(track->samples[3].height_vps_m));
  EXPECT_TRUE(warns(*track, "a height beyond 20 km in 3 rows (first: line 3): taken as unknown"));
  EXPECT_FALSE(warns(*read_airdata(log_text({{.t_ms = 0, .height = 60000}}), "x.csv"), "20 km"));
}

TEST(AirData, TextInNumericCellsAndNoFixAreUnknown) {
  std::string text = log_text({{.t_ms = 0}, {.t_ms = 100}, {.t_ms = 200, .latitude = 0, .longitude = 0}});
  const std::string cell = ",0.000000,1000.000000,";
  text.replace(text.find(cell), cell.size(), ",Available with any HD 360 subscription,1000.000000,");
  const auto track = read_airdata(text, "x.csv");
  ASSERT_TRUE(track.ok());
  ASSERT_EQ(track->samples.size(), 3u);
  EXPECT_TRUE(std::isnan(track->samples[0].height_takeoff_m));
  EXPECT_NEAR(track->samples[1].height_takeoff_m, 0.0, 1e-12);
  EXPECT_TRUE(warns(*track, "Available with any HD 360"));
  EXPECT_TRUE(std::isnan(track->samples[2].latitude_deg));
  EXPECT_TRUE(warns(*track, "no fix"));
}

TEST(AirData, MissingColumnsAreNamedWithTheNearest) {
  std::string text = log_text({{.t_ms = 0}});
  text.replace(text.find("latitude"), 8, "lattitude");
  const auto track = parse_track(text, "flight.csv");
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, "telemetry_column_missing");
  EXPECT_EQ(track.error().where, "flight.csv");
  EXPECT_NE(track.error().found.find("latitude"), std::string::npos);
  EXPECT_NE(track.error().hint.find("lattitude"), std::string::npos);
}

TEST(AirData, CutFilesKeepWhatIsWhole) {
  const std::string text = log_text({{.t_ms = 0}, {.t_ms = 100}, {.t_ms = 200}});
  // Inside the last quoted message, and inside the last row before it.
  for (const std::size_t cut : {std::size_t{5}, std::size_t{40}}) {
    const auto track = parse_track(text.substr(0, text.size() - cut), "x.csv");
    ASSERT_TRUE(track.ok()) << track.error().message();
    EXPECT_EQ(track->samples.size(), 2u);
    EXPECT_FALSE(track->warnings.empty());
  }
  const auto header_only = parse_track(text.substr(0, text.find('\n') + 1), "x.csv");
  ASSERT_FALSE(header_only.ok());
}

}  // namespace
}  // namespace furrow::telemetry
