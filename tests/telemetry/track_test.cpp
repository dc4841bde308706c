#include "furrow/telemetry/track.h"

#include <gtest/gtest.h>

#include "samples.h"

namespace furrow::telemetry {
namespace {

TEST(ReadTrack, AnEmptyFileIsSaidToBeEmpty) {
  for (const char* text : {"", " \n\n", "\xEF\xBB\xBF"}) {
    const auto track = parse_track(text, "empty.csv");
    ASSERT_FALSE(track.ok());
    EXPECT_EQ(track.error().code, "telemetry_empty");
    EXPECT_EQ(track.error().where, "empty.csv");
  }
}

TEST(ReadTrack, AMissingFileIsNamed) {
  const auto track = read_track("/nonexistent/flight.csv");
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, "file_missing");
  EXPECT_NE(track.error().where.find("flight.csv"), std::string::npos);
}

TEST(ReadTrack, UnknownContentListsWhatCanBeRead) {
  const auto track = parse_track("a,b,c\n1,2,3\n", "x.csv");
  ASSERT_FALSE(track.ok());
  EXPECT_EQ(track.error().code, "telemetry_format_unknown");
  EXPECT_NE(track.error().found.find("a,b,c"), std::string::npos);
  EXPECT_NE(track.error().wanted.find("AirData"), std::string::npos);
}

TEST(ReadTrack, RecognisedButUnreadFormatsAreNamed) {
  EXPECT_NE(parse_track("ULog\x01\x12\x35 rest", "x").error().found.find("ULog"), std::string::npos);
  EXPECT_NE(parse_track("\xFF\xD8\xFF rest", "x").error().found.find("JPEG"), std::string::npos);
  const std::string tlog("\0\5\x1f\x2f\x3f\x4f\x5f\x6f\xFE\x09\x01\x01\x01", 13);
  EXPECT_NE(parse_track(tlog, "x").error().found.find("MAVLink"), std::string::npos);
  EXPECT_NE(parse_track(std::string("\0\1\2\3", 4), "x").error().found.find("no text"), std::string::npos);
}

}  // namespace
}  // namespace furrow::telemetry
