#include "target/grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "furrow/base/text.h"
#include "target/misfit.h"

namespace furrow::target {
namespace {

/// Grey value at a place, by bilinear interpolation; the border is carried outwards.
double grey_at(const Image& grey, const Eigen::Vector2d& px) {
  const double u = std::clamp(px.x(), 0.0, grey.width - 1.001),
               v = std::clamp(px.y(), 0.0, grey.height - 1.001);
  const int iu = static_cast<int>(u), iv = static_cast<int>(v);
  const double a = u - iu, b = v - iv;
  if (grey.width < 2 || grey.height < 2) return *grey.at(iu, iv);
  return (1 - b) * ((1 - a) * *grey.at(iu, iv) + a * *grey.at(iu + 1, iv)) +
         b * ((1 - a) * *grey.at(iu, iv + 1) + a * *grey.at(iu + 1, iv + 1));
}

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Mean of five samples about the middle of the square whose corners are a b d c.
double square_grey(const Image& grey, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                   const Eigen::Vector2d& c, const Eigen::Vector2d& d) {
  const Eigen::Vector2d middle = 0.25 * (a + b + c + d);
  double sum = grey_at(grey, middle);
  for (const Eigen::Vector2d& corner : {a, b, c, d}) sum += grey_at(grey, 0.6 * middle + 0.4 * corner);
  return sum / 5.0;
}

/// Grey of the square between corners (i, j) and (i + 1, j + 1); those just outside the grid are reached by
/// continuing its edges.
double square_grey(const Grid& grid, const Image& grey, int i, int j) {
  const auto corner = [&](int a, int b) {
    const int ca = std::clamp(a, 0, grid.columns - 1), cb = std::clamp(b, 0, grid.rows - 1);
    Eigen::Vector2d px = grid.at(ca, cb);
    if (a < 0) px += grid.at(0, cb) - grid.at(1, cb);
    if (a >= grid.columns) px += grid.at(ca, cb) - grid.at(ca - 1, cb);
    if (b < 0) px += grid.at(ca, 0) - grid.at(ca, 1);
    if (b >= grid.rows) px += grid.at(ca, cb) - grid.at(ca, cb - 1);
    return px;
  };
  return square_grey(grey, corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1));
}

/// Whether the square before the first corner is darker than those beside it.
bool starts_black(const Grid& grid, const Image& grey) {
  const double own = square_grey(grid, grey, -1, -1) + square_grey(grid, grey, 0, 0);
  return own < square_grey(grid, grey, 0, -1) + square_grey(grid, grey, -1, 0);
}

/// Sign of the turn from x to y that all squares share; 0 when they do not.
int common_turn(const Grid& grid) {
  int turn = 0;
  for (int j = 0; j + 1 < grid.rows; ++j) {
    for (int i = 0; i + 1 < grid.columns; ++i) {
      const Eigen::Vector2d a = grid.at(i, j), b = grid.at(i + 1, j), c = grid.at(i, j + 1),
                            d = grid.at(i + 1, j + 1);
      for (const double area :
           {cross(b - a, c - a), cross(d - b, a - b), cross(c - d, b - d), cross(a - c, d - c)}) {
        if (area == 0.0 || !std::isfinite(area)) return 0;
        const int sign = area > 0.0 ? 1 : -1;
        if (turn != 0 && sign != turn) return 0;
        turn = sign;
      }
    }
  }
  return turn;
}

/// Share of inner squares whose grey lies on the right side of their neighbours'.
double alternating_share(const Grid& grid, const Image& grey) {
  int right = 0, count = 0;
  std::array<double, 2> sum{0.0, 0.0};
  for (int j = 0; j + 1 < grid.rows; ++j) {
    for (int i = 0; i + 1 < grid.columns; ++i) sum[(i + j) % 2] += square_grey(grid, grey, i, j);
  }
  const int dark = sum[0] < sum[1] ? 0 : 1;  // by the sums, near enough: the counts differ by one at most
  for (int j = 0; j + 1 < grid.rows; ++j) {
    for (int i = 0; i + 1 < grid.columns; ++i) {
      const double own = square_grey(grid, grey, i, j);
      double others = 0.0;
      int n = 0;
      for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        if (i + di < 0 || j + dj < 0 || i + di + 1 >= grid.columns || j + dj + 1 >= grid.rows) continue;
        others += square_grey(grid, grey, i + di, j + dj);
        ++n;
      }
      if (n == 0) continue;
      ++count;
      right += ((own < others / n) == ((i + j) % 2 == dark)) ? 1 : 0;
    }
  }
  return count > 0 ? static_cast<double>(right) / count : 0.0;
}

/// Mean grey of 3 x 3 pixels about a place; nothing outside the picture.
std::optional<double> patch_grey(const Image& grey, const Eigen::Vector2d& px) {
  if (!(px.x() >= 1.0 && px.y() >= 1.0 && px.x() < grey.width - 2 && px.y() < grey.height - 2))
    return std::nullopt;
  double sum = 0.0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) sum += grey_at(grey, px + Eigen::Vector2d(du, dv));
  }
  return sum / 9.0;
}

/// The step from a corner to its neighbour in the way (di, dj); beyond the grid the one before, carried on.
Eigen::Vector2d step_px(const Grid& grid, int i, int j, int di, int dj) {
  const bool inside = i + di >= 0 && j + dj >= 0 && i + di < grid.columns && j + dj < grid.rows;
  return inside ? Eigen::Vector2d(grid.at(i + di, j + dj) - grid.at(i, j))
                : Eigen::Vector2d(grid.at(i, j) - grid.at(i - di, j - dj));
}

