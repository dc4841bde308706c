#pragma once
#include <Eigen/Core>
#include <vector>

#include "edge_line.h"
#include "prism.h"

namespace furrow::altitude {

/// The lines of one row: one residual block, since a row's planting error is common to its edges.
struct RowBlock {
  int row = 0;
  std::vector<EdgeLine> lines;

  int residuals() const { return 2 * static_cast<int>(lines.size()); }
};

/// Lines grouped by row, in order of the index.
std::vector<RowBlock> group_by_row(const std::vector<EdgeLine>& lines);

/// Where the model puts one line: its slope, and the drop of the edge that is seen there.
struct LinePlace {
  double slope = 0.0;
  double drop_m = 1.0;
  double extra_slope_sigma = 0.0;  ///< of the model itself, e.g. which middle a detector means
};

/// How far a row's axis, its edges and the foot of its wall wander, metres.
struct RowWander {
  double planting_sigma_m = 0.0, growth_sigma_m = 0.0;
  double foot_sigma_m = 0.0;  ///< of the depth at which a near edge is seen
};

/// Covariance of a block's residuals on the unit plane (eq. 4.6): picture noise, then planting and growth.
struct BlockCovariance {
  Eigen::MatrixXd picture, plants;
};
BlockCovariance block_covariance(const RowBlock& block, const std::vector<LinePlace>& places,
                                 const RowAxes<double>& axes, const RowWander& wander);

/// Inverse of the lower Cholesky factor.
Eigen::MatrixXd whitener_of(const BlockCovariance& covariance);

}  // namespace furrow::altitude
