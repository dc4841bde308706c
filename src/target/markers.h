#pragma once
#include <array>
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "furrow/image/image.h"
#include "furrow/target/board.h"

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
/// All names, for messages.
std::string dictionary_names();

/// Whether each module of a marker is white, row by row from its top-left, the border of one black module
/// included: bits + 2 a side.
std::vector<bool> marker_modules(const std::string& dictionary, int id);

/// Whether the square in that column and row of a checkerboard or a ChArUco board, the first being 0, is
/// black.
bool is_black_square(const BoardSpec& board, int column, int row);

/// Markers on a ChArUco board or tags on an AprilGrid; 0 for a checkerboard.
int marker_count(const BoardSpec& board);

/// The corners of a marker in the board, x and y in metres: top-left, top-right, bottom-right, bottom-left as
/// printed. Ids count as OpenCV (ChArUco: row by row from the top-left) and Kalibr (AprilGrid: row by row
/// from the bottom-left) have it. `id` must be below marker_count().
std::array<Eigen::Vector2d, 4> marker_in_board(const BoardSpec& board, int id);

/// A marker seen in a picture.
struct SeenMarker {
  int id = 0;
  std::array<Eigen::Vector2d, 4> corner_px;  ///< in the order of marker_in_board(), good to a pixel or so
};

/// Markers of a dictionary in a grey picture, by id; two of the same id both stand. OpenCV's detector of
/// candidates (AprilTag's own where the tags touch small squares) and decoder.
std::vector<SeenMarker> find_markers(const Image& grey, const std::string& dictionary, bool tags_touch);

}  // namespace furrow::target
