#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::target {

/// What is printed on a board.
enum class BoardKind {
  checkerboard,  ///< squares; must be seen whole
  charuco,       ///< squares with ArUco markers in the white ones; a part is enough
  aprilgrid,     ///< AprilTags with small squares between them (Kalibr's aprilgrid); a part is enough
};

/// A printed board: a lattice of corners, row by row. board: origin at the first corner, x along the columns,
/// y along the rows, z = x cross y into the board: away from a camera that sees the printed side (as OpenCV
/// and mrcal have it).
struct BoardSpec {
  std::string name;       ///< file stem of its YAML
  int corners_x = 0;      ///< corners in a row (columns): inner corners of squares; two a tag on an AprilGrid
  int corners_y = 0;      ///< corners in a column (rows)
  double square_m = 0.0;  ///< side of a square (AprilGrid: of a tag) along x, metres
  double aspect = 1.0;    ///< side along y / side along x; 1 for a printed board
  BoardKind kind = BoardKind::checkerboard;
  double marker_m = 0.0;        ///< ChArUco: side of a marker
  double gap_m = 0.0;           ///< AprilGrid: between two tags (Kalibr's tagSpacing is gap / tag)
  std::string dictionary{};     ///< ChArUco, AprilGrid: of its markers, as "4x4_50" or "apriltag_36h11"
  bool legacy_pattern = false;  ///< ChArUco: as OpenCV before 4.6 had it, a white first square on even rows
};

/// Reads one of
///   type: checkerboard, corners: [9, 6], square_m: 0.025, and aspect: 1.01 where squares are not square
///   type: charuco, squares: [11, 8], square_m: 0.030, marker_m: 0.022, dictionary: 5x5_100
///   target_type: aprilgrid, tagCols: 6, tagRows: 6, tagSize: 0.088, tagSpacing: 0.3 (as Kalibr has it; type:
///   will do)
/// Errors: file_*, malformed_yaml, board_invalid (a square of 1 m or more is refused with the hint that
/// metres are wanted; fewer than 3 corners a side; unknown type or dictionary; more markers than the
/// dictionary has).
Result<BoardSpec> read_board(const std::filesystem::path& file);

/// The same from a file's text; `name` stands in messages and becomes the board's name.
Result<BoardSpec> parse_board(const std::string& text, const std::string& name);

/// Errors: board_invalid, as read_board says.
Status validate(const BoardSpec& board);

/// What is printed, margins aside: the outermost edges of black, in board's x and y.
struct PrintedExtent {
  Eigen::Vector2d low_m, high_m;
};
PrintedExtent printed_extent(const BoardSpec& board);

/// x_in_board of the corner in column i and row j.
Eigen::Vector3d corner_in_board(const BoardSpec& board, int i, int j);

/// x_in_board of all corners, row by row; a corner's place in this list is its id.
std::vector<Eigen::Vector3d> corners_in_board(const BoardSpec& board);

}  // namespace furrow::target
