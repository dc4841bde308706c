// Copies of pictures that are worse than the pictures: the board is found where it was, or not at all.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>

#include "furrow/base/file.h"
#include "furrow/target/detect.h"
#include "target/render_board.h"

namespace furrow::target {
namespace {

using Place = std::function<Eigen::Vector2d(const Eigen::Vector2d&)>;

struct Copy {
  std::string name;
  Image picture;
  Place place;  ///< where a point of the picture is in the copy
};

Image turned_quarter(const Image& in) {
  Image out = image::make_image(in.height, in.width, in.channels);
  for (int v = 0; v < in.height; ++v) {
    for (int u = 0; u < in.width; ++u) std::copy_n(in.at(u, v), in.channels, out.at(in.height - 1 - v, u));
  }
  return out;
}

Image half_covered(Image in) {
  for (int v = 0; v < in.height; ++v) std::fill_n(in.at(0, v), in.width / 2 * in.channels, std::uint8_t{110});
  return in;
}

std::vector<Copy> copies_of(const Image& grey) {
  const double w = grey.width, h = grey.height;
  const Place same = [](const Eigen::Vector2d& p) { return p; };
  const auto scaled = [](double s) {
    return [s](const Eigen::Vector2d& p) { return Eigen::Vector2d((p.array() + 0.5) * s - 0.5); };
  };
  Image blurred = grey;
  for (int i = 0; i < 6; ++i) blurred = softened(blurred);
  const Image quarter = turned_quarter(grey);
  std::vector<Copy> out{
      {"blurred", blurred, same},
      {"noisy", with_noise(grey, 20.0, 5), same},
      {"half size", image::resize(grey, grey.width / 2, grey.height / 2), scaled(0.5)},
      {"a quarter turned", quarter,
       [h](const Eigen::Vector2d& p) { return Eigen::Vector2d(h - 1 - p.y(), p.x()); }},
      {"half turned", turned_quarter(quarter),
       [w, h](const Eigen::Vector2d& p) { return Eigen::Vector2d(w - 1 - p.x(), h - 1 - p.y()); }},
      {"half covered", half_covered(grey), same}};
  constexpr int kLargestDoubled =
      1300;  // a 5-megapixel picture doubled tells nothing that a small one does not
  if (grey.width <= kLargestDoubled)
    out.push_back({"double size", image::resize(grey, 2 * grey.width, 2 * grey.height), scaled(2.0)});
  return out;
}

/// Largest distance from a found corner to the nearest true one: whichever end the copy is counted from.
double worst_px(const std::vector<Eigen::Vector2d>& found, const std::vector<Eigen::Vector2d>& truth,
                const Place& place) {
  double worst = 0.0;
  for (const Eigen::Vector2d& p : found) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& q : truth) nearest = std::min(nearest, (place(q) - p).norm());
    worst = std::max(worst, nearest);
  }
  return worst;
}

/// How many of the copies show the board; fails the test where one shows another.
int found_in_copies(const Image& picture, const BoardSpec& board, const std::string& name) {
  const Image grey = image::to_grey(picture);
  const BoardDetection original = detect_board(grey, board);
  if (!original.found) return 0;
  int count = 0;
  for (const Copy& copy : copies_of(grey)) {
    const BoardDetection found = detect_board(copy.picture, board);
    if (!found.found) continue;
    ++count;
    // A grid that is off lies a square off; noise of 20 grey levels and half the size move a corner by a
    // pixel or two.
    EXPECT_LT(worst_px(found.corners_px, original.corners_px, copy.place), 3.0) << name << ", " << copy.name;
    const auto& corners = original.corners_px;
    const bool covered =
        std::any_of(corners.begin(), corners.end(), [&](const auto& p) { return p.x() < grey.width / 2; });
    EXPECT_FALSE(copy.name == "half covered" && covered) << name << ": a whole board in half a picture";
  }
  return count;
}

TEST(Perturbed, RenderedBoardIsFoundWhereItWas) {
  const BoardSpec board{"test", 9, 6, 0.025, 1.0};
  const Image picture =
      render_board(plain_camera(640, 480, 520.0), board, facing(board, 0.5, {0.2, -0.3, 0.1}));
  EXPECT_GE(found_in_copies(picture, board, "rendered"), 5);
}

struct Set {
  const char* name;
  const char* pattern;
  int corners_x, corners_y;
};

class PerturbedSets : public ::testing::TestWithParam<Set> {};

TEST_P(PerturbedSets, NoWrongGrid) {
  const char* set = std::getenv("FURROW_DATA");
  const std::filesystem::path data =
      set != nullptr ? set : std::filesystem::path(FURROW_SOURCE_DIR) / "../shared/data";
  const auto files = base::expand_pattern(GetParam().pattern, data);
  if (!files.ok()) GTEST_SKIP() << "no pictures: " << files.error().message() << " (set FURROW_DATA)";
  const BoardSpec board{GetParam().name, GetParam().corners_x, GetParam().corners_y, 0.025, 1.0};
  // A few of each set, from all over it: each picture is looked at eight times.
  constexpr std::size_t kMost = 3;
  int count = 0;
  for (std::size_t i = 0; i < std::min(kMost, files->size()); ++i) {
    const auto& file = (*files)[i * files->size() / kMost];
    const auto picture = image::read_image(file);
    ASSERT_TRUE(picture.ok()) << picture.error().message();
    count += found_in_copies(*picture, board, file.filename().string());
  }
  EXPECT_GE(count, 3) << "a quarter and a half turn at least leave the board whole";
}

INSTANTIATE_TEST_SUITE_P(
    Target, PerturbedSets,
    ::testing::Values(Set{"opencv_left", "/usr/share/doc/opencv-doc/examples/data/left??.jpg", 9, 6},
                      Set{"sourishg", "calib/sourishg-left/images/*.jpg", 9, 6},
                      Set{"sony", "calib/boofcv-sony-hx5v/images/*.jpg", 6, 4},
                      Set{"bumblebee", "calib/boofcv-bumblebee2-left/images/*.jpg", 6, 4},
                      Set{"gopro", "calib/gopro-hero4-udacity/images/*.jpg", 8, 6},
                      Set{"mini_se", "flights/mini-se/checkerboard/*.jpg", 9, 6}),
    [](const auto& one) { return std::string(one.param.name); });

}  // namespace
}  // namespace furrow::target
