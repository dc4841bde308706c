#include <algorithm>
#include <map>
#include <mutex>

#include "furrow/base/parallel.h"
#include "furrow/target/detect.h"
#include "target/board_words.h"
#include "target/coarse.h"
#include "target/find.h"
#include "target/marker_board.h"

namespace furrow::target {

std::vector<BoardGuess> guess_boards(const std::vector<std::filesystem::path>& files,
                                     const DetectOptions& options, int threads,
                                     const base::Progress& progress) {
  std::vector<std::pair<int, int>> counts(files.size());
  std::mutex mutex;
  std::size_t done = 0;
  base::parallel_for(files.size(), threads, [&](std::size_t i) {
    const auto picture = image::read_image(files[i]);
    if (picture.ok()) {
      const Grid grid =
          find_any_grid(coarse_copy(image::to_grey(*picture), std::max(64, options.coarse_side_px)).grey);
      counts[i] = {std::max(grid.columns, grid.rows), std::min(grid.columns, grid.rows)};
    }
    const std::lock_guard lock(mutex);
    base::report(progress, "counting corners", ++done, files.size());
  });
  std::map<std::pair<int, int>, int> tally;
  for (const auto& one : counts) {
    if (one.second > 0) ++tally[one];
  }
  std::vector<BoardGuess> out;
  for (const auto& [size, pictures] : tally) out.push_back({size.first, size.second, pictures});
  std::stable_sort(out.begin(), out.end(), [](const BoardGuess& a, const BoardGuess& b) {
    return a.pictures != b.pictures ? a.pictures > b.pictures
                                    : a.corners_x * a.corners_y > b.corners_x * b.corners_y;
  });
  return out;
}

namespace {

/// Pictures that could show the board: readable, of the common size, and no copies.
int candidates(const std::vector<BoardDetection>& detections) {
  return static_cast<int>(std::count_if(detections.begin(), detections.end(), [](const BoardDetection& one) {
    return one.width > 0 && !one.reason.starts_with("byte-identical") && !one.reason.starts_with("size ");
  }));
}

/// A few of the pictures, grey and small, from all over the set.
std::vector<Image> sample(const std::vector<std::filesystem::path>& files, const DetectOptions& options) {
  constexpr std::size_t kMost = 5;
  std::vector<Image> out;
  const std::size_t step = std::max<std::size_t>(1, files.size() / kMost);
  for (std::size_t i = 0; i < files.size() && out.size() < kMost; i += step) {
    const auto picture = image::read_image(files[i]);
    if (picture.ok()) out.push_back(coarse_copy(image::to_grey(*picture), options.coarse_side_px).grey);
  }
  return out;
}

}  // namespace

std::string what_fits_instead(const std::vector<std::filesystem::path>& files, const BoardSpec& board,
                              const DetectOptions& options, int threads, const base::Progress& progress) {
  if (board.kind != BoardKind::checkerboard) return explain_marker_board(sample(files, options), board);
  const auto guesses = guess_boards(files, options, threads, progress);
  return guesses.empty() ? "no whole checkerboard of any counts shows" : explain_board(board, guesses);
}

BoardCheck check_board(const std::vector<std::filesystem::path>& files, const BoardSpec& board,
                       const DetectOptions& options, int threads, const base::Progress& progress) {
  BoardCheck out{detect_boards(files, board, options, threads, progress), 0, false, ""};
  for (const BoardDetection& one : out.detections) out.found += one.found ? 1 : 0;
  const int possible = candidates(out.detections);
  const std::string count = std::to_string(out.found) + " of " + std::to_string(possible) + " pictures";
  out.fits = out.found > 0 && 2 * out.found >= possible;
  if (out.fits) {
    out.verdict = "the description fits " + count;
    return out;
  }
  const std::string instead = what_fits_instead(files, board, options, threads, progress);
  out.verdict =
      "the description fits " + count + "; " +
      (instead.empty() ? "no other fits better: is the board seen whole, sharp and large enough?" : instead);
  return out;
}

std::string explain_board(const BoardSpec& described, const std::vector<BoardGuess>& guesses) {
  if (guesses.empty()) return "";
  const int longer = std::max(described.corners_x, described.corners_y),
            shorter = std::min(described.corners_x, described.corners_y);
  const BoardGuess& best = guesses.front();
  if (best.corners_x == longer && best.corners_y == shorter) return "";
  const std::string shown = size_name(best.corners_x, best.corners_y);
  const std::string fits = "; corners: [" + std::to_string(best.corners_x) + ", " +
                           std::to_string(best.corners_y) + "] fits " + std::to_string(best.pictures) +
                           " pictures";
  if (best.corners_x == longer - 1 && best.corners_y == shorter - 1) {
    return size_name(longer, shorter) + " counts the squares; the corners between them are " + shown + fits;
  }
  return "the pictures show " + shown + " inner corners, not " + size_name(longer, shorter) + fits;
}

}  // namespace furrow::target