/// Whether four squares meet at a corner, dark and bright by turns, those beyond the grid included: the outer
/// corners of the outer squares are no corners of the board.
bool four_squares_meet(const Grid& grid, const Image& grey, int i, int j) {
  constexpr double kShare = 0.28;  // of a square: outer squares are often cut to half
  std::array<std::vector<double>, 2> levels;
  for (const int a : {-1, 1}) {
    for (const int b : {-1, 1}) {
      const auto level =
          patch_grey(grey, grid.at(i, j) + kShare * (step_px(grid, i, j, a, 0) + step_px(grid, i, j, 0, b)));
      if (level) levels[a == b ? 0 : 1].push_back(*level);
    }
  }
  if (levels[0].empty() || levels[1].empty()) return true;  // at the picture's edge nothing can be said
  const auto [low_a, high_a] = std::minmax_element(levels[0].begin(), levels[0].end());
  const auto [low_b, high_b] = std::minmax_element(levels[1].begin(), levels[1].end());
  const double gap = std::max(*low_a - *high_b, *low_b - *high_a);
  const double contrast = std::max(*high_a, *high_b) - std::min(*low_a, *low_b);
  constexpr double kSmallestGap = 0.3;  // of the contrast; blur and shading leave more, paper and noise less
  return gap > kSmallestGap * contrast;
}

/// Whether most corners of an outer row or column are none: a lattice that begins a square too early. Single
/// ones drown in glare.
bool has_line_too_many(const Grid& grid, const Image& grey) {
  const auto bad = [&](int i, int j) { return four_squares_meet(grid, grey, i, j) ? 0 : 1; };
  int left = 0, right = 0, top = 0, bottom = 0;
  for (int j = 0; j < grid.rows; ++j) {
    left += bad(0, j);
    right += bad(grid.columns - 1, j);
  }
  for (int i = 0; i < grid.columns; ++i) {
    top += bad(i, 0);
    bottom += bad(i, grid.rows - 1);
  }
  return 2 * std::max(left, right) > grid.rows || 2 * std::max(top, bottom) > grid.columns;
}

constexpr double kNoFit = std::numeric_limits<double>::infinity();

/// Largest misfit of a corner, squares; kNoFit where no plane fits.
double worst_misfit(const Grid& grid, int width, int height) {
  std::vector<Eigen::Vector2d> board;
  for (int j = 0; j < grid.rows; ++j) {
    for (int i = 0; i < grid.columns; ++i) board.emplace_back(i, j);
  }
  double worst = 0.0;
  const std::vector<double> misfit = plane_misfit(board, grid.px, width, height);
  for (const double one : misfit) worst = std::isfinite(one) ? std::max(worst, one) : kNoFit;
  return misfit.empty() ? kNoFit : worst;
}

}  // namespace

Grid transposed(const Grid& grid) {
  Grid out{grid.rows, grid.columns, {}};
  for (int j = 0; j < out.rows; ++j) {
    for (int i = 0; i < out.columns; ++i) out.px.push_back(grid.at(j, i));
  }
  return out;
}

Grid reversed_rows(const Grid& grid) {
  Grid out{grid.columns, grid.rows, {}};
  for (int j = grid.rows - 1; j >= 0; --j) {
    for (int i = 0; i < grid.columns; ++i) out.px.push_back(grid.at(i, j));
  }
  return out;
}

Grid reversed_columns(const Grid& grid) {
  return transposed(reversed_rows(transposed(grid)));
}

double nearest_neighbour_px(const Grid& grid, int i, int j) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [di, dj] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    if (i + di < 0 || j + dj < 0 || i + di >= grid.columns || j + dj >= grid.rows) continue;
    nearest = std::min(nearest, (grid.at(i + di, j + dj) - grid.at(i, j)).norm());
  }
  return nearest;
}

Grid oriented(const Grid& grid, int columns, int rows, const Image& grey) {
  std::vector<Grid> ways;
  for (const Grid& turned : {grid, transposed(grid)}) {
    if (turned.columns != columns || turned.rows != rows) continue;
    for (const Grid& way :
         {turned, reversed_rows(turned), reversed_columns(turned), reversed_rows(reversed_columns(turned))}) {
      // Pixel v runs down, so a positive turn from x to y puts x cross y away from the camera.
      if (common_turn(way) > 0) ways.push_back(way);
    }
  }
  if (ways.empty()) return {};
  const bool any_black =
      std::any_of(ways.begin(), ways.end(), [&](const Grid& way) { return starts_black(way, grey); });
  const Grid* best = nullptr;
  for (const Grid& way : ways) {
    if (any_black && !starts_black(way, grey)) continue;
    if (best == nullptr || way.px.front().sum() < best->px.front().sum()) best = &way;
  }
  return *best;
}

std::string grid_fault(const Grid& grid, const Image& grey, double largest_misfit) {
  if (common_turn(grid) == 0) return "its squares overlap";
  const double misfit = worst_misfit(grid, grey.width, grey.height);
  if (misfit > largest_misfit) {
    return "a corner lies " + base::format_fixed(misfit, 2) +
           " squares from where the board's homography puts it";
  }
  if (has_line_too_many(grid, grey)) return "along one of its sides no four squares meet";
  if (alternating_share(grid, grey) < 1.0) return "its squares do not alternate between dark and bright";
  return "";
}

}  // namespace furrow::target
