#include <ceres/ceres.h>
#include <ceres/jet.h>
#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <optional>

#include "arrow.h"
#include "budget.h"
#include "denial.h"
#include "furrow/altitude/flight.h"
#include "furrow/base/parallel.h"
#include "furrow/stats/robust.h"
#include "shot_system.h"

namespace furrow::altitude {
namespace {

/// Places in the flight block, which follows the farm block in the shared vector.
constexpr int kPitchBias = 0, kRollBias = 1, kTerrainSlope = 2, kFocal = 3, kFlightSize = 4;
constexpr int kSharedSize = kFarmSize + kFlightSize;
constexpr int kAllSize = kPoseSize + kSharedSize;
using AllJet = ceres::Jet<double, kAllSize>;
constexpr const char* kSharedNames[kSharedSize] = {
    "row_spacing", "half_width", "foliage_depth", "base_ratio",    "rounding",
    "softness",    "pitch_bias", "roll_bias",     "terrain_slope", "focal_factor"};

/// A quantity held fixed still needs a prior in the covariance; small against anything measurable.
constexpr double kHeldSigma = 1e-9;

/// One shot that takes part.
struct Member {
  std::size_t input = 0;
  PreparedShot shot;
  Estimate log_theta, log_lambda;  ///< gimbal's reading with its shot-to-shot sigma
  double direction = 1.0;
  RefinedShot alone;  ///< by this shot alone
};

/// A tie between the heights of two neighbours in `members`.
struct Tie {
  std::size_t first = 0;
  double step_m = 0.0, sigma_m = 1.0;
};

struct Flight {
  std::vector<Member> members;
  std::vector<Tie> ties;
  std::vector<ParameterPrior> shared_priors;  ///< parameter is a place in the shared vector
  Eigen::Matrix<double, kSharedSize, 1> shared = Eigen::Matrix<double, kSharedSize, 1>::Zero();
};

struct FlightRowCost {
  const WeightedBlock* block = nullptr;
  template <class T>
  bool operator()(const T* pose, const T* farm, const T* flight, T* residuals) const {
    if (!sane_pose(pose)) return false;
    whitened_residuals(*block, pose, farm, residuals, T(1.0 + flight[kFocal]));
    return true;
  }
};

/// Log pitch = theta + bias + direction x slope; log roll = lambda + bias (eq. 9.2).
struct GimbalCost {
  const Member* member = nullptr;
  template <class T>
  bool operator()(const T* pose, const T* flight, T* residuals) const {
    residuals[0] = residuals[1] = T(0.0);
    if (member->log_theta.usable()) {
      residuals[0] = (pose[kTheta] + flight[kPitchBias] + member->direction * flight[kTerrainSlope] -
                      member->log_theta.value) /
                     member->log_theta.sigma;
    }
    if (member->log_lambda.usable()) {
      residuals[1] =
          (pose[kLambda] + flight[kRollBias] - member->log_lambda.value) / member->log_lambda.sigma;
    }
    return true;
  }
};

struct TieCost {
  Tie tie;
  template <class T>
  bool operator()(const T* first, const T* second, T* residual) const {
    using std::exp;
    if (!sane_pose(first) || !sane_pose(second)) return false;
    residual[0] = (exp(second[kLogHeight]) - exp(first[kLogHeight]) - tie.step_m) / tie.sigma_m;
    return true;
  }
};

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

/// The gimbal's reading without what is common to the flight.
Result<Member> member_of(const ShotInput& input, const Camera& camera, const FieldKnowledge& field,
                         const Farm& farm, const FlightOptions& options) {
  Member member;
  FURROW_TRY(member.shot, prepare_shot(input.lines, camera, field, farm, input.attitude, options.shot));
  // A shot that fails on its own must not bend the flight. The gimbal's bias may look like a contradiction to
  // one shot.
  RefineOptions alone = options.shot;
  alone.prior_conflict_sigmas = std::numeric_limits<double>::infinity();
  FURROW_TRY(member.alone, settle_shot(member.shot, camera, field, alone));
  check(member.alone.usable, "a settled shot is usable");
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(input.attitude));
  const double sigma = options.angle_noise_rad;
  if (gimbal.theta.usable()) member.log_theta = {gimbal.theta.value, sigma, 1};
  // Without a stated roll the camera is level as loosely as for one shot, and no bias can be told.
  const double loose = input.attitude.roll_rad.usable() ? sigma : std::hypot(sigma, gimbal.lambda.sigma);
  member.log_lambda = {gimbal.lambda.value, loose, 1};
  member.direction = input.direction < 0.0 ? -1.0 : 1.0;
  return member;
}

/// Prepares all shots, in parallel; the bad ones leave their reason in `result`.
std::vector<Member> prepare(const std::vector<ShotInput>& shots, const Camera& camera,
                            const FieldKnowledge& field, const Farm& farm, const FlightOptions& options,
                            RefinedFlight& result) {
  std::vector<std::optional<Member>> prepared(shots.size());
  base::parallel_for(shots.size(), options.threads, [&](std::size_t i) {
    auto member = member_of(shots[i], camera, field, farm, options);
    if (!member.ok()) {
      result.status[i] = member.error().code;
      result.reason[i] = member.error().message();
      return;
    }
    member->input = i;
    prepared[i] = std::move(*member);
  });
  std::vector<Member> members;
  for (auto& member : prepared) {
    if (member) members.push_back(std::move(*member));
  }
  return members;
}

/// Takes out shots whose rows the others deny, with their reasons.
void leave_out_denied(const std::vector<ShotInput>& shots, const FlightOptions& options,
                      std::vector<Member>& members, RefinedFlight& result) {
  std::vector<AloneShot> alone;
  for (const Member& member : members) {
    const ShotInput& input = shots[member.input];
    alone.push_back(
        {input.shot_id, member.alone.height_above_canopy_m, input.log_height_m, member.alone.residual_rms});
  }
  const auto denied = denied_shots(alone, options);
  std::vector<Member> kept;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (!denied[i]) {
      kept.push_back(std::move(members[i]));
      continue;
    }
    result.status[members[i].input] = denied[i]->code;
    result.reason[members[i].input] = denied[i]->message();
  }
  members = std::move(kept);
}

