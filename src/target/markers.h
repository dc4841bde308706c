#pragma once
#include <array>
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "furrow/image/image.h"
#include "furrow/target/board.h"
#include "target/search_work.h"

namespace furrow::target {

/// A set of square markers.
struct Dictionary {
  int markers = 0;  ///< how many there are, ids from 0
  int bits = 0;     ///< a side, the black border aside
};

/// "DICT_4X4_50" and "4x4_50" are the same.
std::string dictionary_key(const std::string& name);
/// Nothing for an unknown name.
std::optional<Dictionary> find_dictionary(const std::string& key);
/// All names, smaller dictionaries of one kind first.
std::vector<std::string> dictionary_keys();
/// The same in one sentence, for messages.
std::string dictionary_names();

/// A marker as printed.
struct MarkerPrint {
  int side = 0;             ///< modules, the black border included
  std::vector<bool> white;  ///< of each module, row by row from the top-left
};
/// OpenCV's markers have a border of one module. Kalibr's tags have two, and stand on their heads against
/// OpenCV's (the code's highest bit is at the top-left).
MarkerPrint print_marker(const BoardSpec& board, int id);

/// Whether the square in that column and row of a checkerboard or a ChArUco board, the first being 0, is
/// black.
bool is_black_square(const BoardSpec& board, int column, int row);

/// Markers on a ChArUco board or tags on an AprilGrid; 0 for a checkerboard.
int marker_count(const BoardSpec& board);

/// The corners of a marker in the board, x and y in metres, clockwise from the one that OpenCV calls the
/// first: the top-left, for a tag the bottom-right. Ids count as OpenCV (ChArUco: row by row from the
/// top-left) and Kalibr (AprilGrid: row by row from the bottom-left) have it. `id` must be below
/// marker_count().
std::array<Eigen::Vector2d, 4> marker_in_board(const BoardSpec& board, int id);

/// A marker seen in a picture.
struct SeenMarker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corner_px;  ///< in the order of marker_in_board(), good to a pixel or so
};

/// Markers of a board's dictionary in a grey picture, by id, those that are not on the board included; two of
/// the same id both stand. OpenCV's detector; of its own for AprilTags it finds fewer where tags touch small
/// squares (measured: 1 of 24 against 24 of 24). Tags with a border of one module are read too. Of more than
/// 2000 outlines with four corners the smaller ones are left out: OpenCV compares each with each.
std::vector<SeenMarker> find_markers(const Image& grey, const BoardSpec& board, SearchWork& work);

}  // namespace furrow::target
