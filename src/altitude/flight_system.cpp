#include "flight_system.h"

#include <algorithm>
#include <cmath>

#include "ceres_solve.h"
#include "flight_costs.h"
#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

/// A quantity held fixed still needs a prior in the covariance; small against anything measurable.
constexpr double kHeldSigma = 1e-9;

}  // namespace

std::vector<ParameterPrior> shared_priors(const Farm& farm, const std::vector<ShotInput>& shots,
                                          const FlightOptions& options) {
  std::vector<ParameterPrior> priors;
  for (ParameterPrior& prior : farm_priors(farm)) {
    prior.parameter -= kPoseSize;
    priors.push_back(std::move(prior));
  }
  std::vector<double> pitch, roll;
  for (const ShotInput& shot : shots) {
    if (shot.attitude.pitch_rad.usable()) pitch.push_back(shot.attitude.pitch_rad.sigma);
    if (shot.attitude.roll_rad.usable()) roll.push_back(shot.attitude.roll_rad.sigma);
  }
  // A slope that is no quantity of its own is part of the bias: the gimbal knows gravity, the picture the
  // rows.
  const double slope = options.shot.terrain_slope_sigma_rad;
  const auto typical = [](const std::vector<double>& sigmas, double more) {
    const double sigma = sigmas.empty() ? 0.0 : std::hypot(stats::median(sigmas), more);
    return Estimate{0.0, std::max(kHeldSigma, sigma), 0};
  };
  const auto common = [](double sigma) { return Estimate{0.0, std::max(kHeldSigma, sigma), 0}; };
  priors.push_back({"pitch_bias", kFarmSize + kPitchBias,
                    typical(pitch, options.mean_slope_sigma_rad > 0.0 ? 0.0 : slope), !pitch.empty()});
  priors.push_back({"roll_bias", kFarmSize + kRollBias, typical(roll, options.shot.slope_across_sigma_rad),
                    !roll.empty()});
  priors.push_back({"terrain_slope", kFarmSize + kTerrainSlope, common(options.mean_slope_sigma_rad), true});
  priors.push_back({"focal_factor", kFarmSize + kFocal, common(options.focal_sigma), true});
  return priors;
}

std::vector<HeightTie> ties_of(const std::vector<FlightMember>& members, const std::vector<ShotInput>& shots,
                               const FlightOptions& options) {
  std::vector<HeightTie> ties;
  for (std::size_t i = 0; i + 1 < members.size(); ++i) {
    const double step = shots[members[i + 1].input].log_height_m - shots[members[i].input].log_height_m;
    if (std::isfinite(step) && options.log_step_sigma_m > 0.0)
      ties.push_back({i, step, options.log_step_sigma_m});
    if (options.height_step_sigma_m > 0.0) ties.push_back({i, 0.0, options.height_step_sigma_m});
  }
  return ties;
}

SolveReport solve(FlightSystem& flight, const FlightOptions& options) {
  ceres::Problem problem;
  double* const farm = flight.shared.data();
  double* const common = flight.shared.data() + kFarmSize;
  for (FlightMember& member : flight.members) {
    for (const WeightedBlock& block : member.shot.system.blocks) {
      using Cost =
          ceres::AutoDiffCostFunction<FlightRowCost, ceres::DYNAMIC, kPoseSize, kFarmSize, kFlightSize>;
      problem.AddResidualBlock(new Cost(new FlightRowCost{&block}, block.rows.residuals()), nullptr,
                               member.shot.x.data(), farm, common);
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<GimbalCost, 2, kPoseSize, kFlightSize>(new GimbalCost{&member}),
        nullptr, member.shot.x.data(), common);
  }
  for (const HeightTie& tie : flight.ties) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<TieCost, 1, kPoseSize, kPoseSize>(new TieCost{tie}), nullptr,
        flight.members[tie.first].shot.x.data(), flight.members[tie.first + 1].shot.x.data());
  }
  for (const ParameterPrior& prior : flight.shared_priors) {
    if (prior.parameter < kFarmSize) {
      add_prior<kFarmSize>(problem, prior, prior.parameter, farm);
    } else {
      add_prior<kFlightSize>(problem, prior, prior.parameter - kFarmSize, common);
    }
  }
  ceres::Solver::Options settings;
  settings.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  settings.max_num_iterations = options.shot.max_iterations;
  // Edges that begin to hide one another make kinks, at which steps shrink for ever: a millionth of the sum
  // of squares is hundredths of a sigma.
  settings.function_tolerance = 1e-6;
  settings.parameter_tolerance = 1e-9;
  SolveReport report = solve(problem, settings);
  report.usable = report.usable && flight.shared.allFinite();
  return report;
}

}  // namespace furrow::altitude
