#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::target {

/// A printed checkerboard. board: origin at the first inner corner, x along the columns, y along the rows, z
/// = x cross y into the board: away from a camera that sees the printed side (as OpenCV and mrcal have it).
struct BoardSpec {
  std::string name;       ///< file stem of its YAML
  int corners_x = 0;      ///< inner corners in a row (columns)
  int corners_y = 0;      ///< inner corners in a column (rows)
  double square_m = 0.0;  ///< side of a square along x, metres
  double aspect = 1.0;    ///< side along y / side along x; 1 for a printed board
};

/// Reads `type: checkerboard`, `corners: [9, 6]`, `square_m: 0.025`. Errors: file_*, malformed_yaml,
/// board_invalid (a square of 1 m or more is refused with the hint that metres are wanted; fewer than 3
/// corners a side; unknown type).
Result<BoardSpec> read_board(const std::filesystem::path& file);

/// The same from a file's text; `name` stands in messages and becomes the board's name.
Result<BoardSpec> parse_board(const std::string& text, const std::string& name);

/// Errors: board_invalid, as read_board says.
Status validate(const BoardSpec& board);

/// x_in_board of all inner corners, row by row: (i square, j square aspect, 0).
std::vector<Eigen::Vector3d> corners_in_board(const BoardSpec& board);

}  // namespace furrow::target
