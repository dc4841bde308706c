#include "target/misfit.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>

#include "furrow/target/homography.h"

namespace furrow::target {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Pixels after a division model about the picture's middle (Fitzgibbon 2001): straight lines become straight
/// whatever the lens.
Points straightened(const Points& px, const Eigen::Vector2d& middle, double bend_per_px2) {
  Points out;
  for (const Eigen::Vector2d& p : px) {
    const Eigen::Vector2d d = p - middle;
    out.push_back(middle + d / (1.0 + bend_per_px2 * d.squaredNorm()));
  }
  return out;
}

/// Distance of each point from the homography, as a share of the board's unit there.
struct Misfit {
  double rms = std::numeric_limits<double>::infinity();
  Eigen::MatrixXd by_point;  ///< n x 2
};

Misfit homography_misfit(const Points& board, const Points& straight) {
  const auto h = fit_homography(board, straight);
  if (!h) return {};
  const auto at = [&](double x, double y) -> Eigen::Vector2d {
    return (*h * Eigen::Vector3d(x, y, 1.0)).hnormalized();
  };
  Misfit out;
  out.by_point.resize(static_cast<Eigen::Index>(board.size()), 2);
  for (std::size_t i = 0; i < board.size(); ++i) {
    const double x = board[i].x(), y = board[i].y();
    const Eigen::Vector2d own = at(x, y);
    const double unit_px =
        0.5 * std::min((at(x + 1, y) - at(x - 1, y)).norm(), (at(x, y + 1) - at(x, y - 1)).norm());
    out.by_point.row(static_cast<Eigen::Index>(i)) = (straight[i] - own).transpose() / unit_px;
  }
  const double rms = std::sqrt(out.by_point.rowwise().squaredNorm().mean());
  if (std::isfinite(rms)) out.rms = rms;
  return out;
}

Misfit best_misfit(const Points& board, const Points& px, int width, int height) {
  const Eigen::Vector2d middle(0.5 * (width - 1), 0.5 * (height - 1));
  Misfit best;
  // From a pincushion to a fisheye, in steps whose rest the cubic takes up.
  constexpr double kFrom = -0.9, kTo = 0.5, kStep = 0.1;
  for (double bend = kFrom; bend <= kTo; bend += kStep) {
    Misfit misfit = homography_misfit(board, straightened(px, middle, bend / middle.squaredNorm()));
    if (misfit.rms < best.rms) best = std::move(misfit);
  }
  return best;
}

/// How many different values a coordinate takes.
std::size_t levels(const Points& board, int axis) {
  std::vector<double> values;
  for (const Eigen::Vector2d& p : board) values.push_back(p[axis]);
  std::sort(values.begin(), values.end());
  constexpr double kSame = 1e-6;
  std::size_t count = values.empty() ? 0 : 1;
  for (std::size_t i = 1; i < values.size(); ++i) count += values[i] - values[i - 1] > kSame ? 1 : 0;
  return count;
}

/// Terms of the smooth rest that the points can tell from a point of its own: cubic, quadratic or none.
Eigen::Index rest_terms(const Points& board) {
  const std::size_t fewest = std::min(levels(board, 0), levels(board, 1));
  if (fewest > 3 && board.size() >= 16) return 10;
  return fewest > 2 && board.size() >= 9 ? 6 : 0;
}

Eigen::MatrixXd rest_basis(const Points& board, Eigen::Index terms) {
  Eigen::Vector2d low = board.front(), high = board.front();
  for (const Eigen::Vector2d& p : board) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  Eigen::MatrixXd basis(static_cast<Eigen::Index>(board.size()), terms);
  for (std::size_t i = 0; i < board.size(); ++i) {
    const Eigen::Vector2d at = 2.0 * (board[i] - low).cwiseQuotient(high - low).array() - 1.0;
    const double x = at.x(), y = at.y();
    Eigen::Matrix<double, 10, 1> all;
    all << 1, x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
    basis.row(static_cast<Eigen::Index>(i)) = all.head(terms).transpose();
  }
  return basis;
}

}  // namespace

std::vector<double> plane_misfit(const Points& board, const Points& px, int width, int height) {
  const Misfit best = best_misfit(board, px, width, height);
  if (!std::isfinite(best.rms)) return {};
  Eigen::MatrixXd rest = best.by_point;
  if (const Eigen::Index terms = rest_terms(board); terms > 0) {
    const Eigen::MatrixXd basis = rest_basis(board, terms);
    rest -= basis * basis.colPivHouseholderQr().solve(best.by_point);
  }
  const Eigen::VectorXd distance = rest.rowwise().norm();
  return {distance.data(), distance.data() + distance.size()};
}

}  // namespace furrow::target
