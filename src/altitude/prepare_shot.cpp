#include <cmath>

#include "ceres_solve.h"
#include "outline_roughness.h"
#include "shot_system.h"

namespace furrow::altitude {
namespace {

/// d(height, pitch, roll, yaw, cross-track, spacing, half width, foliage depth) / d(shot vector).
Eigen::Matrix<double, 8, kShotSize> output_jacobian(const ShotVector& x) {
  Eigen::Matrix<double, 8, kShotSize> t = Eigen::Matrix<double, 8, kShotSize>::Zero();
  t(0, kLogHeight) = std::exp(x[kLogHeight]);
  t.block<3, 3>(1, kTheta) = attitude_jacobian({x[kTheta], x[kLambda], x[kPsi]});
  t(4, kCrossTrack) = 1.0;
  t(5, kPoseSize + kSpacing) = 1.0;
  t(6, kPoseSize + kHalfWidth) = x[kPoseSize + kHalfWidth] < 0.0 ? -1.0 : 1.0;
  t(7, kPoseSize + kDepth) = x[kPoseSize + kDepth] < 0.0 ? -1.0 : 1.0;
  return t;
}

ShotSystem build_system(const Pencil& pencil, const Farm& farm, const GimbalPrior& gimbal, bool roll_given) {
  ShotSystem system;
  for (const RowBlock& rows : pencil.blocks) system.blocks.push_back({rows, {}, {}});
  system.priors = angle_priors(gimbal, roll_given);
  for (ParameterPrior& p : farm_priors(farm)) system.priors.push_back(std::move(p));
  system.wander = {farm.planting_sigma_m, farm.growth_sigma_m, farm.foot_sigma_m};
  return system;
}

}  // namespace

SolveReport solve(const ShotSystem& system, ShotVector& x, bool robust, const RefineOptions& options) {
  double* const pose = x.data();
  double* const farm = x.data() + kPoseSize;
  ceres::Problem problem;
  problem.AddParameterBlock(pose, kPoseSize);
  problem.AddParameterBlock(farm, kFarmSize);
  for (const WeightedBlock& block : system.blocks) {
    const int n = block.rows.residuals();
    auto* cost = new ceres::AutoDiffCostFunction<RowCost, ceres::DYNAMIC, kPoseSize, kFarmSize>(
        new RowCost{&block}, n);
    const double scale = options.robust_scale * std::sqrt(static_cast<double>(n));
    problem.AddResidualBlock(cost, robust ? new ceres::CauchyLoss(scale) : nullptr, pose, farm);
  }
  for (const ParameterPrior& prior : system.priors) {
    if (prior.parameter < kPoseSize) {
      add_prior<kPoseSize>(problem, prior, prior.parameter, pose);
    } else {
      add_prior<kFarmSize>(problem, prior, prior.parameter - kPoseSize, farm);
    }
  }
  ceres::Solver::Options settings;
  settings.linear_solver_type = ceres::DENSE_QR;
  settings.max_num_iterations = options.max_iterations;
  settings.function_tolerance = robust ? 1e-6 : 1e-12;
  settings.parameter_tolerance = 1e-12;
  SolveReport report = solve(problem, settings);
  report.usable = report.usable && x.allFinite();
  return report;
}

bool has_covariance(const Camera& camera) {
  return camera.covariance.rows() > 0 && camera.covariance.rows() == camera::intrinsics(camera).size() &&
         camera.covariance.allFinite();
}

RefinedShot describe(const ShotSystem& system, const ShotVector& x, const ShotMatrix& total,
                     const FieldKnowledge& field) {
  RefinedShot shot;
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
  shot.half_width_m = estimate(std::abs(x[kPoseSize + kHalfWidth]), 6);
  shot.foliage_depth_m = estimate(std::abs(x[kPoseSize + kDepth]), 7);
  // A length that is kept as a logarithm over the half width.
  const auto part_of_width = [&](int place) {
    const double length = shot.half_width_m.value * std::exp(x[kPoseSize + place]);
    return Estimate{length, length * std::sqrt(total(kPoseSize + place, kPoseSize + place)),
                    shot.observations};
  };
  shot.rounding_m = part_of_width(kRounding);
  shot.softness_m = part_of_width(kSoftness);
  const Estimate rise = outline_rise(
      field, {shot.half_width_m.value, shot.rounding_m.value, shot.softness_m.value, system.roughness_m});
  shot.outline_rise_m = rise;
  shot.height_above_canopy_m.value += rise.value;
  shot.height_above_canopy_m.sigma = std::hypot(shot.height_above_canopy_m.sigma, rise.sigma);
  shot.covariance(0, 0) += rise.sigma * rise.sigma;
  shot.heading_rad = {x[kPsi], std::sqrt(total(kPsi, kPsi)), shot.observations};
  const int ratio = kPoseSize + kBaseRatio;
  shot.base_width_ratio = {x[ratio], std::sqrt(total(ratio, ratio)), shot.observations};
  if (field.row_height_m.usable()) {
    shot.height_above_ground_m = {shot.height_above_canopy_m.value + field.row_height_m.value,
                                  std::hypot(shot.height_above_canopy_m.sigma, field.row_height_m.sigma),
                                  shot.observations};
  }
  shot.rows_used = static_cast<int>(system.blocks.size());
  return shot;
}

Result<PreparedShot> prepare_shot(const rows::RowLines& lines, const Camera& camera,
                                  const FieldKnowledge& field, const Farm& farm, const AttitudePrior& prior,
                                  const RefineOptions& options) {
  FURROW_TRY(const RowsOnUnitPlane directions, rows_on_unit_plane(lines, camera));
  return prepare_directions(directions, field, farm, prior, options);
}

Result<PreparedShot> prepare_directions(const RowsOnUnitPlane& directions, const FieldKnowledge& field,
                                        const Farm& farm, const AttitudePrior& prior,
                                        const RefineOptions& options) {
  // A start that trusts the gimbal over a slope gives lines to wrong edges.
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(over_slope(prior, options)));
  FURROW_TRY(const Pencil pencil, fit_pencil(directions, field, gimbal));
  PreparedShot shot;
  shot.system = build_system(pencil, farm, gimbal, prior.roll_rad.usable());
  shot.x = start_of(pencil, farm);
  if (!shot.x.allFinite() || !sane_pose(shot.x.data())) {
    return Error{"ill_conditioned", "rows", "rows whose slopes mean no height that can be flown",
                 "rows of one field", ""};
  }
  weigh(shot.system, shot.x);
  const SolveReport report = solve(shot.system, shot.x, true, options);
  shot.iterations = report.iterations;
  shot.rows_left_out = pencil.rows_left_out;
  if (report.usable) shot.rows_left_out += drop_outliers(shot.system, shot.x, options.outlier_chance);
  weigh(shot.system, shot.x);
  shot.system.roughness_m = outline_roughness_m(directions, shot.x);
  return shot;
}

}  // namespace furrow::altitude
