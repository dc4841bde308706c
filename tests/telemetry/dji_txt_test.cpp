#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/file.h"
#include "furrow/telemetry/formats.h"
#include "samples.h"

namespace furrow::telemetry {
namespace {

const std::filesystem::path kRecord =
    furrow_data("telemetry/dji_txt/DJIFlightRecord_2015-12-29_[19-05-48].txt");

TEST(DjiTxt, ReadsARealVersion4Record) {
  FURROW_NEEDS_DATA(kRecord);
  const auto track = read_track(kRecord);
  ASSERT_TRUE(track.ok()) << track.error().message();
  EXPECT_EQ(track->format, "dji_txt");
  EXPECT_EQ(track->variant, "version 4");
  // 872 position records, 15 of which repeat the tick before.
  EXPECT_EQ(track->samples.size(), 857u);
  const Sample& first = track->samples.front();
  EXPECT_NEAR(first.latitude_deg, 53.73587938722398, 1e-12);
  EXPECT_NEAR(first.longitude_deg, -1.7665183228942154, 1e-12);
  EXPECT_NEAR(first.yaw_deg, 63.7, 1e-9);
  EXPECT_NEAR(first.roll_deg, -1.3, 1e-9);
  // The record's name says 19-05-48, in British winter time.
  EXPECT_EQ(base::format_utc(*first.t_utc_ns).substr(0, 18), "2015-12-29T19:05:4");
  EXPECT_EQ(base::format_utc(*track->samples.back().t_utc_ns).substr(0, 17), "2015-12-29T19:07:");
  EXPECT_LT(track->utc_sigma_s, 0.2);
  double highest_m = 0.0;
  int marks = 0;
  for (const Sample& s : track->samples) {
    highest_m = std::fmax(highest_m, s.height_takeoff_m);
    marks += s.is_photo;
    EXPECT_TRUE(std::isnan(s.height_vps_m) || s.height_vps_m < 25.5);
    EXPECT_TRUE(std::isnan(s.gimbal_pitch_deg)) << "0 in every record";
  }
  EXPECT_NEAR(highest_m, 39.5, 1e-9);
  EXPECT_EQ(marks, 1);
}

TEST(DjiTxt, ACutRecordGivesWhatStandsBeforeTheCut) {
  FURROW_NEEDS_DATA(kRecord);
  const std::string whole = *base::read_file(kRecord);
  const auto half = parse_track(std::string_view(whole).substr(0, 50000), "cut.txt");
  ASSERT_TRUE(half.ok()) << half.error().message();
  EXPECT_GT(half->samples.size(), 300u);
  EXPECT_LT(half->samples.size(), 500u);
}

/// A prefix of a given version with room for what stands before the records.
std::string prefix(char version, std::size_t header_bytes) {
  std::string bytes(header_bytes, '\0');
  bytes[0] = 100;
  bytes[10] = version;
  return bytes;
}

TEST(DjiTxt, EncryptedVersionsSayHowToExport) {
  const auto track = parse_track(prefix(14, 200), "new.txt");
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, "telemetry_encrypted");
  EXPECT_NE(track.error().hint.find("AirData"), std::string::npos);
}

TEST(DjiTxt, ScrambledRecordsThatMakeNoSenseAreRefused) {
  std::string bytes = prefix(9, 100);
  for (int i = 0; i < 10; ++i)
    bytes += std::string("\x01\x32") + std::string(50, static_cast<char>(0x91 + i)) + '\xFF';
  const auto details = bytes.size();
  bytes[0] = static_cast<char>(details & 255);
  bytes[1] = static_cast<char>(details >> 8);
  const auto track = parse_track(bytes, "scrambled.txt");
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, "telemetry_encrypted");
}

}  // namespace
}  // namespace furrow::telemetry
