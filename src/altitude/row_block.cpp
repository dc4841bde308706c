#include "row_block.h"

#include <Eigen/Cholesky>
#include <map>

namespace furrow::altitude {
namespace {

/// d(residual) / d(slope) at a point on the line: q . p over the length of the line's normal.
double residual_per_slope(const RowAxes<double>& axes, double slope, const Eigen::Vector2d& p) {
  const Vector3<double> l = line_at(axes, slope);
  return (axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z) / std::hypot(l.x, l.y);
}

}  // namespace

std::vector<RowBlock> group_by_row(const std::vector<EdgeLine>& lines) {
  std::map<int, RowBlock> blocks;
  for (const EdgeLine& line : lines) {
    blocks[line.row].row = line.row;
    blocks[line.row].lines.push_back(line);
  }
  std::vector<RowBlock> result;
  for (auto& [row, block] : blocks) result.push_back(std::move(block));
  return result;
}

BlockCovariance block_covariance(const RowBlock& block, const std::vector<LinePlace>& places,
                                 const RowAxes<double>& axes, const RowWander& wander) {
  const int n = block.residuals();
  BlockCovariance c{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n)};
  Eigen::VectorXd planting(n);
  for (std::size_t i = 0; i < block.lines.size(); ++i) {
    const int at = 2 * static_cast<int>(i);
    Eigen::Vector2d per_slope;
    for (int j = 0; j < 2; ++j) {
      const int part = at + j;
      per_slope[j] = residual_per_slope(axes, places[i].slope, block.lines[i].points[j]);
      planting[part] = per_slope[j] * wander.planting_sigma_m / places[i].drop_m;
      c.picture(part, part) = block.lines[i].variance[j];
    }
    c.picture(at, at + 1) = c.picture(at + 1, at) = block.lines[i].covariance;
    const double growth_slope = wander.growth_sigma_m / places[i].drop_m;
    const double own =
        growth_slope * growth_slope + places[i].extra_slope_sigma * places[i].extra_slope_sigma;
    c.plants.block<2, 2>(at, at) += own * per_slope * per_slope.transpose();
  }
  c.plants += planting * planting.transpose();
  return c;
}

Eigen::MatrixXd whitener_of(const BlockCovariance& covariance) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance.picture + covariance.plants);
  return factor.matrixL().solve(
      Eigen::MatrixXd::Identity(covariance.picture.rows(), covariance.picture.cols()));
}

}  // namespace furrow::altitude
