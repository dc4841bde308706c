#include "furrow/target/detect.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "furrow/base/file.h"
#include "furrow/stats/robust.h"
#include "target/render_board.h"

namespace furrow::target {
namespace {

const BoardSpec kBoard{"test", 9, 6, 0.025, 1.0};

struct Scene {
  Camera camera;
  Rigid3 pose;
  Image picture;
  std::vector<Eigen::Vector2d> truth_px;
};

Scene scene(const BoardSpec& board, const Camera& camera, const Rigid3& pose) {
  Scene out{camera, pose, render_board(camera, board, pose), {}};
  for (const Eigen::Vector3d& x : corners_in_board(board))
    out.truth_px.push_back(*camera::project(camera, pose * x));
  return out;
}

double worst_px(const std::vector<Eigen::Vector2d>& a, const std::vector<Eigen::Vector2d>& b) {
  double worst = a.size() == b.size() ? 0.0 : 1e9;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    worst = std::max(worst, (a[i] - b[i]).norm());
  return worst;
}

TEST(Detect, CornersAreWhereTheyWereDrawn) {
  const Camera camera = plain_camera(640, 480, 520.0);
  for (const Eigen::Vector3d& turn :
       std::vector<Eigen::Vector3d>{{0, 0, 0}, {0.4, 0.1, 0.05}, {-0.3, 0.5, 0.3}, {0.1, -0.6, -0.2}}) {
    const Scene s = scene(kBoard, camera, facing(kBoard, 0.45, turn));
    const BoardDetection found = detect_board(s.picture, kBoard);
    ASSERT_TRUE(found.found) << found.reason;
    EXPECT_LT(worst_px(found.corners_px, s.truth_px), 0.1) << turn.transpose();
    EXPECT_EQ(found.sigma_px.size(), 54U);
  }
}

TEST(Detect, LargePictureIsRefinedAtFullSize) {
  const Camera camera = plain_camera(2000, 1500, 1600.0);
  const Scene s = scene(kBoard, camera, facing(kBoard, 0.6, {0.2, -0.3, 0.1}));
  const BoardDetection found = detect_board(s.picture, kBoard);
  ASSERT_TRUE(found.found) << found.reason;
  EXPECT_LT(worst_px(found.corners_px, s.truth_px), 0.1);
}

// Whichever way the camera is rolled, the same printed corner comes first, and x cross y points away from the
// camera.
TEST(Detect, OrderFollowsTheBoardNotThePicture) {
  const Camera camera = plain_camera(640, 480, 520.0);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const double roll = quarter * std::numbers::pi / 2 + 0.1;
    const Scene s = scene(kBoard, camera, facing(kBoard, 0.55, {0, 0, roll}));
    const BoardDetection found = detect_board(s.picture, kBoard);
    ASSERT_TRUE(found.found) << found.reason << " quarter " << quarter;
    EXPECT_LT(worst_px(found.corners_px, s.truth_px), 0.1) << "quarter " << quarter;
  }
}

// 8 x 6: half a turn looks the same, so the first corner is the one nearer to the picture's top-left.
TEST(Detect, SymmetricBoardStartsAtTheTopLeft) {
  const BoardSpec board{"even", 8, 6, 0.025, 1.0};
  const Camera camera = plain_camera(640, 480, 520.0);
  for (const double roll : {0.1, 0.1 + std::numbers::pi}) {
    const Scene s = scene(board, camera, facing(board, 0.5, {0, 0, roll}));
    const BoardDetection found = detect_board(s.picture, board);
    ASSERT_TRUE(found.found) << found.reason;
    EXPECT_LT(found.corners_px.front().sum(), found.corners_px.back().sum());
  }
}

TEST(Detect, AnotherCountOfCornersIsNotFound) {
  const Camera camera = plain_camera(640, 480, 520.0);
  const Scene s = scene(kBoard, camera, facing(kBoard, 0.5, {0.2, 0.1, 0}));
  for (const auto& [nx, ny] : {std::pair{10, 7}, {9, 5}, {8, 6}, {7, 7}, {9, 7}}) {
    const BoardDetection found = detect_board(s.picture, {"wrong", nx, ny, 0.025, 1.0});
    EXPECT_FALSE(found.found) << nx << "x" << ny;
    EXPECT_FALSE(found.reason.empty());
  }
}

TEST(Detect, BoardPartlyOutOfThePictureIsNotFound) {
  const Camera camera = plain_camera(640, 480, 520.0);
  const Scene s = scene(kBoard, camera, facing(kBoard, 0.4, {0.1, 0.1, 0}, {0.16, 0.0}));
  EXPECT_FALSE(detect_board(s.picture, kBoard).found);
}

TEST(Detect, NoBoardNoAnswerWhateverThePicture) {
  base::Random random(7);
  Image noise = image::make_image(320, 240, 3);
  for (auto& value : noise.data) value = static_cast<std::uint8_t>(random.below(256));
  Image flat = image::make_image(640, 480, 3), tiny = image::make_image(1, 1, 3),
        thin = image::make_image(4000, 3, 1);
  for (const Image& picture : {noise, flat, tiny, thin, Image{}})
    EXPECT_FALSE(detect_board(picture, kBoard).found);
}

// Why there is no board, where the picture itself is to blame.
TEST(Detect, NamesBlurredOverexposedAndDarkPictures) {
  const Scene s = scene(kBoard, plain_camera(640, 480, 520.0), facing(kBoard, 0.8, {0.1, 0.2, 0.1}));
  EXPECT_EQ(detect_board(s.picture, {"other", 5, 5, 0.025, 1.0}).reason.find("blurred"), std::string::npos);
  Image blurred = s.picture, white = s.picture, dark = s.picture;
  for (int i = 0; i < 60; ++i) blurred = softened(blurred);
  for (auto& level : white.data) level = static_cast<std::uint8_t>(std::min(255, level + 160));
  for (auto& level : dark.data) level = static_cast<std::uint8_t>(level / 40);
  EXPECT_NE(detect_board(blurred, kBoard).reason.find("blurred: its sharpest edges"), std::string::npos)
      << detect_board(blurred, kBoard).reason;
  EXPECT_NE(detect_board(white, kBoard).reason.find("overexposed"), std::string::npos)
      << detect_board(white, kBoard).reason;
  EXPECT_NE(detect_board(dark, kBoard).reason.find("too dark"), std::string::npos)
      << detect_board(dark, kBoard).reason;
}

// The claimed sigma against the scatter of re-noised pictures. The claim leaves out rounding and the
// interpolation's smoothing.
TEST(Detect, ClaimedSigmaIsTheScatterOfNoisyPictures) {
  const Camera camera = plain_camera(480, 360, 400.0);
  const BoardSpec board{"small", 5, 4, 0.025, 1.0};
  const Scene s = scene(board, camera, facing(board, 0.3, {0.3, -0.2, 0.1}));
  constexpr double kNoiseGrey = 2.0;
  constexpr int kTrials = 60;
  std::vector<std::vector<double>> u(20);
  std::vector<double> claimed(20, 0.0);
  for (int trial = 0; trial < kTrials; ++trial) {
    const BoardDetection found =
        detect_board(with_noise(s.picture, kNoiseGrey, 100 + static_cast<std::uint64_t>(trial)), board);
    ASSERT_TRUE(found.found) << found.reason;
    for (std::size_t i = 0; i < 20; ++i) {
      u[i].push_back(found.corners_px[i].x());
      claimed[i] += found.sigma_px[i] / kTrials;
    }
  }
  std::vector<double> ratio;
  for (std::size_t i = 0; i < 20; ++i) ratio.push_back(claimed[i] / stats::standard_deviation(u[i]));
  EXPECT_GT(stats::median(ratio), 0.85);
  EXPECT_LT(stats::median(ratio), 1.18);
}

class DetectFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("furrow_detect_test_" + std::to_string(std::rand()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  /// Pictures of a board turned about x by each of these, in files of the folder.
  std::vector<std::filesystem::path> photograph(const BoardSpec& board, double distance_m,
                                                const std::vector<double>& turns_rad) const {
    const Camera camera = plain_camera(640, 480, 520.0);
    std::vector<std::filesystem::path> files;
    for (const double turn : turns_rad) {
      files.push_back(folder_ / (std::to_string(files.size()) + ".png"));
      const Image picture = render_board(camera, board, facing(board, distance_m, {turn, 0.1, 0}), 2);
      EXPECT_TRUE(image::write_image(files.back(), picture).ok());
    }
    return files;
  }
  std::filesystem::path folder_;
};

TEST_F(DetectFiles, NamesCopiesStraysAndRubbish) {
  const Camera camera = plain_camera(640, 480, 520.0);
  const Image one = render_board(camera, kBoard, facing(kBoard, 0.5, {0.1, 0, 0}), 2);
  const Image two = render_board(camera, kBoard, facing(kBoard, 0.5, {0, 0.3, 0}), 2);
  const Image stray =
      render_board(plain_camera(641, 481, 520.0), kBoard, facing(kBoard, 0.5, {0, 0.3, 0}), 2);
  for (const auto& [name, picture] :
       {std::pair{"a b.png", &one}, {"b.png", &two}, {"c.png", &one}, {"d.png", &stray}}) {
    ASSERT_TRUE(image::write_image(folder_ / name, *picture).ok());
  }
  ASSERT_TRUE(base::write_file(folder_ / "e.jpg", "not a picture").ok());
  std::vector<std::filesystem::path> files;
  for (const char* name : {"a b.png", "b.png", "c.png", "d.png", "e.jpg", "f.jpg"})
    files.push_back(folder_ / name);
  std::size_t last = 0;
  const auto found =
      detect_boards(files, kBoard, {}, 2, [&](const base::ProgressEvent& e) { last = e.done; });
  ASSERT_EQ(found.size(), 6U);
  EXPECT_EQ(last, 6U);
  EXPECT_TRUE(found[0].found) << found[0].reason;
  EXPECT_EQ(found[0].image, "a b.png");
  EXPECT_TRUE(found[1].found) << found[1].reason;
  EXPECT_EQ(found[2].reason, "byte-identical to a b.png");
  EXPECT_FALSE(found[2].found);
  EXPECT_NE(found[3].reason.find("641x481"), std::string::npos);
  EXPECT_NE(found[4].reason.find("unreadable"), std::string::npos);
  EXPECT_NE(found[5].reason.find("unreadable"), std::string::npos);
  const auto again = detect_boards(files, kBoard, {}, 1);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].corners_px, again[i].corners_px);
}

