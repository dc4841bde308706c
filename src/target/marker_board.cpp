#include "target/marker_board.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <map>
#include <optional>

#include "furrow/base/text.h"
#include "furrow/target/artwork.h"
#include "furrow/target/homography.h"
#include "target/coarse.h"
#include "target/markers.h"
#include "target/misfit.h"
#include "target/refine.h"

namespace furrow::target {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Fewer corners than this leave a pose to chance.
constexpr std::size_t kFewestCorners = 6;

/// A marker of the board with both ends of its corners.
struct PlacedMarker {
  SeenMarker seen;
  Points in_board;  ///< of each of the four corners, metres
};

double side_px(const SeenMarker& marker) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < 4; ++c)
    shortest = std::min(shortest, (marker.corner_px[c] - marker.corner_px[(c + 1) % 4]).norm());
  return shortest;
}

/// The board's markers, their corners counted from the one that `turns` quarter turns move to the top-left.
std::vector<PlacedMarker> placed(const std::vector<SeenMarker>& seen, const BoardSpec& board,
                                 std::size_t turns) {
  std::vector<PlacedMarker> out;
  for (const SeenMarker& marker : seen) {
    if (marker.id >= marker_count(board)) continue;
    PlacedMarker one{marker, {}};
    const auto corners = marker_in_board(board, marker.id);
    for (std::size_t c = 0; c < 4; ++c) one.in_board.push_back(corners[(c + turns) % 4]);
    out.push_back(std::move(one));
  }
  return out;
}

Points corners_of(const std::array<Eigen::Vector2d, 4>& corner) {
  return {corner.begin(), corner.end()};
}

Eigen::Vector2d carried(const Eigen::Matrix3d& h, const Eigen::Vector2d& x) {
  return (h * x.homogeneous()).hnormalized();
}

/// Whether the plane through one marker puts the other where it was seen. A marker's own corners are good to
/// a pixel, so its plane carries no farther than to the next markers.
bool agree(const PlacedMarker& a, const PlacedMarker& b) {
  constexpr double kLargestShare = 0.4;  // of a marker's side; a wrong place is off by more than a side
  const auto h = fit_homography(a.in_board, corners_of(a.seen.corner_px));
  if (!h) return false;
  for (std::size_t c = 0; c < 4; ++c) {
    const double miss_px = (carried(*h, b.in_board[c]) - b.seen.corner_px[c]).norm();
    if (!(miss_px < kLargestShare * side_px(b.seen))) return false;
  }
  return true;
}

/// How far apart the middles of neighbouring markers are at most, in pitches of the board: the diagonal, and
/// a little.
constexpr double kNeighbour = 1.6;

double marker_pitch_m(const BoardSpec& board) {
  // In a ChArUco board's rows every other square holds a marker; the nearest ones lie diagonally.
  return board.kind == BoardKind::aprilgrid ? board.square_m + board.gap_m : 1.42 * board.square_m;
}

