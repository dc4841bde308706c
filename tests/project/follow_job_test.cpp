#include "furrow/project/follow_job.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <thread>

#include "damaged.h"
#include "furrow/base/file.h"
#include "furrow/geom/angles.h"
#include "furrow/geom/attitude.h"
#include "project/by_hand.h"
#include "project/overlay_video.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;

/// Upright green rows on soil, `spacing` px apart, one of them at `u`.
Image rows_picture(double u, double spacing = 80.0, int width = 320, int height = 180) {
  Image picture = image::make_image(width, height, 3);
  for (int v = 0; v < height; ++v) {
    for (int x = 0; x < width; ++x) {
      const double from_row = std::abs(std::remainder(x - u, spacing));
      const int grain = (x * 7 + v * 13) % 11;
      const bool is_leaf = from_row < 0.2 * spacing;
      const auto pixel = picture.at(x, v);
      pixel[0] = static_cast<std::uint8_t>((is_leaf ? 50 : 130) + grain);
      pixel[1] = static_cast<std::uint8_t>((is_leaf ? 130 : 110) + grain);
      pixel[2] = static_cast<std::uint8_t>((is_leaf ? 40 : 85) + grain);
    }
  }
  return picture;
}

/// A source that a test makes up, picture by picture.
class MadeUp final : public image::PictureSource {
 public:
  using Maker = std::function<std::optional<Image>(std::int64_t)>;
  MadeUp(image::SourceKind kind, std::int64_t count, Maker maker) : maker_(std::move(maker)) {
    info_ = {kind, "made up", 30.0, count};
  }
  const image::SourceInfo& info() const override { return info_; }
  std::optional<image::TimedPicture> next() override {
    if (at_ >= info_.count) return std::nullopt;
    image::TimedPicture picture;
    picture.index = at_++;
    picture.name = "picture " + std::to_string(at_);
    picture.t_video_ns = base::seconds_to_ns(static_cast<double>(picture.index) / 30.0);
    auto made = maker_(picture.index);
    if (made) {
      picture.picture = std::move(*made);
    } else {
      picture.error = Error{"picture_unreadable", picture.name, "made unreadable", "", ""};
    }
    return picture;
  }
  std::vector<std::string> trouble() const override { return {}; }
  bool failed() const override { return info_.kind == image::SourceKind::live; }

 private:
  image::SourceInfo info_;
  Maker maker_;
  std::int64_t at_ = 0;
};

std::unique_ptr<image::PictureSource> recorded(std::int64_t count, MadeUp::Maker maker) {
  return std::make_unique<MadeUp>(image::SourceKind::video, count, std::move(maker));
}

/// The job in pixels, with its lines.
struct Followed {
  FollowOutcome outcome;
  std::vector<FollowedPicture> pictures;
  std::string lines;
};

Followed run(std::unique_ptr<image::PictureSource> source, FollowJobOptions options = {}) {
  Followed result;
  options.follower.is_metric = false;
  options.on_picture = [&](const FollowedPicture& picture) {
    result.pictures.push_back(picture);
    result.lines += base::to_json(followed_value(picture, false), -1) + "\n";
    return true;
  };
  auto outcome = follow_job(std::move(source), options);
  EXPECT_TRUE(outcome.ok()) << outcome.error().message();
  if (outcome.ok()) result.outcome = std::move(*outcome);
  return result;
}

TEST(FollowJob, TheRowIsFollowedToSubPixels) {
  const Followed result =
      run(recorded(24, [](std::int64_t i) { return rows_picture(150.0 + 0.5 * static_cast<double>(i)); }));
  ASSERT_EQ(result.pictures.size(), 24U);
  EXPECT_EQ(result.outcome.held, 0);
  for (std::size_t i = 0; i < 24; ++i) {
    const auto& f = result.pictures[i].following;
    ASSERT_TRUE(f.thesis.deviation_px.has_value()) << i;
    EXPECT_NEAR(*f.thesis.deviation_px, 150.0 + 0.5 * static_cast<double>(i) - 159.5, 1.0) << i;
  }
}

