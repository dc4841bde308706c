#include "furrow/target/detect.h"

#include <algorithm>
#include <map>
#include <mutex>

#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
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

std::string size_name(int columns, int rows) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

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

/// Reasons that need all files at once: copies, and sizes that differ from most.
void name_copies_and_strays(std::vector<BoardDetection>& all) {
  std::map<std::string, std::string> first_with;
  for (BoardDetection& one : all) {
    if (one.sha256.empty() || one.width == 0) continue;
    const auto [it, is_new] = first_with.emplace(one.sha256, one.image);
    if (is_new) continue;
    one.found = false;
    one.corners_px.clear();
    one.sigma_px.clear();
    one.reason = "byte-identical to " + it->second;
  }
  std::map<std::pair<int, int>, int> count;
  for (const BoardDetection& one : all) {
    if (one.width > 0) ++count[{one.width, one.height}];
  }
  if (count.size() < 2) return;
  const auto most = std::max_element(count.begin(), count.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  for (BoardDetection& one : all) {
    if (one.width == 0 || std::pair(one.width, one.height) == most->first || !one.reason.empty()) continue;
    one.found = false;
    one.corners_px.clear();
    one.sigma_px.clear();
    one.reason = "size " + size_name(one.width, one.height) + " differs from the other pictures' " +
                 size_name(most->first.first, most->first.second);
  }
}

BoardDetection read_and_detect(const std::filesystem::path& file, const BoardSpec& board,
                               const DetectOptions& options) {
  BoardDetection out;
  const auto refused = [&](const Error& error) {
    out.reason = "picture unreadable: " + error.found;
    return out;
  };
  const auto bytes = base::read_file(file);
  std::string sha;
  if (bytes.ok()) {
    sha = base::sha256_hex(*bytes);
    const auto picture = image::decode_image(*bytes, file.string());
    if (picture.ok()) {
      out = detect_board(*picture, board, options);
    } else {
      refused(picture.error());
    }
  } else {
    refused(bytes.error());
  }
  out.sha256 = sha;
  out.exif_orientation = bytes.ok() ? image::exif_orientation(*bytes) : 1;
  return out;
}

}  // namespace

namespace {

/// detect_board() for a board that must be seen whole.
BoardDetection detect_checkerboard(const Image& grey, const BoardSpec& board, const DetectOptions& options) {
  BoardDetection out;
  out.width = grey.width;
  out.height = grey.height;
  const std::string wanted = size_name(board.corners_x, board.corners_y);
  out.reason = "no board of " + wanted + " inner corners found";
  const Coarse coarse = coarse_copy(grey, std::max(64, options.coarse_side_px));
  const Found seen = find_grid(coarse.grey, board.corners_x, board.corners_y);
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
  out = board.kind == BoardKind::checkerboard ? detect_checkerboard(grey, board, options)
                                              : detect_marker_board(grey, board, options);
  if (out.found) return out;
  const std::string fault = picture_fault(coarse_copy(grey, std::max(64, options.coarse_side_px)).grey);
  if (!fault.empty()) out.reason += "; " + fault;
  return out;
}

std::vector<BoardDetection> detect_boards(const std::vector<std::filesystem::path>& files,
                                          const BoardSpec& board, const DetectOptions& options, int threads,
                                          const base::Progress& progress) {
  std::vector<BoardDetection> all(files.size());
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file.filename().string());
  names = base::names_apart(std::move(names), files);
  std::mutex mutex;
  std::size_t done = 0;
  base::report(progress, "detecting boards", 0, files.size());
  base::parallel_for(files.size(), threads, [&](std::size_t i) {
    all[i] = read_and_detect(files[i], board, options);
    all[i].image = names[i];
    const std::lock_guard lock(mutex);
    base::report(progress, "detecting boards", ++done, files.size());
  });
  name_copies_and_strays(all);
  return all;
}

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
