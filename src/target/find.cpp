#include "target/find.h"

#include <algorithm>
#include <vector>

#include "target/lattice.h"

namespace furrow::target {
namespace {

/// Longest side at which the search starts, px: most boards are seen there, fast. Then finer (small squares),
/// then coarser (blur).
constexpr int kFirstSidePx = 640;
/// Below this a board's squares have no room for four edges.
constexpr int kSmallestSidePx = 80;

/// Unrefined corners stray by a pixel or so of small squares; a wrong saddle lies half a square off.
constexpr double kLargestMisfit = 0.25;

Grid to_grid(const Lattice& lattice) {
  const Extent e = extent(lattice);
  Grid grid{e.columns, e.rows, {}};
  for (int j = 0; j < e.rows; ++j) {
    for (int i = 0; i < e.columns; ++i) grid.px.push_back(lattice.at({e.i0 + i, e.j0 + j}));
  }
  return grid;
}

bool is_full(const Lattice& lattice) {
  const Extent e = extent(lattice);
  return lattice.size() == static_cast<std::size_t>(e.columns) * static_cast<std::size_t>(e.rows);
}

bool has_counts(const Extent& e, int columns, int rows) {
  return (e.columns == columns && e.rows == rows) || (e.columns == rows && e.rows == columns);
}

/// Area that a grid covers, px^2, by its outer corners.
double area_px2(const Grid& grid) {
  const Eigen::Vector2d a = grid.at(grid.columns - 1, grid.rows - 1) - grid.at(0, 0);
  const Eigen::Vector2d b = grid.at(0, grid.rows - 1) - grid.at(grid.columns - 1, 0);
  return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
}

/// Search at one size of the picture.
Found find_at_scale(const Image& grey, int columns, int rows, SearchWork& work) {
  const SmoothGrey smoothed = smooth(grey);
  const std::vector<Saddle> saddles = find_saddles(smoothed, work);
  Found out;
  // Lattices of fewer corners than a quarter of the board are clutter; so is one of which a quarter had to be
  // cut off.
  const std::size_t fewest = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) / 4;
  constexpr double kMostCutOff = 0.25;
  double largest_px2 = 0.0;
  for (const Lattice& seen : join_seeds(smoothed, find_corner_seeds(smoothed, saddles), work)) {
    if (seen.size() < fewest) break;
    const Lattice lattice = completed(seen, saddles, columns, rows, work);
    const Extent e = extent(lattice);
    const bool full = is_full(lattice);
    const bool cut =
        static_cast<double>(lattice.size()) < (1.0 - kMostCutOff) * static_cast<double>(seen.size());
    if (full && !cut && has_counts(e, columns, rows)) {
      const Grid grid = to_grid(lattice);
      const std::string fault = grid_fault(grid, grey, kLargestMisfit);
      // Of several, the largest that is whole: keyboards and cloth make small ones.
      const bool better = fault.empty() ? area_px2(grid) > largest_px2 : out.grid.px.empty();
      if (better) {
        out.grid = grid;
        out.fault = fault;
        if (fault.empty()) largest_px2 = area_px2(grid);
      }
    }
    if (!cut && e.columns * e.rows > out.columns * out.rows) {
      out.columns = std::max(e.columns, e.rows);
      out.rows = std::min(e.columns, e.rows);
      out.complete = full;
    }
  }
  return out;
}

/// Copies of the picture, in the order in which they are searched.
std::vector<double> scales(const Image& grey) {
  const int longest = std::max(grey.width, grey.height);
  const double first = longest > kFirstSidePx ? static_cast<double>(kFirstSidePx) / longest : 1.0;
  std::vector<double> out{first};
  if (first < 1.0) out.push_back(1.0);
  out.push_back(0.5 * first);
  out.push_back(0.25 * first);
  return out;
}

}  // namespace

Found find_grid(const Image& grey, int columns, int rows, SearchWork& work) {
  Found best;
  for (const double scale : scales(grey)) {
    const int width = static_cast<int>(std::lround(grey.width * scale)),
              height = static_cast<int>(std::lround(grey.height * scale));
    if (std::max(width, height) < kSmallestSidePx || std::min(width, height) < 1) continue;
    if (!work.spend(static_cast<std::int64_t>(width) * height)) break;
    Found found = find_at_scale(scale < 1.0 ? image::resize(grey, width, height) : grey, columns, rows, work);
    if (!found.grid.px.empty() && (found.fault.empty() || best.grid.px.empty())) {
      const double su = static_cast<double>(grey.width) / width,
                   sv = static_cast<double>(grey.height) / height;
      for (Eigen::Vector2d& p : found.grid.px) p = {(p.x() + 0.5) * su - 0.5, (p.y() + 0.5) * sv - 0.5};
      if (found.fault.empty()) return found;
      best = found;
    }
    if (best.grid.px.empty() && found.columns * found.rows > best.columns * best.rows) best = found;
  }
  return best;
}

Grid find_any_grid(const Image& grey) {
  SearchWork work;
  Grid best;
  constexpr int kFewestCorners = 3;
  for (const double scale : scales(grey)) {
    const int width = static_cast<int>(std::lround(grey.width * scale)),
              height = static_cast<int>(std::lround(grey.height * scale));
    if (std::max(width, height) < kSmallestSidePx || std::min(width, height) < 1) continue;
    const Image picture = scale < 1.0 ? image::resize(grey, width, height) : grey;
    const SmoothGrey smoothed = smooth(picture);
    const std::vector<Saddle> saddles = find_saddles(smoothed, work);
    const std::vector<Lattice> lattices = join_seeds(smoothed, find_corner_seeds(smoothed, saddles), work);
    if (lattices.empty()) continue;
    // Wanting nothing larger, completed() only trims and fills.
    const Lattice lattice = completed(lattices.front(), saddles, 0, 0, work);
    const Extent e = extent(lattice);
    if (e.columns < kFewestCorners || e.rows < kFewestCorners || !is_full(lattice)) continue;
    Grid grid = to_grid(lattice);
    if (grid.px.size() <= best.px.size() || !grid_fault(grid, picture, kLargestMisfit).empty()) continue;
    best = std::move(grid);
  }
  return best;
}

}  // namespace furrow::target