TEST(FollowJob, LinesDoNotDependOnThreads) {
  const auto lines = [](int threads) {
    FollowJobOptions options;
    options.threads = threads;
    return run(recorded(17,
                        [](std::int64_t i) { return rows_picture(150.0 + 3.0 * static_cast<double>(i)); }),
               options)
        .lines;
  };
  const std::string one = lines(1);
  EXPECT_EQ(one, lines(2));
  EXPECT_EQ(one, lines(5));
}

TEST(FollowJob, WithNothingSeenItHolds) {
  const Followed result = run(recorded(6, [](std::int64_t) { return image::make_image(320, 180, 3); }));
  ASSERT_EQ(result.pictures.size(), 6U);
  EXPECT_EQ(result.outcome.held, 6);
  for (const auto& picture : result.pictures) {
    EXPECT_TRUE(picture.following.is_hold);
    EXPECT_FALSE(picture.following.offset.has_value());
    EXPECT_FALSE(picture.following.hold_reason.empty());
  }
  // Not one number but picture counts, times and the zeros of standing still.
  EXPECT_EQ(result.lines.find("\"offset_px\":0"), std::string::npos);
  EXPECT_NE(result.lines.find("\"offset_px\":null"), std::string::npos);
}

/// A folder of the test's own, empty.
fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::path(::testing::TempDir()) / ("furrow_follow_" + name);
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::vector<double> times_in(const fs::path& video) {
  std::vector<double> times_s;
  auto source = image::open_source(video.string());
  EXPECT_TRUE(source.ok());
  if (!source.ok()) return times_s;
  while (const auto picture = (*source)->next()) times_s.push_back(base::ns_to_seconds(picture->t_video_ns));
  return times_s;
}

TEST(FollowJob, UnreadablePicturesAndOtherSizesDoNotEndIt) {
  FollowJobOptions options;
  options.out = fresh_folder("sizes");
  const Followed result = run(recorded(20,
                                       [](std::int64_t i) -> std::optional<Image> {
                                         if (i == 6) return std::nullopt;
                                         if (i == 12) return rows_picture(40.0, 40.0, 160, 90);
                                         if (i == 13) return image::make_image(1, 1, 3);
                                         return rows_picture(150.0);
                                       }),
                              options);
  EXPECT_EQ(times_in(*options.out / "overlay.mp4").size(), 19U);
  ASSERT_EQ(result.pictures.size(), 20U);
  EXPECT_EQ(result.pictures[6].following.sighting.status, "picture_unreadable");
  EXPECT_NE(result.pictures[13].following.sighting.status, "ok");
  EXPECT_EQ(result.pictures[19].following.sighting.status, "ok");
  EXPECT_FALSE(result.pictures[19].following.is_hold);
}

/// A video of rows that come closer, each picture at its own time.
fs::path rows_video(const fs::path& file, const std::vector<double>& times_s) {
  auto writer = image::VideoWriter::create(file, 320, 180, 30.0);
  EXPECT_TRUE(writer.ok());
  for (std::size_t i = 0; i < times_s.size(); ++i)
    EXPECT_TRUE(writer->add(rows_picture(150.0 + 20.0 * times_s[i]), base::seconds_to_ns(times_s[i])).ok());
  EXPECT_TRUE(writer->finish().ok());
  return file;
}

std::vector<double> uneven_times(int count) {
  std::vector<double> times_s = {0.0};
  while (static_cast<int>(times_s.size()) < count)
    times_s.push_back(times_s.back() + (times_s.size() % 4 ? 0.02 : 0.12));
  return times_s;
}

// The filter's steps and the overlay go by the times of the pictures, not by a nominal rate.
TEST(FollowJob, AVariableRateIsKept) {
  constexpr std::size_t kHeldBack = 16;  // the last pictures come out of a decoder without their times
  FollowJobOptions options;
  options.out = fresh_folder("rate");
  const std::vector<double> times_s = uneven_times(48);
  const Followed result =
      run(*image::open_source(rows_video(*options.out / "vfr.mp4", times_s).string()), options);
  ASSERT_EQ(result.pictures.size(), 48U);
  const std::vector<double> shown_s = times_in(*options.out / "overlay.mp4");
  ASSERT_EQ(shown_s.size(), 48U);
  for (std::size_t i = 0; i + kHeldBack < 48; ++i) {
    EXPECT_NEAR(base::ns_to_seconds(result.pictures[i].following.sighting.t_video_ns), times_s[i], 1e-3) << i;
    EXPECT_NEAR(shown_s[i], times_s[i], 1e-3) << i;
  }
  const auto rate = follow::filtered_rate(result.pictures[31].following.offset_filter);
  EXPECT_NEAR(rate.value, 20.0, 6.0);  // px/s as drawn
}