/// One canopy, one raggedness: the median of what the shots show.
void share_roughness(std::vector<Member>& members) {
  std::vector<double> all;
  for (const Member& member : members)
    if (std::isfinite(member.shot.system.roughness_m)) all.push_back(member.shot.system.roughness_m);
  if (all.empty()) return;
  const double typical = stats::median(all);
  for (Member& member : members) member.shot.system.roughness_m = typical;
}

std::vector<Tie> ties_of(const std::vector<Member>& members, const std::vector<ShotInput>& shots,
                         const FlightOptions& options) {
  std::vector<Tie> ties;
  for (std::size_t i = 0; i + 1 < members.size(); ++i) {
    const double step = shots[members[i + 1].input].log_height_m - shots[members[i].input].log_height_m;
    if (std::isfinite(step) && options.log_step_sigma_m > 0.0)
      ties.push_back({i, step, options.log_step_sigma_m});
    if (options.height_step_sigma_m > 0.0) ties.push_back({i, 0.0, options.height_step_sigma_m});
  }
  return ties;
}

SolveReport solve(Flight& flight, const FlightOptions& options) {
  ceres::Problem problem;
  double* const farm = flight.shared.data();
  double* const common = flight.shared.data() + kFarmSize;
  for (Member& member : flight.members) {
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
  for (const Tie& tie : flight.ties) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<TieCost, 1, kPoseSize, kPoseSize>(new TieCost{tie}), nullptr,
        flight.members[tie.first].shot.x.data(), flight.members[tie.first + 1].shot.x.data());
  }
  for (const ParameterPrior& prior : flight.shared_priors) {
    const bool of_farm = prior.parameter < kFarmSize;
    if (of_farm) {
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<PriorCost, 1, kFarmSize>(new PriorCost{prior, prior.parameter}),
          nullptr, farm);
    } else {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PriorCost, 1, kFlightSize>(
                                   new PriorCost{prior, prior.parameter - kFarmSize}),
                               nullptr, common);
    }
  }
  ceres::Solver::Options settings;
  settings.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  settings.max_num_iterations = options.shot.max_iterations;
  // Edges that begin to hide one another make kinks, at which steps shrink for ever: a millionth of the sum
  // of squares is hundredths of a sigma.
  settings.function_tolerance = 1e-6;
  settings.parameter_tolerance = 1e-9;
  // One thread: sums in another order would change the last digits.
  settings.num_threads = 1;
  settings.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(settings, &problem, &summary);
  return {static_cast<int>(summary.iterations.size()),
          ceres::TerminationTypeToString(summary.termination_type),
          summary.IsSolutionUsable() && flight.shared.allFinite()};
}

