#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "furrow/image/image.h"
#include "furrow/target/board.h"

namespace furrow::target {

/// The inner corners of one picture's board, or why there are none.
struct BoardDetection {
  std::string image;  ///< name as given
  int width = 0, height = 0;
  bool found = false;
  std::vector<Eigen::Vector2d> corners_px;  ///< order of corners_in_board; empty when not found
  std::vector<double> sigma_px;             ///< one per corner
  std::string reason;  ///< when not found: "no board of 9x6 inner corners found", "picture unreadable: ...",
                       ///< "byte-identical to ..."
  std::string sha256;  ///< of the file's bytes, to name copies
};

struct DetectOptions {
  /// Longest picture side at which the coarse search runs, px. Larger finds smaller squares, slower.
  int coarse_side_px = 1280;
};

BoardDetection detect_board(const Image& picture, const BoardSpec& board, const DetectOptions& options = {});

}  // namespace furrow::target