TEST(FollowJob, AVideoThatEndsMidFrameIsFollowedToItsEnd) {
  const fs::path folder = fresh_folder("cut");
  const std::string whole = base::read_file(rows_video(folder / "whole.mkv", uneven_times(60))).value();
  ASSERT_TRUE(base::write_file(folder / "cut.mkv", whole.substr(0, whole.size() * 3 / 5)).ok());
  const Followed result = run(*image::open_source((folder / "cut.mkv").string()));
  EXPECT_GT(result.pictures.size(), 20U);
  EXPECT_LT(result.pictures.size(), 50U);
  EXPECT_FALSE(result.outcome.source_failed);
  ASSERT_FALSE(result.outcome.notes.empty());
  EXPECT_NE(result.outcome.notes[0].find("cut short"), std::string::npos) << result.outcome.notes[0];
  EXPECT_EQ(result.outcome.seen, result.outcome.pictures);
}

TEST(FollowJob, ACameraThatVanishesEndsItWithWhatCame) {
  FollowJobOptions options;
  options.out = fresh_folder("vanished");
  const Followed result = run(
      std::make_unique<MadeUp>(image::SourceKind::live, 3, [](std::int64_t) { return rows_picture(150.0); }),
      options);
  EXPECT_TRUE(result.outcome.source_failed);
  EXPECT_EQ(times_in(*options.out / "overlay.mp4").size(), result.pictures.size());
  EXPECT_TRUE(fs::exists(*options.out / "follow.csv"));
}

TEST(FollowJob, AnUnpluggedCameraEndsItWithAReason) {
  const auto started = std::chrono::steady_clock::now();
  FollowJobOptions options;
  options.silence_s = 0.3;
  auto silent = std::make_unique<MadeUp>(image::SourceKind::live, 1000, [](std::int64_t i) {
    if (i == 3)
      std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // a driver that does not come back
    return rows_picture(150.0);
  });
  const Followed result = run(std::move(silent), options);
  EXPECT_TRUE(result.outcome.source_failed);
  ASSERT_EQ(result.outcome.notes.size(), 1U);
  EXPECT_NE(result.outcome.notes[0].find("nothing for 0.3 s"), std::string::npos);
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::milliseconds(1400));
  std::this_thread::sleep_for(
      std::chrono::milliseconds(1500));  // the driver's thread ends before the test does
}

TEST(FollowJob, LivePicturesThatComeTooFastAreSkipped) {
  const Followed result = run(std::make_unique<MadeUp>(
      image::SourceKind::live, 120, [](std::int64_t) { return rows_picture(150.0, 80.0, 640, 360); }));
  EXPECT_GT(result.outcome.skipped, 0);
  EXPECT_EQ(result.outcome.skipped + result.outcome.pictures, 120);
  EXPECT_TRUE(std::is_sorted(result.pictures.begin(), result.pictures.end(),
                             [](const auto& a, const auto& b) { return a.index < b.index; }));
}

TEST(FollowJob, StopsWhenAsked) {
  std::atomic<bool> stop{false};
  FollowJobOptions options;
  options.stop = &stop;
  options.follower.is_metric = false;
  std::int64_t seen = 0;
  options.on_picture = [&](const FollowedPicture&) {
    stop = ++seen >= 5;
    return true;
  };
  const auto outcome =
      follow_job(recorded(100000, [](std::int64_t) { return rows_picture(150.0); }), options);
  ASSERT_TRUE(outcome.ok());
  EXPECT_LT(outcome->pictures, 50);
}

