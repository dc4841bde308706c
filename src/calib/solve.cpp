#include "calib/solve.h"

#include <ceres/ceres.h>
#include <glog/logging.h>

#include <cmath>
#include <Eigen/Cholesky>
#include <memory>

namespace furrow::calib {
namespace {

/// The reprojection errors of one view: parameter blocks shared and pose, analytic Jacobians.
class ViewCost : public ceres::CostFunction {
 public:
  ViewCost(const SharedModel& model, const SolveView& view) : model_(model), view_(view) {
    set_num_residuals(static_cast<int>(2 * view.seen.px.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(model.count));
    mutable_parameter_block_sizes()->push_back(6);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::VectorXd shared = Eigen::Map<const Eigen::VectorXd>(parameters[0], model_.count);
    const PoseVector pose = Eigen::Map<const PoseVector>(parameters[1]);
    return evaluate_view(model_, shared, pose, view_.seen, view_.weight, residuals,
                         jacobians != nullptr ? jacobians[0] : nullptr,
                         jacobians != nullptr ? jacobians[1] : nullptr);
  }

 private:
  const SharedModel& model_;
  const SolveView& view_;
};

/// Ceres tells standard error of every step that it takes back; how a solve ended stands in its result.
void keep_solver_quiet() {
  static const bool quiet = [] {
    FLAGS_minloglevel = google::GLOG_ERROR;
    return true;
  }();
  (void)quiet;
}

ceres::Solver::Options solver_options(const SolveOptions& options) {
  ceres::Solver::Options out;
  out.linear_solver_type = ceres::DENSE_SCHUR;
  out.max_num_iterations = options.max_iterations;
  // |change of cost| / cost below this ends the solve: 1e-12 of a 0.2 px RMS is 1e-13 px.
  out.function_tolerance = options.function_tolerance;
  out.parameter_tolerance = 1e-12;
  out.gradient_tolerance = 1e-14;
  // One thread: sums in one order, so the same input gives the same bytes on any machine.
  out.num_threads = 1;
  out.logging_type = ceres::SILENT;
  return out;
}

/// What is known beside the pictures, one residual a parameter.
class PriorCost : public ceres::CostFunction {
 public:
  PriorCost(const SharedModel& model, Eigen::Index first, Eigen::Index size)
      : model_(model), first_(first), size_(size) {
    set_num_residuals(static_cast<int>(size));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(size));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto weight = model_.prior_weight.segment(first_, size_),
               mean = model_.prior_mean.segment(first_, size_);
    Eigen::Map<Eigen::VectorXd>(residuals, size_) =
        weight.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(parameters[0], size_) - mean);
    if (jacobians != nullptr && jacobians[0] != nullptr)
      Eigen::Map<RowMajor>(jacobians[0], size_, size_) = weight.asDiagonal();
    return true;
  }

 private:
  const SharedModel& model_;
  Eigen::Index first_, size_;
};

/// One corner of a splined camera: parameter blocks pose, the knots of its patch (two numbers each), and the
/// board's bend when that is free.
class PatchCost : public ceres::SizedCostFunction<2, 6> {
 public:
  PatchCost(const SharedModel& model, Camera& scratch, const SolveView& view, int corner,
            const camera::SplinePatch& patch)
      : model_(model), scratch_(scratch), view_(view), corner_(corner), patch_(patch) {
    for (int i = 0; i < side() * side(); ++i) mutable_parameter_block_sizes()->push_back(2);
    if (has_warp()) mutable_parameter_block_sizes()->push_back(2);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const int knots = side() * side();
    for (int k = 0; k < knots; ++k) {
      scratch_.distortion[static_cast<std::size_t>(first_of(k))] = parameters[1 + k][0];
      scratch_.distortion[static_cast<std::size_t>(first_of(k) + 1)] = parameters[1 + k][1];
    }
    const Eigen::Vector2d warp_m = has_warp() ? Eigen::Map<const Eigen::Vector2d>(parameters[1 + knots])
                                              : Eigen::Vector2d(model_.full.tail<2>());
    const PoseVector pose = Eigen::Map<const PoseVector>(parameters[0]);
    const auto corner = static_cast<std::size_t>(corner_);
    const PatchCorner at =
        evaluate_patch_corner(model_, scratch_, pose, warp_m, corner_id(view_.seen.ids, corner), patch_);
    if (!at.seen) return false;
    const double w = view_.weight.empty() ? 1.0 : view_.weight[corner];
    Eigen::Map<Eigen::Vector2d> residual(residuals);
    residual = w * (at.seen->px - view_.seen.px[corner]);
    if (jacobians == nullptr) return true;
    put<6>(jacobians[0], w * at.d_pose);
    for (int k = 0; k < knots; ++k)
      put<2>(jacobians[1 + k], w * at.seen->d_intrinsics.middleCols<2>(4 + 2 * k));
    if (has_warp()) put<2>(jacobians[1 + knots], w * at.d_warp);
    return true;
  }
  /// Place in `shared` of knot `k` of the patch.
  int first_of(int k) const {
    return 2 * ((patch_.row + k / side()) * model_.camera.spline.columns + patch_.column + k % side());
  }
  int side() const { return model_.camera.spline.order + 1; }
  bool has_warp() const { return model_.column.back() >= 0; }

