#include "furrow/target/artwork.h"

#include <algorithm>

#include "target/markers.h"

namespace furrow::target {
namespace {

/// The black squares of a checkerboard or a ChArUco board.
void add_squares(const BoardSpec& board, std::vector<Rectangle>& out) {
  const Eigen::Vector2d side(board.square_m, board.square_m * board.aspect);
  for (int j = 0; j <= board.corners_y; ++j) {
    for (int i = 0; i <= board.corners_x; ++i) {
      if (!is_black_square(board, i, j)) continue;
      out.push_back(
          {side.cwiseProduct(Eigen::Vector2d(i - 1, j - 1)), side.cwiseProduct(Eigen::Vector2d(i, j))});
    }
  }
}

/// The black modules of a marker, those beside each other as one.
void add_marker(const BoardSpec& board, int id, std::vector<Rectangle>& out) {
  const MarkerPrint print = print_marker(board, id);
  const auto corner = marker_in_board(board, id);
  const Eigen::Vector2d low = corner[0].cwiseMin(corner[2]), high = corner[0].cwiseMax(corner[2]);
  const Eigen::Vector2d module = (high - low) / print.side;
  for (int v = 0; v < print.side; ++v) {
    for (int u = 0; u < print.side; ++u) {
      const int first = u;
      while (u < print.side && !print.white[static_cast<std::size_t>(v * print.side + u)]) ++u;
      if (u > first) {
        out.push_back({low + module.cwiseProduct(Eigen::Vector2d(first, v)),
                       low + module.cwiseProduct(Eigen::Vector2d(u, v + 1))});
      }
    }
  }
}

/// The small squares between an AprilGrid's tags: they make every tag's corner one of four squares.
void add_gap_squares(const BoardSpec& board, std::vector<Rectangle>& out) {
  const Eigen::Vector2d gap(board.gap_m, board.gap_m * board.aspect);
  for (int j = 0; j <= board.corners_y; j += 2) {
    for (int i = 0; i <= board.corners_x; i += 2) {
      const Eigen::Vector2d high = corner_in_board(board, i, j).head<2>();
      out.push_back({high - gap, high});
    }
  }
}

std::vector<double> edges(const std::vector<Rectangle>& rectangles, int axis) {
  std::vector<double> out;
  for (const Rectangle& r : rectangles) {
    out.push_back(r.low_m[axis]);
    out.push_back(r.high_m[axis]);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::size_t place_in(const std::vector<double>& edges, double x) {
  return static_cast<std::size_t>(std::upper_bound(edges.begin(), edges.end(), x) - edges.begin());
}

}  // namespace

std::vector<Rectangle> black_rectangles(const BoardSpec& board) {
  std::vector<Rectangle> out;
  if (board.kind == BoardKind::aprilgrid) {
    add_gap_squares(board, out);
  } else {
    add_squares(board, out);
  }
  for (int id = 0; id < marker_count(board); ++id) add_marker(board, id, out);
  return out;
}

Artwork make_artwork(const BoardSpec& board) {
  const std::vector<Rectangle> rectangles = black_rectangles(board);
  Artwork out{edges(rectangles, 0), edges(rectangles, 1), {}};
  const std::size_t columns = out.x_edges_m.size() - 1;
  out.black.assign(columns * (out.y_edges_m.size() - 1), false);
  for (const Rectangle& r : rectangles) {
    const std::size_t i0 = place_in(out.x_edges_m, r.low_m.x()) - 1,
                      i1 = place_in(out.x_edges_m, r.high_m.x()) - 1;
    const std::size_t j0 = place_in(out.y_edges_m, r.low_m.y()) - 1,
                      j1 = place_in(out.y_edges_m, r.high_m.y()) - 1;
    for (std::size_t j = j0; j < j1; ++j) {
      for (std::size_t i = i0; i < i1; ++i) out.black[j * columns + i] = true;
    }
  }
  return out;
}

bool is_black(const Artwork& artwork, const Eigen::Vector2d& x_in_board) {
  const std::size_t i = place_in(artwork.x_edges_m, x_in_board.x()),
                    j = place_in(artwork.y_edges_m, x_in_board.y());
  if (i == 0 || j == 0 || i == artwork.x_edges_m.size() || j == artwork.y_edges_m.size()) return false;
  return artwork.black[(j - 1) * (artwork.x_edges_m.size() - 1) + i - 1];
}

}  // namespace furrow::target