TEST(FollowJob, ReadingsByHandAreJoinedByNameAndNumber) {
  const fs::path folder = fs::path(::testing::TempDir()) / "furrow_by_hand";
  fs::remove_all(folder);
  ASSERT_TRUE(base::write_file(folder / "hand.csv",
                               "picture,deviation_px,flight\npicture 2,-9,a\n3,-9.5,a\n4,-11,b\n77,0,b\n")
                  .ok());
  FollowJobOptions options;
  options.by_hand = folder / "hand.csv";
  const Followed result = run(recorded(6, [](std::int64_t) { return rows_picture(150.0); }), options);
  // The row lies at -9.5 px: errors of about -0.5 and 0 in flight a, 1.5 in flight b.
  const auto& table = result.outcome.by_hand;
  ASSERT_EQ(table.rows.size(), 6U);
  EXPECT_EQ(table.columns[4], "mean_error_px");
  const auto error = [&](std::size_t row) { return std::stod(table.rows[row][4]); };
  EXPECT_EQ(table.rows[0][0], "a");
  EXPECT_EQ(table.rows[0][2], "2");
  EXPECT_NEAR(error(0), -0.25, 0.6);
  EXPECT_NEAR(error(2), 1.5, 0.6);
  EXPECT_EQ(table.rows[4][0], "total");
  EXPECT_EQ(table.rows[4][2], "3");
  ASSERT_EQ(result.outcome.notes.size(), 1U);
  EXPECT_NE(result.outcome.notes[0].find("1 pictures read by hand"), std::string::npos);
}

TEST(FollowJob, BadReadingsByHandAreNamed) {
  const fs::path folder = fs::path(::testing::TempDir()) / "furrow_by_hand_bad";
  fs::remove_all(folder);
  const std::pair<const char*, const char*> cases[] = {{"a,b\n1,2\n", "missing_column"},
                                                       {"picture,depth\n1,2\n", "missing_column"},
                                                       {"picture,deviation_m\n1,x\n", "bad_value"},
                                                       {"picture,deviation_m\n", "bad_value"},
                                                       {"", "csv_empty"}};
  for (const auto& [text, code] : cases) {
    ASSERT_TRUE(base::write_file(folder / "hand.csv", text).ok());
    FollowJobOptions options;
    options.by_hand = folder / "hand.csv";
    const auto outcome = follow_job(recorded(2, [](std::int64_t) { return rows_picture(150.0); }), options);
    ASSERT_FALSE(outcome.ok()) << text;
    EXPECT_EQ(outcome.error().code, code) << text;
  }
}

// Damaged readings are readings or an error that says where.
TEST(FollowJob, DamagedReadingsByHandNeverEndTheProgram) {
  const fs::path file = fs::path(::testing::TempDir()) / "furrow_by_hand_damaged.csv";
  base::Random random(27112026);
  for (int i = 0; i < 1000; ++i) {
    const std::string text =
        testing::damaged("picture,deviation_cm,flight\na.jpg,-12.5,low\n2,7,low\n3,1e1,high\n", random);
    ASSERT_TRUE(base::write_file(file, text).ok());
    const auto readings = ByHand::read(file);
    if (!readings.ok()) {
      EXPECT_FALSE(readings.error().where.empty());
      continue;
    }
    EXPECT_FALSE(readings->flights().empty());
    EXPECT_GT(readings->missing(), 0U);
  }
  fs::remove(file);
}

Camera plain_camera() {
  Camera camera;
  camera.width = 640, camera.height = 360;
  camera.fx = camera.fy = 430.0, camera.cx = 319.5, camera.cy = 179.5;
  return camera;
}

/// What that camera sees `cross_m` left of the axis of a flat row of half width 0.5 m, alone on its field,
/// from 2 m above it.
Image row_alone(const geom::Attitude& attitude, double cross_m) {
  const Camera camera = plain_camera();
  const Eigen::Matrix3d row_from_cam = geom::cam_from_level(attitude).transpose();
  Image picture = image::make_image(camera.width, camera.height, 3);
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const Eigen::Vector3d ray =
          row_from_cam * Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
      const double y = ray.y() * 2.0 / -ray.z() + cross_m;
      const int grain = (u * 7 + v * 13) % 11;
      const bool is_leaf = ray.z() < 0.0 && std::abs(y) < 0.5;
      const auto pixel = picture.at(u, v);
      pixel[0] = static_cast<std::uint8_t>((is_leaf ? 50 : 130) + grain);
      pixel[1] = static_cast<std::uint8_t>((is_leaf ? 130 : 110) + grain);
      pixel[2] = static_cast<std::uint8_t>((is_leaf ? 40 : 85) + grain);
    }
  }
  return picture;
}