/// A member's residuals (rows, then gimbal) with derivatives by pose, farm and flight.
struct MemberJacobian {
  Eigen::VectorXd residuals;
  Eigen::Matrix<double, Eigen::Dynamic, kAllSize> jacobian;
  Eigen::Index row_residuals = 0;
};

MemberJacobian linearise(const Member& member, const Eigen::Matrix<double, kSharedSize, 1>& shared) {
  AllJet jets[kAllSize];
  for (int i = 0; i < kPoseSize; ++i) jets[i] = AllJet(member.shot.x[i], i);
  for (int i = 0; i < kSharedSize; ++i) jets[kPoseSize + i] = AllJet(shared[i], kPoseSize + i);
  const AllJet* const farm = jets + kPoseSize;
  const AllJet* const flight = farm + kFarmSize;
  const int rows = member.shot.system.block_residuals();
  std::vector<AllJet> residuals(static_cast<std::size_t>(rows) + 2);
  int at = 0;
  for (const WeightedBlock& block : member.shot.system.blocks) {
    FlightRowCost{&block}(jets, farm, flight, residuals.data() + at);
    at += block.rows.residuals();
  }
  GimbalCost{&member}(jets, flight, residuals.data() + at);
  MemberJacobian result;
  result.row_residuals = rows;
  result.residuals.resize(rows + 2);
  result.jacobian.resize(rows + 2, kAllSize);
  for (int i = 0; i < rows + 2; ++i) {
    result.residuals[i] = residuals[static_cast<std::size_t>(i)].a;
    result.jacobian.row(i) = residuals[static_cast<std::size_t>(i)].v.transpose();
  }
  return result;
}

/// The flight's normal equations at the solution.
struct Normal {
  ArrowMatrix matrix;
  double noise_scale2 = 1.0, residual_rms = 0.0;
};

void add_ties(const Flight& flight, ArrowMatrix& matrix) {
  for (const Tie& tie : flight.ties) {
    const double a = -std::exp(flight.members[tie.first].shot.x[kLogHeight]) / tie.sigma_m;
    const double b = std::exp(flight.members[tie.first + 1].shot.x[kLogHeight]) / tie.sigma_m;
    matrix.diagonal[tie.first](kLogHeight, kLogHeight) += a * a;
    matrix.diagonal[tie.first + 1](kLogHeight, kLogHeight) += b * b;
    matrix.next[tie.first](kLogHeight, kLogHeight) += a * b;
  }
}

