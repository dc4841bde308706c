#include <ceres/ceres.h>
#include <cmath>
#include <Eigen/Cholesky>

#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "shot_system.h"

namespace furrow::altitude {
namespace {

/// How many residuals the claimed sigmas are worth against the misfit that is seen when the noise is scaled
/// (eq. 8.2).
constexpr double kClaimWeight = 20.0;

using ShotMatrix = Eigen::Matrix<double, kShotSize, kShotSize>;

struct SolveReport {
  int iterations = 0;
  std::string termination;
  bool usable = false;
};

SolveReport solve(const ShotSystem& system, ShotVector& x, bool robust, const RefineOptions& options) {
  double* const pose = x.data();
  double* const farm = x.data() + kPoseSize;
  ceres::Problem problem;
  problem.AddParameterBlock(pose, kPoseSize);
  problem.AddParameterBlock(farm, kFarmSize);
  for (const WeightedBlock& block : system.blocks) {
    const int n = block.rows.residuals();
    auto* cost = new ceres::AutoDiffCostFunction<RowCost, ceres::DYNAMIC, kPoseSize, kFarmSize>(
        new RowCost{&block, 1.0}, n);
    const double scale = options.robust_scale * std::sqrt(static_cast<double>(n));
    problem.AddResidualBlock(cost, robust ? new ceres::CauchyLoss(scale) : nullptr, pose, farm);
  }
  for (const ParameterPrior& prior : system.priors) {
    if (prior.parameter < kPoseSize) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PriorCost, 1, kPoseSize>(new PriorCost{prior, prior.parameter}),
          nullptr, pose);
    } else {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PriorCost, 1, kFarmSize>(
                                   new PriorCost{prior, prior.parameter - kPoseSize}),
                               nullptr, farm);
    }
  }
  ceres::Solver::Options settings;
  settings.linear_solver_type = ceres::DENSE_QR;
  settings.max_num_iterations = options.max_iterations;
  settings.function_tolerance = robust ? 1e-6 : 1e-12;
  settings.parameter_tolerance = 1e-12;
  settings.num_threads = 1;
  settings.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(settings, &problem, &summary);
  return {static_cast<int>(summary.iterations.size()),
          ceres::TerminationTypeToString(summary.termination_type),
          summary.IsSolutionUsable() && x.allFinite()};
}

/// The linearised system at the solution, with the covariance it means (eq. 8.1 to 8.3).
struct Posterior {
  Linearised data, priors;
  ShotMatrix covariance = ShotMatrix::Zero();  ///< without the camera's own uncertainty
  Eigen::MatrixXd by_intrinsics;  ///< d(state) / d(intrinsics); empty when the camera has no covariance
  ShotMatrix camera_covariance = ShotMatrix::Zero();  ///< what that adds
  double noise_scale2 = 1.0;
  double residual_rms = 0.0;
};

bool has_covariance(const Camera& camera) {
  return camera.covariance.rows() > 0 && camera.covariance.rows() == camera::intrinsics(camera).size() &&
         camera.covariance.allFinite();
}

Result<Posterior> posterior_at(const ShotSystem& system, const ShotVector& x, const Camera& camera) {
  Posterior p;
  p.data = linearise_blocks(system, x);
  p.priors = linearise_priors(system, x);
  const double squares = p.data.residuals.squaredNorm() + p.priors.residuals.squaredNorm();
  const double freedom = static_cast<double>(p.data.residuals.size() + p.priors.residuals.size()) - kShotSize;
  p.noise_scale2 = (kClaimWeight + squares) / (kClaimWeight + std::max(0.0, freedom));
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
  double picture = 0.0, plants = 0.0;
  Eigen::Index at = 0;
  for (const WeightedBlock& block : system.blocks) {
    const Eigen::Index n = block.rows.residuals();
    const Eigen::RowVectorXd raw = gain.segment(at, n) * block.whitener;
    picture += (raw * block.covariance.picture).dot(raw) * posterior.noise_scale2;
    plants += (raw * block.covariance.plants).dot(raw) * posterior.noise_scale2;
    at += n;
  }
  std::vector<SigmaShare> shares = {{"picture", std::sqrt(picture)}, {"plants", std::sqrt(plants)}};
  const Eigen::RowVectorXd prior_gain =
      height * posterior.covariance.row(kLogHeight) * posterior.priors.jacobian.transpose();
  for (std::size_t i = 0; i < system.priors.size(); ++i) {
    const double part = std::abs(prior_gain[static_cast<Eigen::Index>(i)]);
    if (shares.back().cause == system.priors[i].cause) {
      shares.back().sigma_m = std::hypot(shares.back().sigma_m, part);
    } else {
      shares.push_back({system.priors[i].cause, part});
    }
  }
  if (posterior.by_intrinsics.size() > 0) {
    // fx, fy, cx, cy; their correlation with the distortion goes half to each, as it enters the sum twice.
    const Eigen::RowVectorXd g = height * posterior.by_intrinsics.row(kLogHeight);
    const Eigen::Index rest = g.size() - 4;
    const double linear = (g.head(4) * camera.covariance.topRows(4)).dot(g);
    const double distortion = rest > 0 ? (g.tail(rest) * camera.covariance.bottomRows(rest)).dot(g) : 0.0;
    shares.push_back({"focal", std::copysign(std::sqrt(std::abs(linear)), linear)});
    shares.push_back({"distortion", std::copysign(std::sqrt(std::abs(distortion)), distortion)});
  }
  return shares;
}