Followed follow_alone(FollowJobOptions options, double cross_m) {
  const geom::Attitude attitude{geom::deg_to_rad(2.0), geom::deg_to_rad(-45.0), 0.0};
  options.camera = plain_camera();
  options.attitude.pitch_rad = {attitude.pitch_rad, geom::deg_to_rad(0.5), 1};
  options.attitude.roll_rad = {0.0, geom::deg_to_rad(0.5), 1};
  Followed result;
  options.on_picture = [&](const FollowedPicture& picture) {
    result.pictures.push_back(picture);
    result.lines += base::to_json(followed_value(picture, true), -1) + "\n";
    return true;
  };
  auto outcome = follow_job(recorded(8, [&](std::int64_t) { return row_alone(attitude, cross_m); }), options);
  EXPECT_TRUE(outcome.ok());
  return result;
}

TEST(FollowJob, ARowAloneGivesMetresByAHeight) {
  for (const double cross_m : {-0.4, 0.0, 0.25}) {
    FollowJobOptions options;
    options.height_above_canopy_m = {2.0, 0.05, 1};
    options.field.outline_rise_m = {0.0, 0.0, 1};
    const Followed result = follow_alone(options, cross_m);
    ASSERT_EQ(result.pictures.size(), 8U);
    const follow::Following& last = result.pictures.back().following;
    ASSERT_TRUE(last.offset.has_value()) << cross_m << " " << last.hold_reason;
    EXPECT_NEAR(last.offset->value, cross_m, 0.02 + 0.1 * std::abs(cross_m))
        << cross_m;  // a round top is taken
    EXPECT_NEAR(last.offset->value, cross_m, 2.0 * last.offset->sigma) << cross_m;
    EXPECT_LT(last.offset->sigma, 0.1);
    EXPECT_NEAR(last.heading_rad->value, geom::deg_to_rad(2.0), geom::deg_to_rad(1.0));
  }
}

TEST(FollowJob, ARowAloneGivesMetresByItsHalfWidth) {
  FollowJobOptions options;
  options.field.half_width_m = {0.5, 0.05, 1};
  const Followed result = follow_alone(options, 0.25);
  const follow::Following& last = result.pictures.back().following;
  ASSERT_TRUE(last.offset.has_value()) << last.hold_reason;
  EXPECT_NEAR(last.offset->value, 0.25, 0.05);
}

// An exception that leaves a thread ends the program.
TEST(FollowJob, WhatDrawingThrowsReachesTheCaller) {
  const fs::path folder = fs::path(::testing::TempDir()) / "furrow_overlay_throws";
  fs::remove_all(folder);
  fs::create_directories(folder);
  auto writer = image::VideoWriter::create(folder / "overlay.mp4", 64, 48, 25.0);
  ASSERT_TRUE(writer.ok());
  const follow::FollowerOptions options;
  {
    OverlayVideo video(std::move(*writer), options);
    EXPECT_TRUE(video.add({image::make_image(64, 48, 1), {}, {}}).ok());  // no picture that can be drawn on
    EXPECT_THROW({ [[maybe_unused]] const Status status = video.finish(); }, base::CheckFailure);
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(FollowJob, RowsThatOverlapAreNamed) {
  FollowJobOptions options;
  options.field.row_spacing_m = {3.0, 0.06, 1};
  options.field.half_width_m = {2.5, 0.3, 1};
  for (const FollowedPicture& picture : follow_alone(options, 0.25).pictures)
    EXPECT_EQ(picture.following.sighting.status, "bad_field");
}

TEST(FollowJob, ARowAloneGivesNoMetresByASpacing) {
  FollowJobOptions options;
  options.field.row_spacing_m = {3.0, 0.06, 1};
  const Followed result = follow_alone(options, 0.25);
  for (const FollowedPicture& picture : result.pictures) {
    EXPECT_EQ(picture.following.sighting.status, "no_metres");
    EXPECT_NE(picture.following.hold_reason.find("height above the canopy"), std::string::npos);
    EXPECT_TRUE(picture.following.is_hold);
    EXPECT_TRUE(picture.following.thesis.deviation_px.has_value());  // the thesis's px need no metres
  }
  EXPECT_NE(result.lines.find("\"cross_track_m\":null"), std::string::npos);
}

}  // namespace
}  // namespace furrow::project
