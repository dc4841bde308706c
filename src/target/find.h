#pragma once
#include <string>

#include "target/grid.h"
#include "target/search_work.h"

namespace furrow::target {

/// What a search saw: a grid good to a pixel or two, in no particular orientation, or how much of one.
struct Found {
  Grid grid;                  ///< empty when none of the wanted size is there
  int columns = 0, rows = 0;  ///< the largest lattice seen, longer side first
  std::string
      fault;  ///< why `grid` is no checkerboard's (grid_fault), if every size of the picture gave such a one
  bool complete = false;  ///< whether every corner of that lattice is there
};

/// Looks for columns x rows corners: saddles of brightness with four edges, joined along their edges into
/// lattices (docs/formulation/ calibration.md). Counts what it costs, and stops where `work` ends.
Found find_grid(const Image& grey, int columns, int rows, SearchWork& work);

/// The largest whole grid in the picture whose squares alternate and lie on a plane, whatever its counts;
/// empty when there is none of at least 3 x 3.
Grid find_any_grid(const Image& grey);

}  // namespace furrow::target
