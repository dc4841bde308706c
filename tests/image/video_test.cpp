#include "furrow/image/video.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

#include "furrow/base/file.h"
#include "furrow/base/random.h"
#include "furrow/image/draw.h"
#include "image/matroska.h"

namespace furrow::image {
namespace {

namespace fs = std::filesystem;

class Video : public ::testing::Test {
 protected:
  void SetUp() override {
    folder = fs::path(::testing::TempDir()) / "furrow_video";
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  fs::path folder;
};

/// A picture whose grey level says which one it is.
Image numbered(int i, int width = 64, int height = 48) {
  Image picture = make_image(width, height, 3);
  std::fill(picture.data.begin(), picture.data.end(), static_cast<std::uint8_t>(20 + 8 * i));
  return picture;
}

std::vector<TimedPicture> all_of(PictureSource& source) {
  std::vector<TimedPicture> pictures;
  while (auto picture = source.next()) pictures.push_back(std::move(*picture));
  return pictures;
}

std::string write_video(const fs::path& file, int pictures, double rate_hz) {
  auto writer = VideoWriter::create(file, 64, 48, rate_hz);
  EXPECT_TRUE(writer.ok());
  for (int i = 0; i < pictures; ++i)
    EXPECT_TRUE(writer->add(numbered(i), base::seconds_to_ns(i / rate_hz)).ok());
  EXPECT_FALSE(fs::exists(file));
  EXPECT_TRUE(writer->finish().ok());
  return file.string();
}

std::string said(const PictureSource& source) {
  std::string all;
  for (const std::string& sentence : source.trouble()) all += sentence + "\n";
  return all;
}

TEST_F(Video, PicturesComeInOrderWithTheirTimes) {
  for (const char* name : {"a.mkv", "a.mp4"}) {
    const auto source = open_source(write_video(folder / name, 12, 25.0));
    ASSERT_TRUE(source.ok()) << name;
    EXPECT_EQ((*source)->info().kind, SourceKind::video);
    EXPECT_NEAR((*source)->info().nominal_rate_hz, 25.0, 1e-6);
    const auto pictures = all_of(**source);
    ASSERT_EQ(pictures.size(), 12U) << name;
    for (int i = 0; i < 12; ++i) {
      const TimedPicture& one = pictures[static_cast<std::size_t>(i)];
      EXPECT_EQ(one.index, i);
      EXPECT_NEAR(base::ns_to_seconds(one.t_video_ns), i / 25.0, 1e-3) << name << i;
      EXPECT_NEAR(*one.picture.at(32, 24), 20 + 8 * i, 6) << name << i;
    }
    EXPECT_EQ(pictures[3].name, "picture 4");
    EXPECT_EQ(said(**source), "") << name;
  }
}

TEST_F(Video, PicturesKeepTheTimesTheyWereWrittenWith) {
  constexpr int kHeldBack = 16;  // the last pictures come out of a decoder without their times
  for (const char* name : {"vfr.mkv", "vfr.mp4"}) {
    auto writer = VideoWriter::create(folder / name, 64, 48, 25.0);
    ASSERT_TRUE(writer.ok());
    std::vector<double> times_s = {0.0};
    for (int i = 0; i < 40; ++i) {
      ASSERT_TRUE(writer->add(numbered(i % 20), base::seconds_to_ns(times_s.back())).ok());
      times_s.push_back(times_s.back() + (i % 3 == 0 ? 0.3 : 0.03));
    }
    ASSERT_TRUE(writer->finish().ok());
    const auto source = open_source((folder / name).string());
    ASSERT_TRUE(source.ok());
    const auto read = all_of(**source);
    ASSERT_EQ(read.size(), 40U) << name;
    for (std::size_t i = 0; i + kHeldBack < 40; ++i)
      EXPECT_NEAR(base::ns_to_seconds(read[i].t_video_ns), times_s[i], 1e-3) << name << i;
  }
}

// A limit on the size of files stands for a full disk.
TEST_F(Video, AFullDiskIsSaid) {
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  auto writer = VideoWriter::create(folder / "full.mp4", 320, 240, 25.0);
  ASSERT_TRUE(writer.ok());
  const auto old = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{100'000, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  base::Random random(11);
  Image noise = make_image(320, 240, 3);
  Status written = Done{};
  for (int i = 0; i < 50 && written.ok(); ++i) {
    for (std::uint8_t& value : noise.data) value = static_cast<std::uint8_t>(random.below(256));
    written = writer->add(noise, base::seconds_to_ns(i / 25.0));
  }
  if (written.ok()) written = writer->finish();
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, "file_unwritable");
}

TEST_F(Video, TheContainersOwnTimesAreTaken) {
  const std::vector<int> times_ms = {100, 140, 150, 400, 410, 1000};
  std::vector<Image> pictures;
  for (int i = 0; i < 6; ++i) pictures.push_back(numbered(i));
  ASSERT_TRUE(base::write_file(folder / "vfr.mkv", matroska::video(pictures, times_ms)).ok());
  const auto source = open_source((folder / "vfr.mkv").string());
  ASSERT_TRUE(source.ok()) << source.error().message();
  const auto read = all_of(**source);
  ASSERT_EQ(read.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(base::ns_to_seconds(read[i].t_video_ns), 1e-3 * (times_ms[i] - times_ms[0]), 1e-3) << i;
}

TEST_F(Video, TimesThatStandStillAreMadeUpAndSaid) {
  std::vector<int> times_ms(30, 40);
  times_ms[0] = 0;
  const std::vector<Image> pictures(30, numbered(1));
  ASSERT_TRUE(base::write_file(folder / "still.mkv", matroska::video(pictures, times_ms)).ok());
  const auto source = open_source((folder / "still.mkv").string());
  ASSERT_TRUE(source.ok());
  const auto read = all_of(**source);
  for (std::size_t i = 1; i < read.size(); ++i) EXPECT_GT(read[i].t_video_ns, read[i - 1].t_video_ns);
  EXPECT_EQ(read.size(), 30U);
  EXPECT_NE(said(**source).find("no time of their own"), std::string::npos);
}

TEST_F(Video, AVideoCutShortGivesWhatItHasAndSaysSo) {
  const std::string whole = base::read_file(write_video(folder / "a.mkv", 40, 25.0)).value();
  ASSERT_TRUE(base::write_file(folder / "cut.mkv", whole.substr(0, whole.size() / 2)).ok());
  const auto source = open_source((folder / "cut.mkv").string());
  ASSERT_TRUE(source.ok());
  const auto read = all_of(**source);
  EXPECT_GT(read.size(), 5U);
  EXPECT_LT(read.size(), 38U);
  EXPECT_NE(said(**source).find("cut short"), std::string::npos) << read.size();
  EXPECT_FALSE((*source)->failed());
}

// Whatever happens to the bytes: pictures or an error, and an end.
TEST_F(Video, CutAndFlippedFilesEnd) {
  base::Random random(7);
  for (const char* name : {"a.mkv", "a.mp4"}) {
    const std::string whole = base::read_file(write_video(folder / name, 8, 25.0)).value();
    for (int trial = 0; trial < 40; ++trial) {
      std::string bytes =
          whole.substr(0, trial % 2 == 0 ? random.below(static_cast<std::uint32_t>(whole.size()))
                                         : static_cast<std::uint32_t>(whole.size()));
      for (int flip = 0; flip < 20 && !bytes.empty() && trial % 2 == 1; ++flip)
        bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^=
            static_cast<char>(1U << random.below(8));
      const fs::path file = folder / (std::string("broken_") + name);
      ASSERT_TRUE(base::write_file(file, bytes).ok());
      auto source = open_source(file.string());
      if (!source.ok()) {
        EXPECT_EQ(source.error().code, "source_unreadable");
        continue;
      }
      int count = 0;
      while ((*source)->next() && count < 1000) ++count;
      EXPECT_LT(count, 1000);
    }
  }
}

TEST_F(Video, AFolderGoesOnOverWhatIsNoPicture) {
  ASSERT_TRUE(write_image(folder / "b2.png", numbered(1)).ok());
  ASSERT_TRUE(write_image(folder / "b10.png", numbered(2, 32, 24)).ok());
  ASSERT_TRUE(base::write_file(folder / "b3.jpg", "no picture").ok());
  ASSERT_TRUE(base::write_file(folder / "notes.txt", "no picture either").ok());
  SourceOptions options;
  options.assumed_rate_hz = 4.0;
  const auto source = open_source(folder.string(), options);
  ASSERT_TRUE(source.ok());
  const auto pictures = all_of(**source);
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(pictures[0].name, "b2.png");
  EXPECT_EQ(pictures[1].name, "b3.jpg");
  ASSERT_TRUE(pictures[1].error.has_value());
  EXPECT_EQ(pictures[1].error->code, "picture_unreadable");
  EXPECT_EQ(pictures[1].error->where, "b3.jpg");
  EXPECT_EQ(pictures[2].picture.width, 32);
  EXPECT_EQ(pictures[2].t_video_ns, base::seconds_to_ns(0.5));
  EXPECT_NE(said(**source).find("4 a second assumed"), std::string::npos);
  EXPECT_EQ((*open_source((folder / "b*.png").string()))->info().count, 2);
}

TEST_F(Video, NamesThatTheFileSystemRefusesAreForTheReader) {
  fs::create_symlink("self.png", folder / "self.png");
  const auto in_folder = picture_files({folder});
  ASSERT_TRUE(in_folder.ok());
  EXPECT_EQ(in_folder->size(), 1U);
  const fs::path too_long = folder / std::string(300, 'x');
  const fs::path long_pattern = folder / (std::string(300, 'x') + "*");
  const auto alone = picture_files({too_long});
  ASSERT_TRUE(alone.ok());
  EXPECT_EQ(alone->front(), too_long);
  ASSERT_FALSE(picture_files({long_pattern}).ok());
  EXPECT_EQ(picture_files({long_pattern}).error().code, "no_match");
}

TEST_F(Video, APatternInAFoldersNameIsSaid) {
  fs::create_directories(folder / "flight1");
  ASSERT_TRUE(write_image(folder / "flight1" / "a.png", make_image(8, 8, 3)).ok());
  const auto named = picture_files({folder / "flight*" / "a.png"});
  ASSERT_FALSE(named.ok());
  EXPECT_EQ(named.error().code, "no_match");
  EXPECT_NE(named.error().message().find("last part"), std::string::npos);
}

TEST_F(Video, NamesWhatCannotBeOpened) {
  EXPECT_EQ(open_source((folder / "none.mp4").string()).error().code, "source_missing");
  EXPECT_EQ(open_source(folder.string()).error().code, "no_match");
  EXPECT_EQ(open_source("/dev/video97").error().code, "source_unreadable");
  EXPECT_EQ(open_source("97").error().code, "source_unreadable");
  EXPECT_EQ(open_source("/dev/null").error().code, "source_unreadable");
  ASSERT_TRUE(base::write_file(folder / "text.mp4", "no video").ok());
  EXPECT_EQ(open_source((folder / "text.mp4").string()).error().code, "source_unreadable");
  ASSERT_TRUE(base::write_file(folder / "empty.mkv", "").ok());
  EXPECT_EQ(open_source((folder / "empty.mkv").string()).error().code, "source_unreadable");
}

// Opening a pipe that nobody writes to would wait for ever.
TEST_F(Video, APipeIsRefusedAtOnce) {
  ASSERT_EQ(::mkfifo((folder / "camera").c_str(), 0600), 0);
  EXPECT_EQ(open_source((folder / "camera").string()).error().code, "source_unreadable");
}

// A stream that stops is a camera that went away, however many pictures came.
TEST_F(Video, ALiveSourceThatEndsHasFailed) {
  const std::string file = write_video(folder / "a.mp4", 12, 25.0);
  const auto source = open_source("file://" + file);
  ASSERT_TRUE(source.ok()) << source.error().message();
  EXPECT_EQ((*source)->info().kind, SourceKind::live);
  EXPECT_FALSE((*source)->failed());
  EXPECT_EQ(all_of(**source).size(), 12U);
  EXPECT_TRUE((*source)->failed());
  EXPECT_NE(said(**source).find("unplugged"), std::string::npos);
}

TEST_F(Video, AnUnfinishedVideoLeavesNothing) {
  {
    auto writer = VideoWriter::create(folder / "half.mp4", 64, 48, 25.0);
    ASSERT_TRUE(writer.ok());
    EXPECT_TRUE(writer->add(numbered(1), 0).ok());
  }
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(Video, TheSamePicturesGiveTheSameBytes) {
  EXPECT_EQ(base::read_file(write_video(folder / "a.mp4", 10, 25.0)).value(),
            base::read_file(write_video(folder / "b.mp4", 10, 25.0)).value());
}

TEST_F(Video, APictureOfAnotherSizeIsFittedIn) {
  auto writer = VideoWriter::create(folder / "mixed.mkv", 65, 47, 25.0);
  ASSERT_TRUE(writer.ok());
  EXPECT_TRUE(writer->add(numbered(3), 0).ok());
  EXPECT_TRUE(writer->add(numbered(3, 640, 100), base::seconds_to_ns(0.04)).ok());
  EXPECT_TRUE(writer->add(numbered(3, 10, 10), base::seconds_to_ns(0.08)).ok());
  ASSERT_TRUE(writer->finish().ok());
  const auto source = open_source((folder / "mixed.mkv").string());
  ASSERT_TRUE(source.ok());
  EXPECT_EQ(all_of(**source).size(), 3U);
}

TEST(Draw, InkIsWhereItWasAskedFor) {
  const Image drawn = inked(numbered(5), {{{{10.0, 0.0}, {10.0, 47.0}}, {0, 200, 0}, 1.0}}, {});
  EXPECT_GT(drawn.at(10, 24)[1], 150);  // its border is smoothed
  EXPECT_EQ(*drawn.at(40, 24), 60);
  // Far outside and not a number: nothing happens.
  const Image far =
      inked(numbered(5), {{{{-1e9, 1e12}, {1e300, 0.0}}, {0, 200, 0}, 1.0}}, {{{900.0, 900.0}, "x"}});
  EXPECT_EQ(far.width, 64);
}

}  // namespace
}  // namespace furrow::image