Normal normal_of(const Flight& flight, double repeats) {
  std::vector<MemberJacobian> parts;
  double squares = 0.0, count = 0.0;
  for (const Member& member : flight.members) {
    parts.push_back(linearise(member, flight.shared));
    squares += parts.back().residuals.squaredNorm();
    count += static_cast<double>(parts.back().residuals.size());
  }
  Normal normal;
  const double freedom = count - kPoseSize * static_cast<double>(flight.members.size());
  normal.noise_scale2 = noise_scale2(squares, freedom);
  normal.residual_rms = freedom > 0.0 ? std::sqrt(squares / freedom) : 0.0;
  normal.matrix.corner = normal.matrix.corner_prior = Eigen::MatrixXd::Zero(kSharedSize, kSharedSize);
  normal.matrix.repeats = std::clamp(repeats, 1.0, static_cast<double>(flight.members.size()));
  for (const ParameterPrior& prior : flight.shared_priors) {
    normal.matrix.corner_prior(prior.parameter, prior.parameter) +=
        1.0 / (prior.wanted.sigma * prior.wanted.sigma);
  }
  for (const MemberJacobian& part : parts) {
    const Eigen::MatrixXd full = part.jacobian.transpose() * part.jacobian / normal.noise_scale2;
    normal.matrix.diagonal.push_back(full.topLeftCorner(kPoseSize, kPoseSize));
    normal.matrix.border.push_back(full.topRightCorner(kPoseSize, kSharedSize));
    normal.matrix.corner += full.bottomRightCorner(kSharedSize, kSharedSize);
  }
  normal.matrix.next.assign(flight.members.size() - 1, Eigen::MatrixXd::Zero(kPoseSize, kPoseSize));
  add_ties(flight, normal.matrix);
  return normal;
}

/// d(pose) / d(intrinsics) of one shot with the farm held: what a wrong camera does to it (eq. 9.5).
Eigen::MatrixXd pose_by_intrinsics(const Member& member, const ShotVector& x, const Camera& camera) {
  const auto jacobian = linearise_blocks(member.shot.system, x).jacobian.leftCols(kPoseSize).eval();
  const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
  return -normal.ldlt().solve(jacobian.transpose() * intrinsics_jacobian(member.shot.system, x, camera));
}

ShotVector shot_vector(const Member& member, const Flight& flight) {
  ShotVector x = member.shot.x;
  x.tail(kFarmSize) = flight.shared.head(kFarmSize);
  return x;
}

/// Shared quantities with what the flight told of each.
void describe_shared(const Flight& flight, const Eigen::MatrixXd& covariance, RefinedFlight& result) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  result.shared_correlation =
      sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
  const int count = static_cast<int>(flight.members.size());
  for (int i = 0; i < kSharedSize; ++i) {
    SharedQuantity quantity;
    quantity.name = kSharedNames[i];
    quantity.prior = flight.shared_priors[static_cast<std::size_t>(i)].wanted;
    // Width and depth count by their magnitudes (prism.h).
    const bool length = i == kHalfWidth || i == kDepth;
    quantity.posterior = {length ? std::abs(flight.shared[i]) : flight.shared[i], sigma[i], count};
    quantity.sigma_ratio = sigma[i] / quantity.prior.sigma;
    for (int j = 0; j < kSharedSize; ++j) {
      if (j == i || std::abs(result.shared_correlation(i, j)) <= std::abs(quantity.correlation)) continue;
      quantity.correlation = result.shared_correlation(i, j);
      quantity.most_correlated = kSharedNames[j];
    }
    result.shared.push_back(quantity);
  }
  const auto shared = [&](int place) { return result.shared[static_cast<std::size_t>(place)].posterior; };
  result.row_spacing_m = shared(kSpacing);
  result.half_width_m = shared(kHalfWidth);
  result.foliage_depth_m = shared(kDepth);
  result.pitch_bias_rad = shared(kFarmSize + kPitchBias);
  result.roll_bias_rad = shared(kFarmSize + kRollBias);
}

