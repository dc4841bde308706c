#pragma once
#include <cstdint>
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/progress.h"
#include "furrow/image/image.h"
#include "furrow/target/board.h"

namespace furrow::target {

/// Steps that the search for one picture's board may take: pixels looked at, pairs of corners or outlines
/// compared. Some seconds' worth; ordinary pictures need a few percent of it. A count and no clock, so that
/// the answer is the same on every machine.
inline constexpr std::int64_t kMostSearchSteps = 400'000'000;

/// The corners of one picture's board, or why there are none.
struct BoardDetection {
  std::string image;  ///< name; with its folder's where two files of a set have one name
  int width = 0, height = 0;
  bool found = false;
  std::vector<Eigen::Vector2d> corners_px;  ///< order of corners_in_board; empty when not found
  /// Which corner each one is, rising (a place in corners_in_board); empty: all of them.
  std::vector<int> corner_ids;
  /// One per corner: what the picture's noise and gradients allow, per coordinate. Relative weights are good;
  /// the absolute level leaves out the lens, the paper and the JPEG.
  std::vector<double> sigma_px;
  /// When not found: "no board of 9x6 inner corners found", "picture unreadable: ...", "byte-identical to
  /// ...", and what is wrong with the picture: blurred, overexposed, too dark.
  std::string reason;
  std::int64_t search_steps = 0;  ///< taken, at most kMostSearchSteps; 0 where nothing was searched
  /// Whether the search left something out: weaker corners or smaller outlines than the most that it looks at
  /// (4000 and 2000 in a copy of the picture), or all beyond kMostSearchSteps.
  bool search_cut = false;
  std::string sha256;  ///< of the file's bytes, to name copies
  /// 1 to 8: how the file asks to be turned when shown. Corners are in the pixels as stored, whatever it
  /// says.
  int exif_orientation = 1;
};

struct DetectOptions {
  /// Longest picture side at which the coarse search runs, px. Larger finds smaller squares, slower.
  int coarse_side_px = 1280;
};

/// Finds the board, refines every corner to sub-pixel and checks the grid against the board's own homography
/// and colours, so that a wrong grid is reported as not found. x runs along `corners_x`, y to its right-hand
/// side as seen (x cross y away from the camera). Of the ways that leaves, the one with a black square before
/// the first corner is taken; where the colours are the same both ways round, the one whose first corner is
/// nearer to the top-left of the picture. `image` and `sha256` are left empty.
BoardDetection detect_board(const Image& picture, const BoardSpec& board, const DetectOptions& options = {});

/// Reads the pictures and finds their boards in parallel; one entry a file, in the files' order, whatever the
/// thread count. Pictures that cannot be read, copies of an earlier file and pictures of another size than
/// most are entries with `found` false and a reason. `threads` 0: one per core.
std::vector<BoardDetection> detect_boards(const std::vector<std::filesystem::path>& files,
                                          const BoardSpec& board, const DetectOptions& options = {},
                                          int threads = 0, const base::Progress& progress = {});

/// Counts of inner corners that a picture shows, when nobody described the board.
struct BoardGuess {
  int corners_x = 0, corners_y = 0;  ///< longer side first
  int pictures = 0;                  ///< how many show a whole grid of these counts
};

/// The counts that most of the pictures show as a whole grid, most frequent first (of equals the larger);
/// empty when none shows one. For finding the counts of an unknown board and for catching a board file that
/// counts squares instead of corners.
std::vector<BoardGuess> guess_boards(const std::vector<std::filesystem::path>& files,
                                     const DetectOptions& options = {}, int threads = 0,
                                     const base::Progress& progress = {});

/// Why a description finds few boards while the pictures show another one: squares counted instead of
/// corners, one side off, or simply other counts; which description fits. Empty when the description is among
/// the guesses or there is no guess.
std::string explain_board(const BoardSpec& described, const std::vector<BoardGuess>& guesses);

/// Which description would fit pictures that a board's own hardly fits, in words: explain_board() for
/// checkerboards; for markers another layout or another dictionary. Empty when none fits better.
std::string what_fits_instead(const std::vector<std::filesystem::path>& files, const BoardSpec& board,
                              const DetectOptions& options = {}, int threads = 0,
                              const base::Progress& progress = {});

/// How a description fits pictures of a board.
struct BoardCheck {
  std::vector<BoardDetection> detections;  ///< one a file
  int found = 0;                           ///< boards
  bool fits = false;  ///< at least half of the readable, different pictures show this board
  /// What a person should know: that it fits, or which description would ("corners: [9, 6]"), or that none
  /// does.
  std::string verdict;
};

/// Looks for the described board; where it is rarely seen, for what the pictures show instead: other counts
/// of corners, squares counted as corners, and for markers another layout or another dictionary.
BoardCheck check_board(const std::vector<std::filesystem::path>& files, const BoardSpec& board,
                       const DetectOptions& options = {}, int threads = 0,
                       const base::Progress& progress = {});

}  // namespace furrow::target