/// d(height, pitch, roll, yaw, cross-track, spacing, half width, foliage depth) / d(shot vector).
Eigen::Matrix<double, 8, kShotSize> output_jacobian(const ShotVector& x) {
  Eigen::Matrix<double, 8, kShotSize> t = Eigen::Matrix<double, 8, kShotSize>::Zero();
  t(0, kLogHeight) = std::exp(x[kLogHeight]);
  t.block<3, 3>(1, kTheta) = attitude_jacobian({x[kTheta], x[kLambda], x[kPsi]});
  t(4, kCrossTrack) = 1.0;
  t(5, kPoseSize + kSpacing) = 1.0;
  t(6, kPoseSize + kHalfWidth) = 1.0;
  t(7, kPoseSize + kDepth) = x[kPoseSize + kDepth] < 0.0 ? -1.0 : 1.0;
  return t;
}

RefinedShot describe(const ShotSystem& system, const ShotVector& x, const Posterior& posterior,
                     const FieldKnowledge& field) {
  RefinedShot shot;
  const ShotMatrix total = posterior.covariance + posterior.camera_covariance;
  const auto t = output_jacobian(x);
  shot.covariance = t * total * t.transpose();
  for (const WeightedBlock& block : system.blocks) {
    for (const EdgeLine& line : block.rows.lines) shot.observations += line.samples;
  }
  const auto estimate = [&](double value, int place) {
    return Estimate{value, std::sqrt(shot.covariance(place, place)), shot.observations};
  };
  const geom::Attitude attitude = attitude_from({x[kTheta], x[kLambda], x[kPsi]});
  shot.height_above_canopy_m = estimate(std::exp(x[kLogHeight]), 0);
  shot.pitch_rad = estimate(attitude.pitch_rad, 1);
  shot.roll_rad = estimate(attitude.roll_rad, 2);
  shot.yaw_rad = estimate(attitude.yaw_rad, 3);
  shot.cross_track_m = estimate(x[kCrossTrack], 4);
  shot.row_spacing_m = estimate(x[kPoseSize + kSpacing], 5);
  shot.half_width_m = estimate(x[kPoseSize + kHalfWidth], 6);
  shot.foliage_depth_m = estimate(std::abs(x[kPoseSize + kDepth]), 7);
  shot.heading_rad = {x[kPsi], std::sqrt(total(kPsi, kPsi)), shot.observations};
  const int ratio = kPoseSize + kBaseRatio;
  shot.base_width_ratio = {x[ratio], std::sqrt(total(ratio, ratio)), shot.observations};
  if (field.row_height_m.usable()) {
    shot.height_above_ground_m = {shot.height_above_canopy_m.value + field.row_height_m.value,
                                  std::hypot(shot.height_above_canopy_m.sigma, field.row_height_m.sigma),
                                  shot.observations};
  }
  shot.rows_used = static_cast<int>(system.blocks.size());
  shot.residual_rms = posterior.residual_rms;
  return shot;
}

Result<ShotSystem> build_system(const Pencil& pencil, const Farm& farm, const AttitudePrior& prior,
                                const RefineOptions& options) {
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(prior));
  ShotSystem system;
  for (const RowBlock& rows : pencil.blocks) system.blocks.push_back({rows, {}, {}});
  system.priors = angle_priors(gimbal, prior.roll_rad.usable(), options.terrain_slope_sigma_rad);
  for (ParameterPrior& p : farm_priors(farm)) system.priors.push_back(std::move(p));
  system.wander = {farm.planting_sigma_m, farm.growth_sigma_m};
  return system;
}

}  // namespace

Result<RefinedShot> refine_shot(const rows::RowLines& lines, const Camera& camera,
                                const FieldKnowledge& field, const AttitudePrior& prior,
                                const RefineOptions& options) {
  FURROW_TRY(const Farm farm, complete_farm(field));
  FURROW_TRY(const RowsOnUnitPlane directions, rows_on_unit_plane(lines, camera));
  FURROW_TRY(const Pencil pencil, fit_pencil(directions, field, prior));
  FURROW_TRY(ShotSystem system, build_system(pencil, farm, prior, options));
  ShotVector x = start_of(pencil, farm);
  weigh(system, x);
  const SolveReport first = solve(system, x, true, options);
  const int dropped = first.usable ? drop_outliers(system, x, options.outlier_chance) : 0;
  weigh(system, x);
  const SolveReport second = solve(system, x, false, options);
  if (!second.usable) {
    return Error{"solve_failed", "altitude", "no convergence (" + second.termination + ")",
                 "rows of one field", ""};
  }
  FURROW_TRY(const Posterior posterior, posterior_at(system, x, camera));
  FURROW_DO(check_priors(system, posterior, options.prior_conflict_sigmas));
  RefinedShot shot = describe(system, x, posterior, field);
  shot.height_budget = height_budget(system, x, posterior, camera);
  shot.rows_left_out = dropped;
  shot.iterations = first.iterations + second.iterations;
  shot.termination = second.termination;
  shot.usable = true;
  return shot;
}

}  // namespace furrow::altitude