 private:
  /// Writes a Jacobian that Ceres asked for.
  template <int kColumns>
  static void put(double* to, const Eigen::Matrix<double, 2, kColumns>& value) {
    if (to == nullptr) return;
    Eigen::Map<Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>> map(to);
    map = value;
  }

  const SharedModel& model_;
  Camera& scratch_;  ///< evaluated one after the other, so one will do
  const SolveView& view_;
  int corner_;
  camera::SplinePatch patch_;
};

ceres::Problem::Options problem_options() {
  ceres::Problem::Options out;
  out.cost_function_ownership = ceres::TAKE_OWNERSHIP;
  return out;
}

void run(const SolveOptions& options, ceres::Problem& problem, Solved& out,
         const std::vector<double*>& shared_blocks) {
  keep_solver_quiet();
  auto* ordering = new ceres::ParameterBlockOrdering;
  for (PoseVector& pose : out.poses) ordering->AddElementToGroup(pose.data(), 0);
  for (double* block : shared_blocks) ordering->AddElementToGroup(block, 1);
  ceres::Solver::Options settings = solver_options(options);
  settings.linear_solver_ordering.reset(ordering);
  ceres::Solver::Summary summary;
  ceres::Solve(settings, &problem, &summary);
  out.converged = summary.termination_type == ceres::CONVERGENCE && out.shared.allFinite();
  out.iterations += static_cast<int>(summary.iterations.size());
  out.termination = summary.message;
}

/// Patch of every corner of every view at a solution; empty when a corner has none.
std::vector<camera::SplinePatch> patches_of(const SharedModel& model, const Solved& at,
                                            const std::vector<SolveView>& views) {
  std::vector<camera::SplinePatch> out;
  const Camera camera = camera_of(model, at.shared);
  const Eigen::Vector2d warp_m = warp_of(model, at.shared);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Rigid3 cam_from_board = pose_of(at.poses[v]);
    for (std::size_t c = 0; c < views[v].seen.px.size(); ++c) {
      const int id = corner_id(views[v].seen.ids, c);
      const int i = id % model.board.corners_x, j = id / model.board.corners_x;
      const auto patch =
          camera::spline_patch(camera, cam_from_board * warped_corner(model.board, warp_m, i, j));
      if (!patch) return {};
      out.push_back(*patch);
    }
  }
  return out;
}

/// One solve with every corner held to its patch.
void solve_patches(const SharedModel& model, const std::vector<SolveView>& views,
                   const std::vector<camera::SplinePatch>& patches, const SolveOptions& options,
                   Solved& out) {
  Camera scratch = camera_of(model, out.shared);
  ceres::Problem problem(problem_options());
  const Eigen::Index knots = model.intrinsics_count() - 4;
  std::vector<double*> blocks;
  for (Eigen::Index k = 0; k < model.count; k += 2) {
    blocks.push_back(out.shared.data() + k);
    problem.AddParameterBlock(blocks.back(), 2);
    if (model.prior_weight.size() > 0)
      problem.AddResidualBlock(new PriorCost(model, k, 2), nullptr, blocks.back());
  }
  std::size_t next = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (int c = 0; c < static_cast<int>(views[v].seen.px.size()); ++c) {
      auto cost = std::make_unique<PatchCost>(model, scratch, views[v], c, patches[next++]);
      std::vector<double*> used{out.poses[v].data()};
      for (int k = 0; k < cost->side() * cost->side(); ++k)
        used.push_back(out.shared.data() + cost->first_of(k));
      if (cost->has_warp()) used.push_back(out.shared.data() + knots);
      problem.AddResidualBlock(cost.release(), nullptr, used);
    }
  }
  run(options, problem, out, blocks);
}

void solve_splined(const SharedModel& model, const std::vector<SolveView>& views, const SolveOptions& options,
                   Solved& out) {
  std::vector<camera::SplinePatch> patches = patches_of(model, out, views);
  // Corners move by a few pixels after the first round, so that hardly any crosses a border twice.
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    out.converged = false;
    if (patches.empty()) {
      out.termination = "a corner straight behind the camera";
      return;
    }
    solve_patches(model, views, patches, options, out);
    std::vector<camera::SplinePatch> moved = patches_of(model, out, views);
    if (moved == patches) return;
    patches = std::move(moved);
  }
}

}  // namespace

Solved solve(const SharedModel& model, const Eigen::VectorXd& start, const std::vector<SolveView>& views,
             const SolveOptions& options) {
  Solved out;
  out.shared = start;
  for (const SolveView& view : views) out.poses.push_back(view.pose);
  if (model.camera.model == camera::CameraModel::splined_stereographic) {
    solve_splined(model, views, options, out);
    return out;
  }
  ceres::Problem problem(problem_options());
  for (std::size_t i = 0; i < views.size(); ++i)
    problem.AddResidualBlock(new ViewCost(model, views[i]), nullptr, out.shared.data(), out.poses[i].data());
  if (model.prior_weight.size() > 0)
    problem.AddResidualBlock(new PriorCost(model, 0, model.count), nullptr, out.shared.data());
  run(options, problem, out, {out.shared.data()});
  return out;
}

Information information(const SharedModel& model, const Solved& solved, const std::vector<SolveView>& views) {
  Information out;
  const Eigen::Index m = model.count;
  out.shared.setZero(m, m);
  if (model.prior_weight.size() > 0) out.shared.diagonal() = model.prior_weight.cwiseAbs2();
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
    out.shared.noalias() += left.transpose() * left;
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