TEST_F(DetectFiles, TellsPicturesOfOneNameApart) {
  const auto files = photograph(kBoard, 0.5, {0.0, 0.3});
  std::vector<std::filesystem::path> twins;
  for (std::size_t i = 0; i < 2; ++i) {
    twins.push_back(folder_ / (i == 0 ? "left" : "right") / "my board.png");
    std::filesystem::create_directories(twins[i].parent_path());
    std::filesystem::copy_file(files[i], twins[i], std::filesystem::copy_options::overwrite_existing);
  }
  const auto found = detect_boards(twins, kBoard);
  EXPECT_EQ(found[0].image, "left/my board.png");
  EXPECT_EQ(found[1].image, "right/my board.png");
  EXPECT_TRUE(found[0].found && found[1].found);
}

/// A JPEG that asks to be turned: an EXIF segment of one directory with one entry (EXIF 2.3, section 4).
std::string asking_for_a_turn(const std::string& jpeg, char orientation, bool big_endian) {
  const std::string exif = big_endian
                               ? std::string("MM\0\x2A\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 19) +
                                     orientation + std::string("\0\0\0\0\0\0", 6)
                               : std::string("II\x2A\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18) +
                                     orientation + std::string("\0\0\0\0\0\0\0", 7);
  const std::string body = std::string("Exif\0\0", 6) + exif;
  const std::string length{static_cast<char>((body.size() + 2) >> 8U), static_cast<char>(body.size() + 2)};
  return jpeg.substr(0, 2) + "\xFF\xE1" + length + body + jpeg.substr(2);
}

// A camera belongs to the sensor's own pixels, however the picture wants to be shown.
TEST_F(DetectFiles, TurnsNoPictureThatAsksForIt) {
  const Image picture =
      render_board(plain_camera(640, 480, 520.0), kBoard, facing(kBoard, 0.5, {0.1, 0.2, 0}), 2);
  const std::string plain = image::encode_image(picture, ".jpg");
  EXPECT_EQ(image::exif_orientation(plain), 1);
  EXPECT_EQ(image::exif_orientation("\xFF\xD8\xFF\xE1"), 1);
  std::vector<std::filesystem::path> files{folder_ / "plain.jpg", folder_ / "big.jpg",
                                           folder_ / "little.jpg"};
  ASSERT_TRUE(base::write_file(files[0], plain).ok());
  ASSERT_TRUE(base::write_file(files[1], asking_for_a_turn(plain, '\6', true)).ok());
  ASSERT_TRUE(base::write_file(files[2], asking_for_a_turn(plain, '\3', false)).ok());
  const auto found = detect_boards(files, kBoard);
  EXPECT_EQ(found[0].exif_orientation, 1);
  EXPECT_EQ(found[1].exif_orientation, 6);
  EXPECT_EQ(found[2].exif_orientation, 3);
  for (const BoardDetection& one : found) {
    ASSERT_TRUE(one.found) << one.image << ": " << one.reason;
    EXPECT_EQ(one.width, 640);
    EXPECT_EQ(one.corners_px, found[0].corners_px);
  }
}

/// A grey PNM of 16 bits a value, `gain` times the picture's levels.
std::string sixteen_bits(const Image& grey, int gain) {
  std::string out = "P5\n" + std::to_string(grey.width) + " " + std::to_string(grey.height) + "\n65535\n";
  for (const std::uint8_t level : grey.data) {
    const int value = level * gain;
    out += static_cast<char>(static_cast<unsigned char>(value >> 8));
    out += static_cast<char>(static_cast<unsigned char>(value & 0xFF));
  }
  return out;
}

// Of 16 bits all are used, or, as sensors of 12 bits do it, only the lower ones.
TEST_F(DetectFiles, ReadsGreyPicturesOfSixteenBits) {
  const Image picture = image::to_grey(
      render_board(plain_camera(640, 480, 520.0), kBoard, facing(kBoard, 0.5, {0.1, 0.2, 0}), 2));
  ASSERT_EQ(picture.channels, 1);
  std::vector<std::filesystem::path> files{folder_ / "8.png", folder_ / "16.pgm", folder_ / "12.pgm"};
  ASSERT_TRUE(image::write_image(files[0], picture).ok());
  ASSERT_TRUE(base::write_file(files[1], sixteen_bits(picture, 257)).ok());
  ASSERT_TRUE(base::write_file(files[2], sixteen_bits(picture, 16)).ok());
  const auto found = detect_boards(files, kBoard);
  for (const BoardDetection& one : found) {
    ASSERT_TRUE(one.found) << one.image << ": " << one.reason;
    for (std::size_t c = 0; c < one.corners_px.size(); ++c)
      EXPECT_LT((one.corners_px[c] - found[0].corners_px[c]).norm(), 0.02) << one.image;
  }
}

TEST_F(DetectFiles, CountsCornersOfAnUnknownBoard) {
  const auto files = photograph(kBoard, 0.5, {0.0, 0.3, -0.4});
  const auto guesses = guess_boards(files);
  ASSERT_FALSE(guesses.empty());
  EXPECT_EQ(guesses[0].corners_x, 9);
  EXPECT_EQ(guesses[0].corners_y, 6);
  EXPECT_EQ(guesses[0].pictures, 3);
  EXPECT_EQ(explain_board(kBoard, guesses), "");
  EXPECT_EQ(explain_board({"swapped", 6, 9, 0.025, 1.0}, guesses), "");
  EXPECT_NE(explain_board({"squares", 10, 7, 0.025, 1.0}, guesses).find("counts the squares"),
            std::string::npos);
  EXPECT_NE(explain_board({"other", 8, 6, 0.025, 1.0}, guesses).find("[9, 6]"), std::string::npos);
  EXPECT_TRUE(guess_boards({folder_ / "none.png"}).empty());
}

TEST_F(DetectFiles, CheckSaysWhichDescriptionFits) {
  const auto files = photograph(kBoard, 0.5, {0.0, 0.3, -0.4});
  const auto verdict = [&](int x, int y) {
    const BoardCheck check = check_board(files, {"b", x, y, 0.025, 1.0});
    EXPECT_EQ(check.fits, check.found == 3) << check.verdict;
    return check.verdict;
  };
  EXPECT_NE(verdict(9, 6).find("fits 3 of 3"), std::string::npos);
  EXPECT_NE(verdict(6, 9).find("fits 3 of 3"), std::string::npos);  // the same board, counted the other way
  EXPECT_NE(verdict(10, 7).find("counts the squares"), std::string::npos) << verdict(10, 7);
  EXPECT_NE(verdict(9, 7).find("corners: [9, 6] fits 3"), std::string::npos) << verdict(9, 7);
}

TEST_F(DetectFiles, CheckSaysWhichMarkersFit) {
  BoardSpec board{"c", 10, 7, 0.022, 1.0, BoardKind::charuco};
  board.marker_m = 0.016;
  board.dictionary = "5x5_50";
  const auto files = photograph(board, 0.3, {0.1, -0.3});
  EXPECT_TRUE(check_board(files, board).fits);
  BoardSpec swapped = board;
  std::swap(swapped.corners_x, swapped.corners_y);
  EXPECT_NE(check_board(files, swapped).verdict.find("squares: [11, 8] fits"), std::string::npos)
      << check_board(files, swapped).verdict;
  BoardSpec other = board;
  other.dictionary = "6x6_250";
  EXPECT_NE(check_board(files, other).verdict.find("markers of 5x5_50 show"), std::string::npos)
      << check_board(files, other).verdict;
}

// Every picture that Debian ships shows the whole 9 x 6 board.
TEST(DetectReal, AllOfOpenCvsOwnPictures) {
  const std::filesystem::path folder = "/usr/share/doc/opencv-doc/examples/data";
  if (!std::filesystem::exists(folder / "left01.jpg"))
    GTEST_SKIP() << "no pictures in " << folder << " (install opencv-doc)";
  for (const char* side : {"left??.jpg", "right??.jpg"}) {
    const auto files = base::expand_pattern(side, folder);
    ASSERT_TRUE(files.ok());
    for (const BoardDetection& one : detect_boards(*files, kBoard))
      EXPECT_TRUE(one.found) << one.image << ": " << one.reason;
  }
}

}  // namespace
}  // namespace furrow::target