/// The largest set of markers that hang together by agreeing with their neighbours.
std::vector<PlacedMarker> that_agree(const std::vector<PlacedMarker>& markers, double pitch_m) {
  std::vector<int> group(markers.size(), -1);
  std::vector<std::vector<PlacedMarker>> groups;
  for (std::size_t first = 0; first < markers.size(); ++first) {
    if (group[first] >= 0) continue;
    const int own = static_cast<int>(groups.size());
    groups.emplace_back();
    std::vector<std::size_t> queue{first};
    group[first] = own;
    for (std::size_t at = 0; at < queue.size(); ++at) {
      const PlacedMarker& from = markers[queue[at]];
      groups.back().push_back(from);
      for (std::size_t m = 0; m < markers.size(); ++m) {
        const double apart_m = (markers[m].in_board[0] - from.in_board[0]).norm();
        if (group[m] >= 0 || apart_m > kNeighbour * pitch_m) continue;
        if (!agree(from, markers[m]) && !agree(markers[m], from)) continue;
        group[m] = own;
        queue.push_back(m);
      }
    }
  }
  const auto largest = std::max_element(groups.begin(), groups.end(),
                                        [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return largest == groups.end() ? std::vector<PlacedMarker>{} : *largest;
}

/// Tags of one code are printed turned one way or the other; whichever way makes most of them agree is the
/// board's.
std::vector<PlacedMarker> markers_on_board(const std::vector<SeenMarker>& seen, const BoardSpec& board) {
  std::vector<PlacedMarker> best;
  for (std::size_t turns = 0; turns < 4; ++turns) {
    auto agreed = that_agree(placed(seen, board, turns), marker_pitch_m(board));
    if (agreed.size() > best.size()) best = std::move(agreed);
  }
  return best;
}

/// A corner told by the markers beside it.
struct Predicted {
  int id = 0;
  Eigen::Vector2d in_board;  ///< metres
  Eigen::Matrix3d picture_from_board;
};

/// The corners that touch a seen marker, each with the plane through the nearest markers (two at most: a lens
/// bends larger pieces).
std::vector<Predicted> predict(const std::vector<PlacedMarker>& markers, const BoardSpec& board) {
  constexpr double kSlack = 1e-6;
  const double reach_m = board.kind == BoardKind::aprilgrid
                             ? kSlack
                             : std::sqrt(0.5) * (board.square_m - board.marker_m) + kSlack;
  std::vector<Predicted> out;
  const auto corners = corners_in_board(board);
  for (std::size_t id = 0; id < corners.size(); ++id) {
    const Eigen::Vector2d x = corners[id].head<2>();
    Points in_board, px;
    for (const PlacedMarker& marker : markers) {
      const bool touches = std::any_of(marker.in_board.begin(), marker.in_board.end(), [&](const auto& own) {
        return (own - x).norm() <= reach_m * std::max(1.0, board.aspect);
      });
      if (!touches) continue;
      in_board.insert(in_board.end(), marker.in_board.begin(), marker.in_board.end());
      px.insert(px.end(), marker.seen.corner_px.begin(), marker.seen.corner_px.end());
    }
    if (const auto h = fit_homography(in_board, px)) out.push_back({static_cast<int>(id), x, *h});
  }
  return out;
}

/// Free room around a corner before other print begins, as a share of the square or tag: a marker in its
/// square, a tag's border, a small square.
double free_share(const BoardSpec& board) {
  if (board.kind == BoardKind::charuco) return 0.5 * (1.0 - board.marker_m / board.square_m);
  constexpr double kNarrowestBorder =
      0.125;  // one module of 36h11's eight; Kalibr's own tags have two of ten
  return std::min(kNarrowestBorder, board.gap_m / board.square_m);
}

/// Side of the square or tag at a corner in the picture, px: the shorter of both ways.
double square_px(const Predicted& corner, const BoardSpec& board) {
  const auto along = [&](const Eigen::Vector2d& step) {
    return 0.5 * (carried(corner.picture_from_board, corner.in_board + step) -
                  carried(corner.picture_from_board, corner.in_board - step))
                     .norm();
  };
  return std::min(along({board.square_m, 0.0}), along({0.0, board.square_m * board.aspect}));
}

/// Whether the print about a corner shows: the two black pieces darker than the two white ones.
bool shows(const Image& grey, const Artwork& artwork, const Predicted& corner,
           const Eigen::Vector2d& shift_px, double step_m, double aspect) {
  double darkest_white = 255.0, brightest_black = 0.0;
  for (const Eigen::Vector2d& way :
       {Eigen::Vector2d(1, 1), Eigen::Vector2d(1, -1), Eigen::Vector2d(-1, 1), Eigen::Vector2d(-1, -1)}) {
    const Eigen::Vector2d x = corner.in_board + step_m * way.cwiseProduct(Eigen::Vector2d(1.0, aspect));
    const Eigen::Vector2d px = carried(corner.picture_from_board, x) + shift_px;
    if (!(px.x() >= 0.0 && px.y() >= 0.0 && px.x() < grey.width - 1 && px.y() < grey.height - 1))
      return false;
    const double level =
        *grey.at(static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y())));
    if (is_black(artwork, x)) {
      brightest_black = std::max(brightest_black, level);
    } else {
      darkest_white = std::min(darkest_white, level);
    }
  }
  constexpr double kWeakestContrast = 8.0;  // grey levels
  return darkest_white - brightest_black > kWeakestContrast;
}

/// Corners of a board to sub-pixel.
struct Corners {
  std::vector<int> ids;
  Points in_board, px;
  std::vector<double> sigma_px, square_px;

  void erase(std::size_t c) {
    const auto at = static_cast<std::ptrdiff_t>(c);
    ids.erase(ids.begin() + at);
    in_board.erase(in_board.begin() + at);
    px.erase(px.begin() + at);
    sigma_px.erase(sigma_px.begin() + at);
    square_px.erase(square_px.begin() + at);
  }
};

/// Half the window of a refinement, as shares of the free room; narrower ones where the first finds no
/// corner.
constexpr double kWindowShares[] = {0.85, 0.6};
/// Larger windows than a quarter of the square gain nothing: see detect.cpp.
constexpr double kWidestShare = 0.25;