/// Adds what a wrong camera does to the biases: the mean of what it does to the shots' angles.
void add_camera_to_biases(const Eigen::MatrixXd& mean_by_intrinsics, const Camera& camera,
                          RefinedFlight& result) {
  const auto widen = [&](int row, Estimate& bias) {
    const Eigen::RowVectorXd g = mean_by_intrinsics.row(row);
    bias.sigma = std::hypot(bias.sigma, std::sqrt((g * camera.covariance).dot(g)));
  };
  widen(kTheta, result.pitch_bias_rad);
  widen(kLambda, result.roll_bias_rad);
}

/// The cause, as for one shot, that a shared quantity belongs to.
std::string budget_cause(const ParameterPrior& prior) {
  switch (prior.parameter - kFarmSize) {
    case kPitchBias:
      return "pitch";
    case kRollBias:
      return "roll";
    case kTerrainSlope:
      return "terrain";
    case kFocal:
      return "focal";
    default:
      return prior.cause;
  }
}

/// Shares of a shot's height within the flight (eq. 9.6). What neither the shot's own rows and gimbal nor the
/// priors carry came from the other shots: their noise, and the ties.
std::vector<SigmaShare> flight_budget(const Flight& flight, std::size_t i, const ArrowInverse& inverse,
                                      double noise_scale2) {
  const Member& member = flight.members[i];
  const double height = std::exp(member.shot.x[kLogHeight]);
  Eigen::RowVectorXd row(kAllSize);
  row << inverse.diagonal[i].row(kLogHeight), inverse.border[i].row(kLogHeight);
  const MemberJacobian own = linearise(member, flight.shared);
  const Eigen::RowVectorXd gain = height / noise_scale2 * row * own.jacobian.transpose();
  std::vector<SigmaShare> shares;
  add_row_shares(shares, member.shot.system, gain.head(own.row_residuals), noise_scale2);
  const double scale = std::sqrt(noise_scale2);
  add_share(shares, "pitch", std::abs(scale * gain[own.row_residuals]));
  add_share(shares, "roll", std::abs(scale * gain[own.row_residuals + 1]));
  for (const ParameterPrior& prior : flight.shared_priors) {
    const double part = height * row[kPoseSize + prior.parameter] / prior.wanted.sigma;
    add_share(shares, budget_cause(prior), std::abs(part));
  }
  const double all = height * height * row[kLogHeight];
  double told = 0.0;
  for (const SigmaShare& share : shares) told += share.sigma_m * share.sigma_m;
  // Plants that neighbouring shots share (eq. 9.7) can leave a shot's own rows more than the whole.
  if (told > all)
    for (SigmaShare& share : shares) share.sigma_m *= std::sqrt(all / told);
  shares.push_back({"other", std::sqrt(std::max(0.0, all - told))});
  return shares;
}

/// What the shared quantities' errors, made independent of one another, do to a shot's height (eq. 9.9): the
/// j-th is what the j-th quantity adds to those before it.
std::vector<SigmaShare> shared_shares(const ArrowInverse& inverse, const Eigen::MatrixXd& factor,
                                      std::size_t i, double height) {
  const Eigen::VectorXd with_shared = inverse.border[i].row(kLogHeight).transpose();
  const Eigen::VectorXd parts = height * factor.triangularView<Eigen::Lower>().solve(with_shared);
  std::vector<SigmaShare> shares;
  for (int j = 0; j < kSharedSize; ++j) shares.push_back({kSharedNames[j], parts[j]});
  return shares;
}

