#include <gtest/gtest.h>

#include <filesystem>

#include "damaged.h"
#include "furrow/base/file.h"
#include "furrow/telemetry/track.h"
#include "samples.h"

namespace furrow::telemetry {
namespace {

// A reader may refuse damaged text or read what is whole; either way its promises hold.
void expect_sound(const Result<Track>& track) {
  if (!track.ok()) {
    EXPECT_FALSE(track.error().code.empty());
    EXPECT_FALSE(track.error().where.empty());
    EXPECT_FALSE(track.error().found.empty());
    return;
  }
  EXPECT_FALSE(track->samples.empty());
  for (std::size_t i = 1; i < track->samples.size(); ++i)
    ASSERT_LT(track->samples[i - 1].t_log_ns, track->samples[i].t_log_ns);
  for (const Sample& s : track->samples) {
    ASSERT_FALSE(std::abs(s.latitude_deg) > 90.0);
    ASSERT_FALSE(s.yaw_deg < 0.0 || s.yaw_deg >= 360.0);
  }
}

TEST(Fuzz, DamagedFilesNeverCrashAReader) {
  std::vector<std::string> seeds = {
      "1\n00:00:01,000 --> 00:00:02,000\nHOME(149.0251,-20.2532) 2017.08.05 "
      "14:11:51\nGPS(149.0251,-20.2533,16) BAROMETER:1.9\n\n",
      "1\n00:00:01,000 --> 00:00:02,000\nF/5.6, SS 400, GPS (-58.851745, -34.237922, 15), HOME (-58.8, "
      "-34.2, -57.98m), H 85.80m, H.S "
      "0.00m/s, F.PRY (2.7, -7.0, 110.1), G.PRY (-24.4, 0.0, 110.4)\n\n",
      "CUSTOM.date [local],CUSTOM.updateTime [local],OSD.flyTime [s],OSD.latitude,OSD.longitude,OSD.height "
      "[ft],OSD.yaw\n"
      "5/31/2026,1:02:03.456 PM,0.1,48,11,3,-170\n5/31/2026,1:02:03.556 PM,0.2,48,11,3,-170\n"};
  seeds.emplace_back(
      "2\t296288.242869\t[2211]\t     3,N\t     0,E\t    "
      "75,V\t47.6436873208,Lat\t16.4759271684,Lon\t512.998,Ellh\t0.01, 0.01, "
      "0.02\t50,Q\n");
  for (const char* folder :
       {"telemetry/airdata", "telemetry/srt", "telemetry/ppk", "telemetry/gpx", "telemetry/dji_txt"}) {
    const auto path = furrow_data(folder);
    if (!std::filesystem::exists(path)) continue;
    constexpr std::size_t kEnough = 20000;
    for (const auto& entry : std::filesystem::directory_iterator(path))
      seeds.push_back(base::read_file(entry.path())->substr(0, kEnough));
  }
  // More, and other ones, by hand: FURROW_FUZZ_ROUNDS=20000.
  const char* wished = std::getenv("FURROW_FUZZ_ROUNDS");
  const int rounds = wished != nullptr ? std::atoi(wished) : 150;
  base::Random random(31052026 + static_cast<std::uint64_t>(rounds));
  for (const std::string& seed : seeds)
    for (int i = 0; i < rounds; ++i) expect_sound(parse_track(testing::damaged(seed, random), "damaged"));
}

TEST(Fuzz, MonstersEndInTime) {
  const std::string many_years = [] {
    std::string text = "1\n00:00:00,000 --> 00:00:01,000\nF/2, GPS (1, 2, 3), H 1.0m ";
    for (int i = 0; i < 400000; ++i) text += "2026-";
    return text;
  }();
  expect_sound(parse_track(many_years, "years"));
  expect_sound(parse_track("1\n00:00:00,000 --> 00:00:01,000\n" + std::string(4'000'000, '('), "brackets"));
  expect_sound(parse_track("1\n00:00:00,000 --> 00:00:01,000\n" + std::string(4'000'000, 'H'), "letters"));
  expect_sound(parse_track(std::string(4'000'000, ','), "commas"));
  std::string arrows;
  for (int i = 0; i < 200000; ++i) arrows += "1\n00:00:00,000 --> 00:00:01,000\n";
  expect_sound(parse_track(arrows, "arrows"));
  expect_sound(
      parse_track("time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet)\n1e308,x,1,"
                  "2,3\n-1e308,,,,\n"
                  "9223372036854775807,2026-01-01 00:00:00,1e300,2,-1e300\nnan,inf,nan,inf,nan\n",
                  "numbers"));
}

}  // namespace
}  // namespace furrow::telemetry
