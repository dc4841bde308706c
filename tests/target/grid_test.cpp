#include "target/grid.h"

#include <gtest/gtest.h>

#include "target/render_board.h"

namespace furrow::target {
namespace {

// In noise a grid was found that began a square too early, at the outer corners of the outer squares.
TEST(Grid, TheOuterSquaresOuterCornersAreNone) {
  const BoardSpec board{"test", 6, 4, 0.025, 1.0};
  const Camera camera = plain_camera(640, 480, 700.0);
  const Rigid3 pose = facing(board, 0.36, {0.1, 0.05, 0.02});
  const Image picture = render_board(camera, board, pose, 3);
  const auto grid_from = [&](int i0, int j0) {
    Grid grid{board.corners_x, board.corners_y, {}};
    for (int j = j0; j < j0 + grid.rows; ++j) {
      for (int i = i0; i < i0 + grid.columns; ++i)
        grid.px.push_back(
            *camera::project(camera, pose * Eigen::Vector3d(i * board.square_m, j * board.square_m, 0)));
    }
    return grid;
  };
  EXPECT_EQ(grid_fault(grid_from(0, 0), picture, 0.1), "");
  for (const auto& [i0, j0] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
    EXPECT_EQ(grid_fault(grid_from(i0, j0), picture, 0.1), "along one of its sides no four squares meet")
        << i0 << j0;
}

}  // namespace
}  // namespace furrow::target
