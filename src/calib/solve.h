#pragma once
#include <string>
#include <vector>

#include "calib/model.h"

namespace furrow::calib {

/// One view as the solver sees it.
struct SolveView {
  SeenCorners seen;
  std::vector<double> weight;  ///< one a corner, or none; 0 leaves a corner out
  PoseVector pose;
};

struct SolveOptions {
  int max_iterations = 200;
  /// A step that lowers the cost by less than this share ends the solve.
  double function_tolerance = 1e-12;
};

/// Least squares over all views and the prior, in Ceres. `shared` and the poses are the minimum's when
/// `converged`. Of a splined camera the free parameters must be its knots, all of them, and perhaps the bend
/// of the board: each corner is tied to the knots of its patch, and the problem is set up anew until no
/// corner has left its patch.
struct Solved {
  Eigen::VectorXd shared;
  std::vector<PoseVector> poses;
  bool converged = false;
  int iterations = 0;
  std::string termination = "never ran";
};
Solved solve(const SharedModel& model, const Eigen::VectorXd& start, const std::vector<SolveView>& views,
             const SolveOptions& options);

/// The Gauss-Newton normal matrix at a solution, with the poses eliminated view by view: linear in the number
/// of views.
struct Information {
  /// Of the shared parameters, poses counted in as unknown (Schur complement), with the prior.
  Eigen::MatrixXd shared;
  std::vector<Eigen::Matrix<double, 6, 6>> pose_inverse;           ///< (B'B)^-1 of each view
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> pose_tie;  ///< (B'B)^-1 B'A of each view
  double squared_sum = 0.0;                                        ///< of the weighted residuals
  int residuals = 0;                                               ///< how many are not weighted 0
  bool usable = false;
};
Information information(const SharedModel& model, const Solved& solved, const std::vector<SolveView>& views);

/// Unscaled covariance of (shared, mean turn, mean shift of the boards in cam), given that of `shared`.
Eigen::MatrixXd drift_covariance(const Information& information, const Solved& solved,
                                 const Eigen::MatrixXd& shared_covariance);

}  // namespace furrow::calib
