#include "furrow/target/homography.h"

#include <Eigen/Dense>

#include "furrow/base/result.h"

namespace furrow::target {
namespace {

/// Carries points to mean 0 and mean distance sqrt(2); zero scale when they all coincide.
Eigen::Matrix3d normalisation(const std::vector<Eigen::Vector2d>& points) {
  const double n = static_cast<double>(points.size());
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) mean += p / n;
  double spread = 0.0;
  for (const Eigen::Vector2d& p : points) spread += (p - mean).norm() / n;
  const double scale = spread > 0.0 ? std::sqrt(2.0) / spread : 0.0;
  Eigen::Matrix3d out;
  out << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return out;
}

}  // namespace

std::optional<Eigen::Matrix3d> fit_homography(const std::vector<Eigen::Vector2d>& board,
                                              const std::vector<Eigen::Vector2d>& px) {
  check(board.size() == px.size(), "fit_homography: as many board points as pixels");
  if (board.size() < 4) return std::nullopt;
  const Eigen::Matrix3d from_board = normalisation(board), from_px = normalisation(px);
  if (!(from_board(0, 0) > 0.0) || !(from_px(0, 0) > 0.0) || !from_board.allFinite() || !from_px.allFinite())
    return std::nullopt;
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < board.size(); ++i) {
    const Eigen::Vector3d x = from_board * board[i].homogeneous();
    const Eigen::Vector3d q = from_px * px[i].homogeneous();
    Eigen::Matrix<double, 2, 9> rows = Eigen::Matrix<double, 2, 9>::Zero();
    rows.block<1, 3>(0, 0) = x.transpose();
    rows.block<1, 3>(1, 3) = x.transpose();
    rows.block<1, 3>(0, 6) = -q.x() * x.transpose();
    rows.block<1, 3>(1, 6) = -q.y() * x.transpose();
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
  // Points in a line leave a second way to satisfy every equation.
  constexpr double kSecondShare = 1e-12;
  if (!(eigen.eigenvalues()[1] > kSecondShare * eigen.eigenvalues()[8])) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> h = eigen.eigenvectors().col(0);
  Eigen::Matrix3d normalised;
  normalised << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  const Eigen::Matrix3d out = from_px.inverse() * normalised * from_board;
  return out / out.norm();
}

}  // namespace furrow::target