Corners refine(const std::vector<Predicted>& predicted, const Coarse& coarse, const Image& grey,
               const BoardSpec& board) {
  const Artwork artwork = make_artwork(board);
  const double free = free_share(board), noise = noise_grey(grey), scale = std::max(coarse.su, coarse.sv);
  Corners out;
  for (const Predicted& corner : predicted) {
    const Eigen::Vector2d start = carried(corner.picture_from_board, corner.in_board);
    const double side_px = square_px(corner, board);
    std::optional<RefinedCorner> refined;
    for (const double share : kWindowShares) {
      if (refined) break;
      const double half_px = std::min(kWidestShare, share * free) * side_px;
      // First where it was found: a window in the whole picture must start within its reach.
      const auto rough = refine_corner(coarse.grey, start, half_px, noise);
      if (rough) refined = refine_corner(grey, coarse.in_whole(rough->px), half_px * scale, noise);
      if (rough &&
          !shows(coarse.grey, artwork, corner, rough->px - start, 0.7 * free * board.square_m, board.aspect))
        refined.reset();
    }
    if (!refined) continue;
    out.ids.push_back(corner.id);
    out.in_board.push_back(
        corner.in_board.cwiseQuotient(Eigen::Vector2d(board.square_m, board.square_m * board.aspect)));
    out.px.push_back(refined->px);
    out.sigma_px.push_back(refined->sigma_px);
    out.square_px.push_back(side_px * scale);
  }
  return out;
}

double middle_of(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Takes off the corners that are not where the others put them, worst first: something lies before the board
/// there. Whether the rest is one plane.
bool take_off_strays(Corners& corners, int width, int height) {
  constexpr double kLargestMisfit = 0.1;  // squares, as for a checkerboard
  // A corner half covered by a finger strays by pixels; others by what their refinement leaves.
  constexpr double kMostMedians = 6.0, kSlackPx = 0.5;
  for (std::size_t left = corners.ids.size() / 5 + 1; left > 0; --left) {
    if (corners.ids.size() < kFewestCorners) return false;
    const auto misfit = plane_misfit(corners.in_board, corners.px, width, height);
    if (misfit.empty()) return false;
    std::vector<double> misfit_px;
    for (std::size_t c = 0; c < misfit.size(); ++c) misfit_px.push_back(misfit[c] * corners.square_px[c]);
    const auto worst =
        static_cast<std::size_t>(std::max_element(misfit_px.begin(), misfit_px.end()) - misfit_px.begin());
    if (misfit[worst] <= kLargestMisfit && misfit_px[worst] <= kMostMedians * middle_of(misfit_px) + kSlackPx)
      return true;
    corners.erase(worst);
  }
  return false;
}

std::string part_name(std::size_t corners, const BoardSpec& board) {
  return std::to_string(corners) + " of " + std::to_string(board.corners_x * board.corners_y) + " corners";
}

/// The markers of the copy in which most are read: small first, whole where half of the board or more is
/// missing.
struct Seen {
  Coarse coarse;
  std::vector<PlacedMarker> markers;
  std::size_t read = 0;  ///< markers of the dictionary, the board's or not
};

Seen look(const Image& grey, const BoardSpec& board, const DetectOptions& options, SearchWork& work) {
  Seen best;
  for (const int longest_px : {std::max(64, options.coarse_side_px), std::max(grey.width, grey.height)}) {
    Seen seen{coarse_copy(grey, longest_px), {}, 0};
    const auto found = find_markers(seen.coarse.grey, board, work);
    seen.read = found.size();
    seen.markers = markers_on_board(found, board);
    const bool better = best.coarse.grey.empty() || seen.markers.size() > best.markers.size();
    if (better) best = std::move(seen);
    if (2 * best.markers.size() >= static_cast<std::size_t>(marker_count(board)) ||
        longest_px >= std::max(grey.width, grey.height))
      break;
  }
  return best;
}

/// Markers seen in each of some pictures.
using SeenInPictures = std::vector<std::vector<SeenMarker>>;

SeenInPictures markers_in(const std::vector<Image>& greys, const BoardSpec& board) {
  SeenInPictures out;
  for (const Image& grey : greys) {
    SearchWork work;
    out.push_back(find_markers(grey, board, work));
  }
  return out;
}

std::size_t count_all(const SeenInPictures& seen) {
  std::size_t count = 0;
  for (const auto& one : seen) count += one.size();
  return count;
}

std::size_t count_on_board(const SeenInPictures& seen, const BoardSpec& board) {
  std::size_t count = 0;
  for (const auto& one : seen) {
    const std::size_t agree = markers_on_board(one, board).size();
    count += agree > 1 ? agree : 0;  // one alone agrees with everything
  }
  return count;
}

/// Squares (ChArUco) or tags (AprilGrid) a side.
std::pair<int, int> counts_of(const BoardSpec& board) {
  if (board.kind == BoardKind::aprilgrid) return {board.corners_x / 2, board.corners_y / 2};
  return {board.corners_x + 1, board.corners_y + 1};
}

BoardSpec with_counts(BoardSpec board, int columns, int rows) {
  const bool tags = board.kind == BoardKind::aprilgrid;
  board.corners_x = tags ? 2 * columns : columns - 1;
  board.corners_y = tags ? 2 * rows : rows - 1;
  return board;
}

/// Layouts that others confuse with this one: any count of columns, with as many rows as the ids need, both
/// ways of beginning a ChArUco board.
std::vector<BoardSpec> other_layouts(const BoardSpec& described, int largest_id) {
  constexpr int kMostColumns = 40;
  std::vector<BoardSpec> out;
  for (const bool legacy : {false, true}) {
    for (int columns = 3; columns <= kMostColumns; ++columns) {
      int rows = columns == counts_of(described).first ? counts_of(described).second : 3;
      if (columns == counts_of(described).second) rows = std::max(rows, counts_of(described).first);
      BoardSpec other = with_counts(described, columns, rows);
      other.legacy_pattern = legacy;
      while (marker_count(other) <= largest_id) other = with_counts(other, columns, ++rows);
      out.push_back(other);
    }
    if (described.kind == BoardKind::aprilgrid) break;
  }
  return out;
}

std::string name_counts(const BoardSpec& board) {
  const auto [columns, rows] = counts_of(board);
  if (board.kind == BoardKind::aprilgrid)
    return "tagCols: " + std::to_string(columns) + ", tagRows: " + std::to_string(rows);
  return "squares: [" + std::to_string(columns) + ", " + std::to_string(rows) + "]" +
         (board.legacy_pattern ? " with legacy_pattern: true" : "");
}

int largest_id(const SeenInPictures& seen) {
  int largest = 0;
  for (const auto& one : seen) {
    if (!one.empty()) largest = std::max(largest, one.back().id);
  }
  return largest;
}

/// The dictionary of most markers in the pictures; empty when no dictionary has any to speak of.
std::string dictionary_seen(const std::vector<Image>& greys, BoardSpec board) {
  // Small dictionaries find a stray marker in anything.
  std::size_t most = 3 * greys.size();
  std::string best;
  for (const std::string& key : dictionary_keys()) {
    board.dictionary = key;
    const std::size_t count = count_all(markers_in(greys, board));
    if (count > most) {
      most = count;
      best = key;
    }
  }
  return best;
}

}  // namespace

