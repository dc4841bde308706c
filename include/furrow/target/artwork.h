#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/target/board.h"

namespace furrow::target {

/// An upright rectangle in the board's x and y, metres.
struct Rectangle {
  Eigen::Vector2d low_m, high_m;
};

/// Everything black that is printed on a board, as rectangles that do not overlap, row by row. The square
/// before the first corner is black; what is white in the squares of a ChArUco board holds markers in reading
/// order; an AprilGrid's tags are numbered from the bottom-left (docs/formulation/calibration.md).
std::vector<Rectangle> black_rectangles(const BoardSpec& board);

/// The same for asking point by point: the colour between all edges.
struct Artwork {
  std::vector<double> x_edges_m, y_edges_m;  ///< rising
  std::vector<bool> black;                   ///< (x_edges - 1) * (y_edges - 1), row by row
};
Artwork make_artwork(const BoardSpec& board);

/// Whether the board is black at a point; paper beyond the printed edges is white.
bool is_black(const Artwork& artwork, const Eigen::Vector2d& x_in_board);

}  // namespace furrow::target
