#include "calib/solve.h"

#include <ceres/ceres.h>

#include <cmath>
#include <Eigen/Cholesky>

namespace furrow::calib {
namespace {

/// The reprojection errors of one view: parameter blocks shared and pose, analytic Jacobians.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const SharedModel& model, const SolveView& view) : model_(model), view_(view) {
    set_num_residuals(static_cast<int>(2 * view.seen.px.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(model.basis.cols()));
    mutable_parameter_block_sizes()->push_back(6);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::VectorXd shared = Eigen::Map<const Eigen::VectorXd>(parameters[0], model_.basis.cols());
    const PoseVector pose = Eigen::Map<const PoseVector>(parameters[1]);
    return evaluate_view(model_, shared, pose, view_.seen, view_.weight, residuals,
                         jacobians != nullptr ? jacobians[0] : nullptr,
                         jacobians != nullptr ? jacobians[1] : nullptr);
  }

 private:
  const SharedModel& model_;
  const SolveView& view_;
};

ceres::Solver::Options solver_options(const SolveOptions& options) {
  ceres::Solver::Options out;
  out.linear_solver_type = ceres::DENSE_SCHUR;
  out.max_num_iterations = options.max_iterations;
  // |change of cost| / cost below this ends the solve: 1e-12 of a 0.2 px RMS is 1e-13 px.
  out.function_tolerance = 1e-12;
  out.parameter_tolerance = 1e-12;
  out.gradient_tolerance = 1e-14;
  // One thread: sums in one order, so the same input gives the same bytes on any machine.
  out.num_threads = 1;
  out.logging_type = ceres::SILENT;
  return out;
}

}  // namespace

Solved solve(const SharedModel& model, const Eigen::VectorXd& start, const std::vector<SolveView>& views,
             const SolveOptions& options) {
  Solved out;
  out.shared = start;
  for (const SolveView& view : views) out.poses.push_back(view.pose);
  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (std::size_t i = 0; i < views.size(); ++i) {
    problem.AddResidualBlock(new ViewCost(model, views[i]), nullptr, out.shared.data(), out.poses[i].data());
    ordering->AddElementToGroup(out.poses[i].data(), 0);
  }
  ordering->AddElementToGroup(out.shared.data(), 1);
  ceres::Solver::Options settings = solver_options(options);
  settings.linear_solver_ordering.reset(ordering);
  ceres::Solver::Summary summary;
  ceres::Solve(settings, &problem, &summary);
  out.converged = summary.termination_type == ceres::CONVERGENCE && out.shared.allFinite();
  out.iterations = static_cast<int>(summary.iterations.size());
  out.termination = summary.message;
  return out;
}

Information information(const SharedModel& model, const Solved& solved, const std::vector<SolveView>& views) {
  Information out;
  const Eigen::Index m = model.basis.cols();
  out.shared.setZero(m, m);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const auto rows = static_cast<Eigen::Index>(2 * views[i].seen.px.size());
    Eigen::VectorXd residual(rows);
    RowMajor a(rows, m), b(rows, 6);
    if (!evaluate_view(model, solved.shared, solved.poses[i], views[i].seen, views[i].weight, residual.data(),
                       a.data(), b.data())) {
      return out;
    }
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> pose_normal(b.transpose() * b);
    if (pose_normal.info() != Eigen::Success || !pose_normal.isPositive()) return out;
    out.pose_inverse.push_back(pose_normal.solve(Eigen::Matrix<double, 6, 6>::Identity()));
    out.pose_tie.push_back(pose_normal.solve(b.transpose() * a));
    const RowMajor left = a - b * out.pose_tie.back();
    out.view_gain.push_back(left.transpose() * left);
    out.shared += out.view_gain.back();
    out.squared_sum += residual.squaredNorm();
    for (std::size_t c = 0; c < views[i].seen.px.size(); ++c) {
      out.residuals += views[i].weight.empty() || views[i].weight[c] > 0.0 ? 2 : 0;
    }
  }
  out.usable = out.shared.allFinite();
  return out;
}

Eigen::MatrixXd drift_covariance(const Information& information, const Solved& solved,
                                 const Eigen::MatrixXd& shared_covariance) {
  const Eigen::Index m = shared_covariance.rows();
  const double share = 1.0 / static_cast<double>(solved.poses.size());
  // A pose follows the shared parameters by -tie and scatters about that by its own inverse.
  Eigen::Matrix<double, 6, Eigen::Dynamic> follows = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, m);
  Eigen::Matrix<double, 6, 6> scatter = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t i = 0; i < solved.poses.size(); ++i) {
    const Eigen::Matrix<double, 6, 6> drift = drift_of_pose(solved.poses[i]);
    follows -= share * drift * information.pose_tie[i];
    scatter += share * share * drift * information.pose_inverse[i] * drift.transpose();
  }
  Eigen::MatrixXd out(m + 6, m + 6);
  out.topLeftCorner(m, m) = shared_covariance;
  out.bottomLeftCorner(6, m) = follows * shared_covariance;
  out.topRightCorner(m, 6) = out.bottomLeftCorner(6, m).transpose();
  out.bottomRightCorner<6, 6>() = follows * shared_covariance * follows.transpose() + scatter;
  return out;
}

}  // namespace furrow::calib
