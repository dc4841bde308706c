#include <cmath>
#include <Eigen/Cholesky>

#include "budget.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "shot_system.h"

namespace furrow::altitude {
namespace {

/// The linearised system at the solution, with the covariance it means (eq. 8.1 to 8.3).
struct Posterior {
  Linearised data, priors;
  ShotMatrix covariance = ShotMatrix::Zero();  ///< without the camera's own uncertainty
  Eigen::MatrixXd by_intrinsics;  ///< d(state) / d(intrinsics); empty when the camera has no covariance
  ShotMatrix camera_covariance = ShotMatrix::Zero();  ///< what that adds
  double noise_scale2 = 1.0;
  double residual_rms = 0.0;
};

Result<Posterior> posterior_at(const ShotSystem& system, const ShotVector& x, const Camera& camera) {
  Posterior p;
  p.data = linearise_blocks(system, x);
  p.priors = linearise_priors(system, x);
  const double squares = p.data.residuals.squaredNorm() + p.priors.residuals.squaredNorm();
  const double freedom = static_cast<double>(p.data.residuals.size() + p.priors.residuals.size()) - kShotSize;
  p.noise_scale2 = noise_scale2(squares, freedom);
  p.residual_rms = freedom > 0.0 ? std::sqrt(squares / freedom) : 0.0;
  const ShotMatrix normal = p.data.jacobian.transpose() * p.data.jacobian / p.noise_scale2 +
                            p.priors.jacobian.transpose() * p.priors.jacobian;
  // Unit diagonal first: the parameters' units differ, and exactly known ones weigh 1e14.
  const ShotVector scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<ShotMatrix> factor(scale.asDiagonal() * normal * scale.asDiagonal());
  p.covariance = scale.asDiagonal() * ShotMatrix(factor.solve(ShotMatrix::Identity())) * scale.asDiagonal();
  const bool sound = p.covariance.allFinite() && p.covariance.diagonal().minCoeff() > 0.0;
  if (!sound)
    return Error{"solve_failed", "altitude", "a singular normal matrix", "rows that fix the height", ""};
  if (has_covariance(camera)) {
    p.by_intrinsics =
        -p.covariance * p.data.jacobian.transpose() * intrinsics_jacobian(system, x, camera) / p.noise_scale2;
    p.camera_covariance = p.by_intrinsics * camera.covariance * p.by_intrinsics.transpose();
  }
  return p;
}

Status check_fit(const ShotVector& x, const Posterior& posterior, const RefineOptions& options) {
  if (posterior.residual_rms > options.largest_misfit) {
    return Error{"rows_do_not_fit", "rows",
                 "a misfit of " + base::format_fixed(posterior.residual_rms, 1) +
                     " sigmas to any field of equally spaced rows",
                 "at most " + base::format_fixed(options.largest_misfit, 1), ""};
  }
  // The height is a logarithm inside, so its sigma is relative.
  const double relative = std::sqrt(posterior.covariance(kLogHeight, kLogHeight));
  if (!(relative <= options.largest_relative_sigma)) {
    return Error{"height_open", "rows",
                 "rows that leave the height of " + base::format_fixed(std::exp(x[kLogHeight]), 2) +
                     " m open by a factor of " + base::format_fixed(std::exp(std::min(relative, 10.0)), 1),
                 "more rows, or edges of rows", ""};
  }
  return Done{};
}

Status check_priors(const ShotSystem& system, const Posterior& posterior, double limit) {
  for (std::size_t i = 0; i < system.priors.size(); ++i) {
    const ParameterPrior& prior = system.priors[i];
    if (!prior.given) continue;
    const auto row = posterior.priors.jacobian.row(static_cast<Eigen::Index>(i));
    // Sigma of the residual, were the prior true: one less what the prior itself carries (eq. 8.5).
    const double own = row.dot(posterior.covariance * row.transpose());
    const double spread = std::sqrt(std::max(1.0 - own, 1e-6));
    const double conflict = std::abs(posterior.priors.residuals[static_cast<Eigen::Index>(i)]) / spread;
    if (conflict <= limit) continue;
    return Error{"contradictory_priors", prior.cause,
                 "the picture differs from the stated " + prior.cause + " by " +
                     base::format_fixed(conflict, 1) + " sigmas of their difference",
                 "at most " + base::format_fixed(limit, 1), "check the value, or state a wider sigma"};
  }
  return Done{};
}

/// Shares of the height's sigma (eq. 8.6): the gain of the height on each group of residuals.
std::vector<SigmaShare> height_budget(const ShotSystem& system, const ShotVector& x,
                                      const Posterior& posterior, const Camera& camera) {
  const double height = std::exp(x[kLogHeight]);
  const Eigen::RowVectorXd gain = height / posterior.noise_scale2 * posterior.covariance.row(kLogHeight) *
                                  posterior.data.jacobian.transpose();
  std::vector<SigmaShare> shares;
  add_row_shares(shares, system, gain, posterior.noise_scale2);
  const Eigen::RowVectorXd prior_gain =
      height * posterior.covariance.row(kLogHeight) * posterior.priors.jacobian.transpose();
  for (std::size_t i = 0; i < system.priors.size(); ++i) {
    add_share(shares, system.priors[i].cause, std::abs(prior_gain[static_cast<Eigen::Index>(i)]));
  }
  if (posterior.by_intrinsics.size() > 0)
    add_camera_shares(shares, height * posterior.by_intrinsics.row(kLogHeight), camera);
  return shares;
}

}  // namespace

Result<RefinedShot> settle_shot(PreparedShot& prepared, const Camera& camera, const FieldKnowledge& field,
                                const RefineOptions& options) {
  const ShotSystem& system = prepared.system;
  const SolveReport report = solve(system, prepared.x, false, options);
  if (!report.usable) {
    return Error{"solve_failed", "altitude", "no convergence (" + report.termination + ")",
                 "rows of one field", ""};
  }
  FURROW_TRY(const Posterior posterior, posterior_at(system, prepared.x, camera));
  // A wrong prior pulls the rows out of shape too, and is the cause to name.
  FURROW_DO(check_priors(system, posterior, options.prior_conflict_sigmas));
  FURROW_DO(check_fit(prepared.x, posterior, options));
  RefinedShot shot = describe(system, prepared.x, posterior.covariance + posterior.camera_covariance, field);
  shot.height_budget = height_budget(system, prepared.x, posterior, camera);
  shot.height_budget.push_back({"outline", shot.outline_rise_m.sigma});
  shot.residual_rms = posterior.residual_rms;
  shot.rows_left_out = prepared.rows_left_out;
  shot.iterations = prepared.iterations + report.iterations;
  shot.termination = report.termination;
  shot.usable = true;
  return shot;
}

Result<RefinedShot> refine_shot(const rows::RowLines& lines, const Camera& camera,
                                const FieldKnowledge& field, const AttitudePrior& prior,
                                const RefineOptions& options) {
  FURROW_TRY(const Farm farm, complete_farm(field));
  FURROW_TRY(PreparedShot prepared, prepare_shot(lines, camera, field, farm, prior, options));
  return settle_shot(prepared, camera, field, options);
}

}  // namespace furrow::altitude
