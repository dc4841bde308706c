#include "furrow/telemetry/shot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
#include "samples.h"

namespace furrow::telemetry {
namespace {

bool warns(const Shot& shot, const std::string& words) {
  for (const std::string& warning : shot.warnings)
    if (warning.find(words) != std::string::npos) return true;
  return false;
}

TEST(ReadShot, MiniSeHasPitchAndAUselessHeight) {
  const auto file = furrow_data("flights/mini-se/early_corn/DJI_0189.JPG");
  FURROW_NEEDS_DATA(file);
  testing::internal::CaptureStderr();
  const auto shot = read_shot(file);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_EQ(shot->shot_id, "DJI_0189");
  EXPECT_EQ(shot->camera_model, "FC7203");
  EXPECT_EQ(shot->width, 4000);
  EXPECT_EQ(shot->height, 2250);
  EXPECT_NEAR(shot->metadata.gimbal_pitch_deg, -60.2, 1e-9);
  EXPECT_NEAR(shot->metadata.yaw_deg, 360.0 - 152.1, 1e-9);
  EXPECT_NEAR(shot->metadata.height_takeoff_m, 0.0, 1e-9);
  EXPECT_TRUE(std::isnan(shot->metadata.height_ellipsoid_m))
      << "no RTK: AbsoluteAltitude is pressure altitude";
  EXPECT_TRUE(warns(*shot, "RelativeAltitude is 0.00 m"));
  EXPECT_EQ(base::format_utc(*shot->t_camera_local_ns), "2023-05-31T16:18:55.000Z");
  EXPECT_FALSE(shot->metadata.t_utc_ns.has_value());
}

TEST(ReadShot, AHeightThatNothingFliesAtIsUnknown) {
  const auto file = furrow_data("flights/mini-se/early_corn/DJI_0189.JPG");
  FURROW_NEEDS_DATA(file);
  std::string bytes = *base::read_file(file);
  const std::string height = "drone-dji:RelativeAltitude=\"";
  const std::size_t at = bytes.find(height + "+0.00\"");
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at + height.size(), 5, "1e308");
  const auto folder = std::filesystem::path(testing::TempDir()) / "furrow_shot_height";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(base::write_file(folder / "high.jpg", bytes).ok());
  const auto shot = read_shot(folder / "high.jpg");
  std::filesystem::remove_all(folder);
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_TRUE(std::isnan(shot->metadata.height_takeoff_m));
  EXPECT_TRUE(warns(*shot, "a height beyond 20 km"));
}

TEST(ReadShot, P4RtkFixedGivesAnEllipsoidalHeight) {
  const auto file = furrow_data("telemetry/dji_jpeg/p4rtk/DJI_0010.JPG");
  FURROW_NEEDS_DATA(file);
  const auto shot = read_shot(file);
  ASSERT_TRUE(shot.ok());
  EXPECT_NEAR(shot->metadata.height_ellipsoid_m, 349.58, 1e-9);
  EXPECT_NEAR(shot->metadata.height_takeoff_m, 44.47, 1e-9);
  EXPECT_NEAR(shot->metadata.latitude_deg, 45.03159568, 1e-12);
  EXPECT_NEAR(shot->metadata.longitude_deg, 7.62046587, 1e-12);
  EXPECT_NEAR(shot->metadata.gimbal_heading_deg, 106.8, 1e-9);
  EXPECT_EQ(shot->camera_model, "FC6360");
}

TEST(ReadShot, Phantom3HasItsPlaceInExifOnly) {
  const auto file = furrow_data("telemetry/dji_jpeg/p3/DJI_0018.JPG");
  FURROW_NEEDS_DATA(file);
  const auto shot = read_shot(file);
  ASSERT_TRUE(shot.ok());
  // Brighton Beach, Duluth, at Lake Superior.
  EXPECT_NEAR(shot->metadata.latitude_deg, 46.84, 0.01);
  EXPECT_NEAR(shot->metadata.longitude_deg, -91.99, 0.01);
  EXPECT_NEAR(shot->metadata.gimbal_pitch_deg, -89.9, 1e-9);
  EXPECT_TRUE(std::isnan(shot->metadata.height_ellipsoid_m));
}

TEST(ReadShot, SequoiaCountsPitchFromTheNadir) {
  const auto file = furrow_data("telemetry/sequoia/IMG_161122_163234_0000_RGB.JPG");
  FURROW_NEEDS_DATA(file);
  const auto shot = read_shot(file);
  ASSERT_TRUE(shot.ok());
  EXPECT_NEAR(shot->metadata.gimbal_pitch_deg, 5.1846 - 90.0, 1e-9);
  EXPECT_NEAR(shot->metadata.gimbal_heading_deg, 360.0 - 16.7996, 1e-9);
}

TEST(ReadShot, APictureWithoutMetadataIsNoError) {
  const auto file = furrow_data("flights/mini-se/mid_corn/shot_001.jpg");
  FURROW_NEEDS_DATA(file);
  const auto shot = read_shot(file);
  ASSERT_TRUE(shot.ok());
  EXPECT_EQ(shot->width, 1280);
  EXPECT_TRUE(std::isnan(shot->metadata.gimbal_pitch_deg));
  EXPECT_FALSE(shot->t_camera_local_ns.has_value());
}

TEST(ReadShot, MissingAndBrokenPictures) {
  EXPECT_EQ(read_shot("/nonexistent/a.jpg").error().code, "file_missing");
  const auto folder = std::filesystem::path(testing::TempDir()) / "furrow_shot_test";
  std::filesystem::create_directories(folder);
  testing::internal::CaptureStderr();
  for (const std::string& bytes :
       {std::string(), std::string("\xFF\xD8\xFF\xE1"), std::string("no picture at all")}) {
    ASSERT_TRUE(base::write_file(folder / "broken.jpg", bytes).ok());
    const auto shot = read_shot(folder / "broken.jpg");
    ASSERT_FALSE(shot.ok());
    EXPECT_EQ(shot.error().code, "picture_unreadable");
    EXPECT_NE(shot.error().where.find("broken.jpg"), std::string::npos);
  }
  EXPECT_EQ(read_shot(folder).error().code, "picture_unreadable");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  std::filesystem::remove_all(folder);
}

// A cut anywhere in the first part, where the metadata stand, and flipped bytes: an answer or an error,
// nothing on stderr, no side files.
TEST(ReadShot, DamagedPicturesNeverCrashAndLeaveNothingBehind) {
  const auto file = furrow_data("flights/mini-se/early_corn/DJI_0189.JPG");
  FURROW_NEEDS_DATA(file);
  const std::string whole = *base::read_file(file);
  const auto folder = std::filesystem::path(testing::TempDir()) / "furrow_shot_damage";
  std::filesystem::create_directories(folder);
  testing::internal::CaptureStderr();
  base::parallel_for(60, 2, [&](std::size_t i) {
    std::string bytes = whole.substr(0, 200 + 700 * i);
    for (std::size_t k = 0; k < i; ++k)
      bytes[(k * 7919 + i * 104729) % bytes.size()] ^= static_cast<char>(1 << (k % 8));
    const auto path = folder / (std::to_string(i) + ".jpg");
    ASSERT_TRUE(base::write_file(path, bytes).ok());
    static_cast<void>(read_shot(path));
  });
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    EXPECT_EQ(entry.path().extension(), ".jpg");
  std::filesystem::remove_all(folder);
}

TEST(ShotIds, EqualStemsGetTheirFolder) {
  std::vector<Shot> shots(5);
  shots[0].image = "left/DJI_1.JPG";
  shots[1].image = "right/DJI_1.JPG";
  shots[2].image = "left/DJI_2.JPG";
  shots[3].image = "a/left/DJI_3.JPG";
  shots[4].image = "b/left/DJI_3.JPG";
  for (Shot& shot : shots) shot.shot_id = shot.image.stem().string();
  const auto named = with_unique_ids(shots);
  EXPECT_EQ(named[0].shot_id, "left/DJI_1");
  EXPECT_EQ(named[1].shot_id, "right/DJI_1");
  EXPECT_EQ(named[2].shot_id, "DJI_2");
  EXPECT_EQ(named[3].shot_id, "left/DJI_3#1");
  EXPECT_EQ(named[4].shot_id, "left/DJI_3#2");
}

}  // namespace
}  // namespace furrow::telemetry
