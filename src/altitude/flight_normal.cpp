#include "flight_normal.h"

#include <ceres/jet.h>
#include <algorithm>
#include <cmath>

#include "flight_costs.h"

namespace furrow::altitude {
namespace {

using AllJet = ceres::Jet<double, kAllSize>;

void add_ties(const FlightSystem& flight, ArrowMatrix& matrix) {
  for (const HeightTie& tie : flight.ties) {
    const double a = -std::exp(flight.members[tie.first].shot.x[kLogHeight]) / tie.sigma_m;
    const double b = std::exp(flight.members[tie.first + 1].shot.x[kLogHeight]) / tie.sigma_m;
    matrix.diagonal[tie.first](kLogHeight, kLogHeight) += a * a;
    matrix.diagonal[tie.first + 1](kLogHeight, kLogHeight) += b * b;
    matrix.next[tie.first](kLogHeight, kLogHeight) += a * b;
  }
}

}  // namespace

MemberJacobian linearise(const FlightMember& member, const SharedVector& shared) {
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

FlightNormal normal_of(const FlightSystem& flight, double repeats) {
  std::vector<MemberJacobian> parts;
  FlightNormal normal;
  double squares = 0.0, count = 0.0;
  for (const FlightMember& member : flight.members) {
    parts.push_back(linearise(member, flight.shared));
    const double own = parts.back().residuals.squaredNorm();
    const double residuals = static_cast<double>(parts.back().residuals.size());
    normal.member_rms.push_back(std::sqrt(own / std::max(1.0, residuals - kPoseSize)));
    squares += own;
    count += residuals;
  }
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

}  // namespace furrow::altitude