void describe_shots(const Flight& flight, const ArrowInverse& inverse, const Camera& camera,
                    const FieldKnowledge& field, double noise_scale2, RefinedFlight& result) {
  Eigen::MatrixXd mean_by_intrinsics = Eigen::MatrixXd::Zero(kPoseSize, camera.covariance.rows());
  const Eigen::MatrixXd factor = inverse.corner.llt().matrixL();
  for (std::size_t i = 0; i < flight.members.size(); ++i) {
    const Member& member = flight.members[i];
    const ShotVector x = shot_vector(member, flight);
    ShotMatrix covariance;
    covariance.topLeftCorner<kPoseSize, kPoseSize>() = inverse.diagonal[i];
    covariance.topRightCorner<kPoseSize, kFarmSize>() = inverse.border[i].leftCols(kFarmSize);
    covariance.bottomLeftCorner<kFarmSize, kPoseSize>() = inverse.border[i].leftCols(kFarmSize).transpose();
    covariance.bottomRightCorner<kFarmSize, kFarmSize>() = inverse.corner.topLeftCorner(kFarmSize, kFarmSize);
    std::vector<SigmaShare> budget = flight_budget(flight, i, inverse, noise_scale2);
    const double height = std::exp(x[kLogHeight]);
    std::vector<SigmaShare> shared = shared_shares(inverse, factor, i, height);
    if (has_covariance(camera)) {
      const Eigen::MatrixXd g = pose_by_intrinsics(member, x, camera);
      const Eigen::RowVectorXd of_height = height * g.row(kLogHeight);
      add_camera_shares(budget, of_height, camera);
      shared.push_back({"camera", std::sqrt((of_height * camera.covariance).dot(of_height))});
      covariance.topLeftCorner<kPoseSize, kPoseSize>() += g * camera.covariance * g.transpose();
      mean_by_intrinsics += g / static_cast<double>(flight.members.size());
    }
    RefinedShot shot = describe(member.shot.system, x, covariance, field);
    shot.height_budget = std::move(budget);
    shot.height_budget.push_back({"outline", shot.outline_rise_m.sigma});
    shot.height_shared = std::move(shared);
    shot.height_shared.push_back({"outline", shot.outline_rise_m.sigma});
    shot.rows_left_out = member.shot.rows_left_out;
    shot.iterations = result.iterations;
    shot.termination = result.termination;
    shot.residual_rms = result.residual_rms;
    shot.usable = true;
    result.shots[member.input] = std::move(shot);
    result.status[member.input] = "ok";
  }
  if (has_covariance(camera)) add_camera_to_biases(mean_by_intrinsics, camera, result);
}

}  // namespace

Result<RefinedFlight> refine_flight(const std::vector<ShotInput>& shots, const Camera& camera,
                                    const FieldKnowledge& field, const FlightOptions& options) {
  if (shots.empty()) return Error{"no_shots", "flight", "no shots", "one shot or more", ""};
  FURROW_TRY(const Farm farm, complete_farm(field));
  RefinedFlight result;
  result.shots.resize(shots.size());
  result.status.assign(shots.size(), "not run");
  result.reason.resize(shots.size());
  Flight flight;
  flight.members = prepare(shots, camera, field, farm, options, result);
  if (flight.members.empty()) {
    return Error{"no_usable_shot", shots.front().shot_id, result.reason.front(),
                 "a shot with two or more rows", ""};
  }
  leave_out_denied(shots, options, flight.members, result);
  share_roughness(flight.members);
  flight.ties = ties_of(flight.members, shots, options);
  flight.shared_priors = shared_priors(farm, shots, options);
  for (const ParameterPrior& prior : flight.shared_priors)
    flight.shared[prior.parameter] = prior.wanted.value;
  const SolveReport report = solve(flight, options);
  result.iterations = report.iterations;
  result.termination = report.termination;
  const Normal normal = normal_of(flight, options.shots_per_stretch);
  const auto inverse = invert(normal.matrix);
  if (!report.usable || !inverse) {
    return Error{"solve_failed", "flight", "no convergence (" + report.termination + ")",
                 "shots over one field", ""};
  }
  result.residual_rms = normal.residual_rms;
  describe_shared(flight, inverse->corner, result);
  describe_shots(flight, *inverse, camera, field, normal.noise_scale2, result);
  result.usable = true;
  return result;
}

}  // namespace furrow::altitude
