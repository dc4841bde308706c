#pragma once
#include <vector>

#include "furrow/rows/planar_field.h"
#include "rows/comb.h"

namespace furrow::rows {

/// A field that may be in the picture, from the coarse search.
struct Trial {
  PlanarField field;   ///< px of the map, no bends
  double tooth = 0.3;  ///< width of a row, spacings
  double score = 0.0;  ///< explained variance, lowered where few rows carry it
};

/// A comb of n rows fits its phase and spacing to anything, so only n - 1 of n contrasts speak for it.
double evidence_part(double row_count);

/// The field's anchor: middle column, bottom row, the picture's height.
PlanarField anchored(const Strips& strips);

/// Trials for the whole picture, best first: for each convergence the strips are rectified so that rows are
/// parallel, sheared back, and summed along the rows; sums whose columns differ most are folded over
/// all spacings (epoch folding, as for pulsars).
std::vector<Trial> coarse_search(const Strips& strips);

}  // namespace furrow::rows
