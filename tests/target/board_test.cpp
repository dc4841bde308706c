#include "furrow/target/board.h"

#include <gtest/gtest.h>

namespace furrow::target {
namespace {

TEST(Board, SmallestForm) {
  const auto board = parse_board("type: checkerboard\ncorners: [9, 6]\nsquare_m: 0.025\n", "a/board.yaml");
  ASSERT_TRUE(board.ok()) << board.error().message();
  EXPECT_EQ(board->name, "board");
  EXPECT_EQ(board->corners_x, 9);
  EXPECT_EQ(board->corners_y, 6);
  EXPECT_EQ(board->square_m, 0.025);
  const auto corners = corners_in_board(*board);
  ASSERT_EQ(corners.size(), 54U);
  EXPECT_EQ(corners[0], Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(corners[1], Eigen::Vector3d(0.025, 0, 0));
  EXPECT_EQ(corners[9], Eigen::Vector3d(0, 0.025, 0));
}

TEST(Board, CharucoAndAprilGrid) {
  const auto charuco = parse_board(
      "type: charuco\nsquares: [11, 8]\nsquare_m: 0.03\nmarker_m: 0.022\ndictionary: DICT_5X5_100\n",
      "c.yaml");
  ASSERT_TRUE(charuco.ok()) << charuco.error().message();
  EXPECT_EQ(charuco->corners_x, 10);
  EXPECT_EQ(charuco->corners_y, 7);
  EXPECT_EQ(charuco->dictionary, "5x5_100");
  const auto kalibr = parse_board(
      "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\ntagSpacing: 0.3\n", "k.yaml");
  ASSERT_TRUE(kalibr.ok()) << kalibr.error().message();
  EXPECT_EQ(kalibr->corners_x, 12);
  EXPECT_EQ(kalibr->corners_y, 10);
  EXPECT_NEAR(corner_in_board(*kalibr, 3, 2).x(), 0.088 * 2.3, 1e-12);
  EXPECT_NEAR(corner_in_board(*kalibr, 3, 2).y(), 0.088 * 1.3, 1e-12);
}

std::string refusal(const std::string& text) {
  const auto board = parse_board(text, "b.yaml");
  return board.ok() ? std::string("accepted") : board.error().code + " " + board.error().message();
}

TEST(Board, RefusalsSayWhatIsWrong) {
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, 6]\nsquare_m: 25\n").find("metres"), std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, 6]\nsquare_m: 25\n").find("b.yaml:3"),
            std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, 2]\nsquare_m: 0.02\n").find("inner corners"),
            std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: 9\nsquare_m: 0.02\n").find("[9, 6]"), std::string::npos);
  EXPECT_NE(refusal("type: circles\ncorners: [9, 6]\nsquare_m: 0.02\n").find("circles"), std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, 6]\nsqare_m: 0.02\n").find("square_m"),
            std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, 6]\nsquare_m: -1\n").find("above 0"),
            std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, x]\nsquare_m: 0.02\n").find("board_invalid"),
            std::string::npos);
  EXPECT_NE(refusal("type: checkerboard\ncorners: [9, 100000]\nsquare_m: 0.02\n").find("board_invalid"),
            std::string::npos);
  const std::string charuco = "type: charuco\nsquare_m: 0.03\ndictionary: 4x4_50\n";
  EXPECT_NE(refusal(charuco + "squares: [11, 8]\nmarker_m: 0.03\n").find("marker"), std::string::npos);
  EXPECT_NE(refusal(charuco + "squares: [12, 10]\nmarker_m: 0.02\n").find("60 markers"), std::string::npos);
  EXPECT_NE(refusal("type: charuco\nsquares: [9, 6]\nsquare_m: 0.03\nmarker_m: 0.02\ndictionary: 3x3\n")
                .find("4x4_50"),
            std::string::npos);
  const std::string april = "type: aprilgrid\ntagCols: 6\ntagRows: 6\n";
  EXPECT_NE(refusal(april + "tagSize: 88\ntagSpacing: 0.3\n").find("metres"), std::string::npos);
  EXPECT_NE(refusal(april + "tagSize: 0.088\ntagSpacing: -1\n").find("gap"), std::string::npos);
  EXPECT_NE(refusal("").find("type"), std::string::npos);
  EXPECT_NE(refusal("[1, 2").find("malformed_yaml"), std::string::npos);
  EXPECT_FALSE(read_board("no/such/board.yaml").ok());
}

// Whatever stands in a file: a board that is valid, or an error in words.
TEST(Board, CutAndFlippedFilesGiveErrorsOrValidBoards) {
  const std::string texts[] = {
      "type: checkerboard\ncorners: [9, 6]\nsquare_m: 0.025\naspect: 1.01\n",
      "type: charuco\nsquares: [11, 8]\nsquare_m: 0.03\nmarker_m: 0.022\ndictionary: "
      "5x5_100\nlegacy_pattern: true\n",
      "target_type: 'aprilgrid'\ntagCols: 6\ntagRows: 5\ntagSize: 0.088\ntagSpacing: 0.3\n"};
  const auto judge = [](const std::string& text) {
    const auto board = parse_board(text, "fuzz.yaml");
    if (!board.ok()) {
      EXPECT_FALSE(board.error().message().empty());
      return;
    }
    EXPECT_TRUE(validate(*board).ok());
    EXPECT_EQ(corners_in_board(*board).size(), static_cast<std::size_t>(board->corners_x * board->corners_y));
  };
  for (const std::string& text : texts) {
    for (std::size_t at = 0; at < text.size(); ++at) {
      judge(text.substr(0, at));
      for (const int mask : {0x01, 0x08, 0x20, 0x80, 0xff}) {
        std::string flipped = text;
        flipped[at] = static_cast<char>(flipped[at] ^ mask);
        judge(flipped);
      }
    }
  }
}

}  // namespace
}  // namespace furrow::target
