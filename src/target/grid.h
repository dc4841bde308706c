#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "furrow/image/image.h"

namespace furrow::target {

/// A lattice of corners as found in a picture, row by row.
struct Grid {
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> px;

  const Eigen::Vector2d& at(int i, int j) const { return px[index(i, j)]; }
  std::size_t index(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i);
  }
};

/// Quarter turns and mirror images of the same corners.
Grid transposed(const Grid& grid);
Grid reversed_rows(const Grid& grid);
Grid reversed_columns(const Grid& grid);

/// Distance to the nearest of the four neighbours, px.
double nearest_neighbour_px(const Grid& grid, int i, int j);

/// The grid turned to `columns` x `rows` as detect_board() promises; empty when its counts are neither that
/// nor its transpose. `grey` decides which square before the first corner is black.
Grid oriented(const Grid& grid, int columns, int rows, const Image& grey);

/// Why this is not a checkerboard's grid, in words; empty when it is one: squares that do not overlap,
/// corners within `largest_misfit` squares of the board's homography and distortion, dark and bright by
/// turns.
std::string grid_fault(const Grid& grid, const Image& grey, double largest_misfit);

}  // namespace furrow::target
