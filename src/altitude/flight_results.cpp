#include "flight_results.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <string>

#include "budget.h"

namespace furrow::altitude {
namespace {

/// d(pose) / d(intrinsics) of one shot with the farm held: what a wrong camera does to it (eq. 9.5).
Eigen::MatrixXd pose_by_intrinsics(const FlightMember& member, const ShotVector& x, const Camera& camera) {
  const auto jacobian = linearise_blocks(member.shot.system, x).jacobian.leftCols(kPoseSize).eval();
  const Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
  return -normal.ldlt().solve(jacobian.transpose() * intrinsics_jacobian(member.shot.system, x, camera));
}

ShotVector shot_vector(const FlightMember& member, const FlightSystem& flight) {
  ShotVector x = member.shot.x;
  x.tail(kFarmSize) = flight.shared.head(kFarmSize);
  return x;
}

/// Shared quantities with what the flight told of each.
void describe_shared(const FlightSystem& flight, const Eigen::MatrixXd& covariance, RefinedFlight& result) {
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  result.shared_correlation =
      sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
  const int count = static_cast<int>(flight.members.size());
  result.shared.clear();
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
std::vector<SigmaShare> flight_budget(const FlightSystem& flight, std::size_t i, const ArrowInverse& inverse,
                                      double noise_scale2) {
  const FlightMember& member = flight.members[i];
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
  shares.reserve(kSharedSize);
  for (int j = 0; j < kSharedSize; ++j) shares.push_back({kSharedNames[j], parts[j]});
  return shares;
}

void describe_shots(const FlightSystem& flight, const ArrowInverse& inverse, const Camera& camera,
                    const FieldKnowledge& field, double noise_scale2, RefinedFlight& result) {
  Eigen::MatrixXd mean_by_intrinsics = Eigen::MatrixXd::Zero(kPoseSize, camera.covariance.rows());
  const Eigen::MatrixXd factor = inverse.corner.llt().matrixL();
  for (std::size_t i = 0; i < flight.members.size(); ++i) {
    const FlightMember& member = flight.members[i];
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

void describe(const FlightSystem& flight, const ArrowInverse& inverse, double noise_scale2,
              const Camera& camera, const FieldKnowledge& field, RefinedFlight& result) {
  describe_shared(flight, inverse.corner, result);
  describe_shots(flight, inverse, camera, field, noise_scale2, result);
}

}  // namespace furrow::altitude