std::string explain_marker_board(const std::vector<Image>& greys, const BoardSpec& described) {
  const SeenInPictures seen = markers_in(greys, described);
  const std::size_t all = count_all(seen), own = count_on_board(seen, described);
  if (all < 3 * greys.size()) {
    const std::string other = dictionary_seen(greys, described);
    if (other.empty()) return "no markers show";
    return "markers of " + other + " show, not of " + described.dictionary;
  }
  BoardSpec best = described;
  std::size_t most = own;
  for (const BoardSpec& other : other_layouts(described, largest_id(seen))) {
    const std::size_t count = count_on_board(seen, other);
    if (count > most) {
      most = count;
      best = other;
    }
  }
  if (most == own) return "";
  return name_counts(best) + " fits " + std::to_string(most) + " of the " + std::to_string(all) +
         " markers seen, " + name_counts(described) + " only " + std::to_string(own);
}

BoardDetection detect_marker_board(const Image& grey, const BoardSpec& board, const DetectOptions& options,
                                   SearchWork& work) {
  BoardDetection out;
  out.width = grey.width;
  out.height = grey.height;
  const Seen seen = look(grey, board, options, work);
  if (seen.markers.size() < 2) {
    out.reason = seen.read == 0 ? "no marker of " + board.dictionary + " found"
                                : std::to_string(seen.read) + " markers of " + board.dictionary +
                                      " found, but no two that lie as on the board";
    return out;
  }
  Corners corners = refine(predict(seen.markers, board), seen.coarse, grey, board);
  const std::size_t refined = corners.ids.size();
  if (!take_off_strays(corners, grey.width, grey.height)) {
    out.reason = refined < kFewestCorners
                     ? "only " + part_name(refined, board) + " are sharp enough to refine"
                     : part_name(refined, board) + " were found, but they do not lie on a plane";
    return out;
  }
  out.found = true;
  out.corner_ids = std::move(corners.ids);
  out.corners_px = std::move(corners.px);
  out.sigma_px = std::move(corners.sigma_px);
  return out;
}

}  // namespace furrow::target
