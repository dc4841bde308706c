#pragma once
#include <array>
#include <Eigen/Core>
#include <vector>

#include "furrow/altitude/unit_plane.h"

namespace furrow::altitude {

enum class Side { left, right, centre };

/// One straight edge (or centre line) of one row, reduced to two points of the unit plane that say as much as
/// all its samples (docs/formulation/altitude.md, section 4): where a line fitted to a gently curved row
/// meets that row. Their perpendicular errors have a `variance` each and a `covariance`.
struct EdgeLine {
  int row = 0;  ///< index of the row
  Side side = Side::centre;
  std::array<Eigen::Vector2d, 2> points;
  Eigen::Vector2d variance = Eigen::Vector2d::Zero();
  double covariance = 0.0;  ///< 0 for errors that are independent along the row
  int samples = 0;
  /// In the pencil: half widths from its row's axis to where its line of sight meets the plane of the
  /// outline's highest points, positive to the left (eq. 3.8).
  double reach = 0.0;
};

/// All edges of a shot as lines; rows without any edge give their centre line. Where the samples scatter more
/// than they claim, or are correlated along the row, the sigmas say so. Lines of fewer than two samples are
/// left out.
std::vector<EdgeLine> reduce_to_lines(const RowsOnUnitPlane& rows);

}  // namespace furrow::altitude
