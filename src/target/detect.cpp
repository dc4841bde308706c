#include "furrow/target/detect.h"

#include <algorithm>

#include "target/board_words.h"
#include "target/coarse.h"
#include "target/find.h"
#include "target/grid.h"
#include "target/marker_board.h"
#include "target/picture_fault.h"
#include "target/refine.h"

namespace furrow::target {
namespace {

/// Half the window of a corner's refinement, as a share of the distance to its nearest neighbour. Wide
/// windows average more noise; but the outermost squares of many boards are cut to half, and their far edges
/// must stay out. Where even this finds no corner (an edge of the picture, a stain), the narrower ones are
/// tried.
constexpr double kWindowShares[] = {0.25, 0.18, 0.12};
/// Smaller squares than this leave no gradients of their own to each corner, px.
constexpr double kSmallestSquarePx = 5.0;

/// A tenth of a square is an order beyond what refined corners stray.
constexpr double kLargestMisfit = 0.1;

/// Corners of a grid in a smaller copy, in the pixels of the whole picture.
Grid in_whole(Grid grid, const Coarse& coarse) {
  for (Eigen::Vector2d& p : grid.px) p = coarse.in_whole(p);
  return grid;
}

struct Refined {
  Grid grid;
  std::vector<double> sigma_px;
  std::string fault;
};

Refined refine(const Grid& start, const Image& grey, double noise) {
  Refined out{start, std::vector<double>(start.px.size()), ""};
  for (int j = 0; j < start.rows; ++j) {
    for (int i = 0; i < start.columns; ++i) {
      const double square_px = nearest_neighbour_px(start, i, j);
      std::optional<RefinedCorner> corner;
      for (const double share : kWindowShares) {
        if (corner || square_px < kSmallestSquarePx) break;
        corner = refine_corner(grey, start.at(i, j), share * square_px, noise);
      }
      if (!corner) {
        out.fault =
            "corner " + std::to_string(i) + "," + std::to_string(j) + " is not sharp enough to refine";
        return out;
      }
      out.grid.px[start.index(i, j)] = corner->px;
      out.sigma_px[start.index(i, j)] = corner->sigma_px;
    }
  }
  return out;
}

/// A hint from a lattice of another size: squares counted as corners, or a board partly out of the picture.
std::string what_was_seen(const Found& seen, const BoardSpec& board) {
  // Smaller lattices are as likely to be tiles, windows or keys.
  constexpr int kFewestToName = 9;
  if (seen.columns * seen.rows < kFewestToName) return "";
  const int longer = std::max(board.corners_x, board.corners_y),
            shorter = std::min(board.corners_x, board.corners_y);
  const std::string size = size_name(seen.columns, seen.rows);
  if (seen.complete && (seen.columns > longer || seen.rows > shorter))
    return "; a grid of " + size + " corners shows";
  return "; a part of " + size + " corners shows";
}

/// detect_board() for a board that must be seen whole.
BoardDetection detect_checkerboard(const Image& grey, const BoardSpec& board, const DetectOptions& options,
                                   SearchWork& work) {
  BoardDetection out;
  out.width = grey.width;
  out.height = grey.height;
  const std::string wanted = size_name(board.corners_x, board.corners_y);
  out.reason = "no board of " + wanted + " inner corners found";
  const Coarse coarse = coarse_copy(grey, std::max(64, options.coarse_side_px));
  const Found seen = find_grid(coarse.grey, board.corners_x, board.corners_y, work);
  if (seen.grid.px.empty()) {
    out.reason += what_was_seen(seen, board);
    return out;
  }
  if (!seen.fault.empty()) {
    out.reason = "a grid of " + wanted + " corners was found, but " + seen.fault;
    return out;
  }
  // First where it was found, then in the whole picture: a window of the right size must start within its
  // reach.
  Refined refined = refine(seen.grid, coarse.grey, 1.0);
  if (refined.fault.empty()) refined = refine(in_whole(refined.grid, coarse), grey, noise_grey(grey));
  const Grid grid = oriented(refined.grid, board.corners_x, board.corners_y, grey);
  if (refined.fault.empty() && grid.px.empty()) refined.fault = "its squares overlap";
  if (refined.fault.empty()) refined.fault = grid_fault(grid, grey, kLargestMisfit);
  if (!refined.fault.empty()) {
    out.reason = "a grid of " + wanted + " corners was found, but " + refined.fault;
    return out;
  }
  // Orientation only reorders; each corner's sigma is found again by its place.
  for (const Eigen::Vector2d& p : grid.px) {
    const auto it = std::find(refined.grid.px.begin(), refined.grid.px.end(), p);
    out.sigma_px.push_back(refined.sigma_px[static_cast<std::size_t>(it - refined.grid.px.begin())]);
  }
  out.corners_px = grid.px;
  out.found = true;
  out.reason.clear();
  return out;
}

}  // namespace

BoardDetection detect_board(const Image& picture, const BoardSpec& board, const DetectOptions& options) {
  check(validate(board).ok(), "detect_board: the board is not valid");
  BoardDetection out;
  out.width = picture.width;
  out.height = picture.height;
  out.reason = "the picture is too small for a board";
  if (picture.empty() || std::min(picture.width, picture.height) < 2 * kSmallestSquarePx) return out;
  const Image grey = image::to_grey(picture);
  SearchWork work;
  out = board.kind == BoardKind::checkerboard ? detect_checkerboard(grey, board, options, work)
                                              : detect_marker_board(grey, board, options, work);
  out.search_steps = work.steps();
  out.search_cut = work.cut();
  if (out.found) return out;
  if (out.search_cut) out.reason += "; the picture is so full of detail that weaker corners were left out of the search";
  const std::string fault = picture_fault(coarse_copy(grey, std::max(64, options.coarse_side_px)).grey);
  if (!fault.empty()) out.reason += "; " + fault;
  return out;
}

}  // namespace furrow::target
