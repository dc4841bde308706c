#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "furrow/base/file.h"
#include "furrow/target/detect.h"
#include "target/markers.h"
#include "target/render_board.h"

namespace furrow::target {
namespace {

BoardSpec board_named(const std::string& name) {
  const auto board =
      read_board(std::filesystem::path(FURROW_SOURCE_DIR) / "calib_targets" / (name + ".yaml"));
  check(board.ok(), "a board of calib_targets");
  return *board;
}

/// Largest distance of a found corner from its true place; infinite when an id is wrong.
double worst_px(const BoardDetection& found, const BoardSpec& board, const Camera& camera,
                const Rigid3& pose) {
  const auto corners = corners_in_board(board);
  double worst = 0.0;
  for (std::size_t c = 0; c < found.corners_px.size(); ++c) {
    const auto truth =
        camera::project(camera, pose * corners.at(static_cast<std::size_t>(found.corner_ids.at(c))));
    worst = std::max(worst, truth ? (found.corners_px[c] - *truth).norm() : 1e9);
  }
  return worst;
}

struct Case {
  const char* board;
  double distance_m;
};

class MarkerBoards : public ::testing::TestWithParam<Case> {};

TEST_P(MarkerBoards, WholeBoardGivesEveryCorner) {
  const BoardSpec board = board_named(GetParam().board);
  const Camera camera = plain_camera(960, 720, 800.0);
  for (const Eigen::Vector3d& turn :
       std::vector<Eigen::Vector3d>{{0, 0, 0}, {0.4, 0.1, 0.6}, {-0.3, 0.4, 2.9}}) {
    const Rigid3 pose = facing(board, 1.35 * GetParam().distance_m, turn);
    const BoardDetection found = detect_board(render_board(camera, board, pose), board);
    ASSERT_TRUE(found.found) << found.reason;
    // A corner in a hundred may lie a little aside.
    EXPECT_GE(100 * found.corner_ids.size(), 99 * static_cast<std::size_t>(board.corners_x * board.corners_y))
        << turn.transpose();
    EXPECT_LT(worst_px(found, board, camera, pose), 0.15) << turn.transpose();
    EXPECT_EQ(found.sigma_px.size(), found.corners_px.size());
  }
}

TEST_P(MarkerBoards, APartOutOfThePictureGivesWhatItShows) {
  const BoardSpec board = board_named(GetParam().board);
  const Camera camera = plain_camera(960, 720, 800.0);
  const double d = GetParam().distance_m;
  const Rigid3 pose = facing(board, 0.8 * d, {0.2, -0.3, 0.4}, {0.35 * d, 0.2 * d});
  const BoardDetection found = detect_board(render_board(camera, board, pose), board);
  ASSERT_TRUE(found.found) << found.reason;
  EXPECT_GE(found.corner_ids.size(), 8U);
  EXPECT_LT(found.corner_ids.size(), static_cast<std::size_t>(board.corners_x * board.corners_y));
  EXPECT_TRUE(std::is_sorted(found.corner_ids.begin(), found.corner_ids.end()));
  EXPECT_LT(worst_px(found, board, camera, pose), 0.2);
}

// Something grey lies over the middle: what it hides is left out, and no corner moves to its edge.
TEST_P(MarkerBoards, NoCornerOnWhatLiesBeforeTheBoard) {
  const BoardSpec board = board_named(GetParam().board);
  const Camera camera = plain_camera(960, 720, 800.0);
  const Rigid3 pose = facing(board, 1.3 * GetParam().distance_m, {0.1, 0.2, 0.1});
  Image picture = render_board(camera, board, pose);
  for (int v = 300; v < 470; ++v) {
    for (int u = 390 + v / 9; u < 590; ++u) *picture.at(u, v) = 90;
  }
  const BoardDetection found = detect_board(picture, board);
  ASSERT_TRUE(found.found) << found.reason;
  EXPECT_LT(found.corner_ids.size(), static_cast<std::size_t>(board.corners_x * board.corners_y));
  EXPECT_LT(worst_px(found, board, camera, pose), 0.5);
}

TEST_P(MarkerBoards, LargePictureIsRefinedAtFullSize) {
  const BoardSpec board = board_named(GetParam().board);
  const Camera camera = plain_camera(2400, 1800, 2000.0);
  const Rigid3 pose = facing(board, 1.35 * GetParam().distance_m, {0.2, 0.2, 0.1});
  const BoardDetection found = detect_board(render_board(camera, board, pose, 3), board);
  ASSERT_TRUE(found.found) << found.reason;
  EXPECT_LT(worst_px(found, board, camera, pose), 0.15);
}

TEST_P(MarkerBoards, NoBoardNoAnswer) {
  const BoardSpec board = board_named(GetParam().board);
  base::Random random(7);
  Image noise = image::make_image(320, 240, 1);
  for (auto& value : noise.data) value = static_cast<std::uint8_t>(random.below(256));
  for (const Image& picture : {noise, image::make_image(640, 480, 3), image::make_image(1, 1, 3),
                               image::make_image(4000, 3, 1), Image{}}) {
    const BoardDetection found = detect_board(picture, board);
    EXPECT_FALSE(found.found);
    EXPECT_FALSE(found.reason.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(Target, MarkerBoards,
                         ::testing::Values(Case{"charuco-11x8-22mm", 0.26}, Case{"charuco-14x9-40mm", 0.60},
                                           Case{"aprilgrid-6x4-30mm", 0.26}, Case{"aprilgrid-6x6-88mm", 0.8}),
                         [](const auto& one) {
                           std::string name = one.param.board;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// A description with columns and rows swapped puts markers where none can agree; of a board it says so.
TEST(MarkerBoard, AnotherLayoutIsNotFound) {
  const BoardSpec board = board_named("charuco-11x8-22mm");
  const Camera camera = plain_camera(960, 720, 800.0);
  const Image picture = render_board(camera, board, facing(board, 0.35, {0.1, 0.2, 0.1}));
  BoardSpec swapped = board;
  std::swap(swapped.corners_x, swapped.corners_y);
  const BoardDetection found = detect_board(picture, swapped);
  EXPECT_FALSE(found.found && found.corner_ids.size() > 20) << found.corner_ids.size();
  BoardSpec other = board;
  other.dictionary = "4x4_50";
  EXPECT_NE(detect_board(picture, other).reason.find("4x4_50"), std::string::npos);
}

// Boards printed by OpenCV before 4.6 with an even count of rows.
TEST(MarkerBoard, LegacyPatternHasItsOwnLayout) {
  BoardSpec board = board_named("charuco-11x8-22mm");
  board.legacy_pattern = true;
  const Camera camera = plain_camera(960, 720, 800.0);
  const Rigid3 pose = facing(board, 0.35, {0.1, 0.2, 0.1});
  const BoardDetection found = detect_board(render_board(camera, board, pose), board);
  ASSERT_TRUE(found.found) << found.reason;
  EXPECT_EQ(found.corner_ids.size(), 70U);
  EXPECT_LT(worst_px(found, board, camera, pose), 0.15);
}

// Kalibr's generator puts the highest bit of 0xd5d628584 (tag 0 of 36h11) at the top-left, inside a border of
// two modules.
TEST(MarkerBoard, TagsAreKalibrs) {
  const MarkerPrint tag = print_marker(board_named("aprilgrid-6x6-88mm"), 0);
  ASSERT_EQ(tag.side, 10);
  constexpr std::uint64_t kCode = 0xd5d628584;
  for (int v = 0; v < 10; ++v) {
    for (int u = 0; u < 10; ++u) {
      const bool inside = u >= 2 && v >= 2 && u < 8 && v < 8;
      const bool white = inside && ((kCode >> (35 - ((v - 2) * 6 + u - 2))) & 1U) != 0;
      EXPECT_EQ(tag.white[static_cast<std::size_t>(v * 10 + u)], white) << u << "," << v;
    }
  }
  // Its ids start at the bottom-left.
  const BoardSpec board = board_named("aprilgrid-6x6-88mm");
  EXPECT_EQ(marker_in_board(board, 0)[0], corner_in_board(board, 1, 11).head<2>());
  EXPECT_EQ(marker_in_board(board, 35)[0], corner_in_board(board, 11, 1).head<2>());
}

}  // namespace
}  // namespace furrow::target
