#include "calib/view_information.h"

#include <Eigen/Dense>

namespace furrow::calib {
namespace {

SharedModel all_free(const Camera& camera, const target::BoardSpec& board, const Eigen::Vector2d& warp_m) {
  FreeTerms free;
  free.aspect = free.warp = true;
  free.distortion = static_cast<int>(camera.distortion.size());
  return make_shared_model(camera, board, warp_m, free);
}

}  // namespace

std::optional<ViewInformation> view_information(const Camera& camera, const target::BoardSpec& board,
                                                const Eigen::Vector2d& warp_m, const PoseVector& pose,
                                                const std::vector<int>& ids,
                                                const std::vector<double>& weight) {
  const SharedModel model = all_free(camera, board, warp_m);
  SeenCorners seen;
  seen.ids = ids;
  // Only derivatives are asked for; where the corners were seen does not enter them.
  seen.px.assign(ids.size(), Eigen::Vector2d::Zero());
  const auto rows = static_cast<Eigen::Index>(2 * ids.size());
  Eigen::VectorXd residual(rows);
  RowMajor a(rows, model.count), b(rows, 6);
  if (!evaluate_view(model, shared_of(model), pose, seen, weight, residual.data(), a.data(), b.data()))
    return std::nullopt;
  ViewInformation out;
  for (Eigen::Index i = 0; i < model.count; ++i) {
    if ((a.col(i).array() != 0.0).any()) out.place.push_back(i);
  }
  RowMajor own(rows, static_cast<Eigen::Index>(out.place.size()));
  for (std::size_t i = 0; i < out.place.size(); ++i)
    own.col(static_cast<Eigen::Index>(i)) = a.col(out.place[i]);
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> pose_normal(b.transpose() * b);
  if (pose_normal.info() != Eigen::Success || !pose_normal.isPositive()) return std::nullopt;
  own -= b * pose_normal.solve(b.transpose() * own).eval();
  out.matrix = own.transpose() * own;
  return out;
}

Eigen::MatrixXd part_of(const Eigen::MatrixXd& all, const std::vector<Eigen::Index>& place) {
  const auto n = static_cast<Eigen::Index>(place.size());
  Eigen::MatrixXd out(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j)
      out(i, j) = all(place[static_cast<std::size_t>(i)], place[static_cast<std::size_t>(j)]);
  }
  return out;
}

std::optional<Eigen::MatrixXd> information_step(const ViewInformation& view,
                                                const Eigen::MatrixXd& covariance, double sign) {
  const Eigen::MatrixXd& g = view.matrix;
  const Eigen::MatrixXd inner =
      Eigen::MatrixXd::Identity(g.rows(), g.cols()) + sign * part_of(covariance, view.place) * g;
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(inner.transpose());
  // Below this the rest of the views leaves a combination to rounding noise.
  constexpr double kSmallestCondition = 1e-12;
  if (!(lu.rcond() > kSmallestCondition) || !(lu.determinant() > 0.0)) return std::nullopt;
  return Eigen::MatrixXd(lu.solve(g.transpose()).transpose());
}

}  // namespace furrow::calib
