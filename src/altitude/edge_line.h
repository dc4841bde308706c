#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/altitude/unit_plane.h"

namespace furrow::altitude {

enum class Side { left, right, centre };

/// One straight edge (or centre line) of one row, reduced to two points of the unit plane that say as much as
/// all its samples: the perpendicular errors of the two are independent, with `sigma` each
/// (docs/formulation/altitude.md, section 4).
struct EdgeLine {
  int row = 0;  ///< index of the row
  Side side = Side::centre;
  Eigen::Vector2d points[2];
  double sigma = 0.0;
  int samples = 0;
};

/// All edges of a shot as lines; rows without any edge give their centre line. Where the samples scatter more
/// than they claim, or are correlated along the row, the sigmas say so. Lines of fewer than two samples are
/// left out.
std::vector<EdgeLine> reduce_to_lines(const RowsOnUnitPlane& rows);

}  // namespace furrow::altitude
