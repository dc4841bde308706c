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
  EXPECT_NE(refusal("").find("type"), std::string::npos);
  EXPECT_NE(refusal("[1, 2").find("malformed_yaml"), std::string::npos);
  EXPECT_FALSE(read_board("no/such/board.yaml").ok());
}

}  // namespace
}  // namespace furrow::target
