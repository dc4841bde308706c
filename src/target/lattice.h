#pragma once
#include <map>
#include <utility>
#include <vector>

#include "target/saddle.h"

namespace furrow::target {

/// Corners that hang together, by their place in the board's own counting (some origin, some quarter turn).
using Lattice = std::map<std::pair<int, int>, Eigen::Vector2d>;

/// Joins seeds along their edges into lattices, largest first. None where `work` has no room for that.
std::vector<Lattice> join_seeds(const SmoothGrey& grey, const std::vector<CornerSeed>& seeds,
                                SearchWork& work);

/// The rectangle a lattice spans.
struct Extent {
  int i0 = 0, j0 = 0, columns = 0, rows = 0;
};
Extent extent(const Lattice& lattice);

/// Takes off corners that do not lie between their neighbours and outer rows and columns that are less than
/// half full, puts saddles into holes, and, while the lattice is smaller than columns x rows either way
/// round, adds outer rows all of whose corners are there. Stops where `work` ends.
Lattice completed(Lattice lattice, const std::vector<Saddle>& saddles, int columns, int rows,
                  SearchWork& work);

}  // namespace furrow::target
