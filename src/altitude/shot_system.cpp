#include "shot_system.h"

#include <ceres/jet.h>
#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

using ShotJet = ceres::Jet<double, kShotSize>;

/// How far the foot of a near edge's wall, wandering in depth, moves its slope (eq. 5.4); 0 for a far edge.
double foot_slope_sigma(const Touch<double>& edge, double side, const RowWander& wander) {
  return side * edge.slope < 0.0 ? std::abs(edge.slope) / edge.drop * wander.foot_sigma_m : 0.0;
}

LinePlace place_of(const VisibleRow<double>& row, Side side, double top_centre, double height,
                   const RowWander& wander) {
  if (side == Side::left) return {row.left.slope, row.left.drop, foot_slope_sigma(row.left, 1.0, wander)};
  if (side == Side::right)
    return {row.right.slope, row.right.drop, foot_slope_sigma(row.right, -1.0, wander)};
  // A detector's "middle" may be that of the visible green or that of the top; the model takes the first and
  // allows for the second.
  const double visible = 0.5 * (row.left.slope + row.right.slope);
  return {visible, height, 0.5 * std::abs(visible - top_centre)};
}

double whitened_square(const WeightedBlock& block, const ShotVector& x) {
  const int n = block.rows.residuals();
  Eigen::VectorXd residuals(n);
  RowCost{&block}(x.data(), x.data() + kPoseSize, residuals.data());
  return residuals.squaredNorm();
}

/// Upper quantile of the normal distribution (Abramowitz and Stegun 26.2.23; error below 4.5e-4).
double normal_limit(double chance) {
  const double p = std::clamp(chance, 1e-12, 0.5);
  const double t = std::sqrt(-2.0 * std::log(p));
  return t -
         (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
}

}  // namespace

int ShotSystem::block_residuals() const {
  int n = 0;
  for (const WeightedBlock& block : blocks) n += block.rows.residuals();
  return n;
}

std::vector<ParameterPrior> farm_priors(const Farm& farm) {
  const int at = kPoseSize;
  return {{"spacing", at + kSpacing, farm.row_spacing_m, true},
          {"half_width", at + kHalfWidth, farm.half_width_m, farm.half_width_given},
          {"foliage", at + kDepth, farm.foliage_depth_m, farm.foliage_depth_given},
          {"foliage", at + kBaseRatio, farm.base_width_ratio, farm.base_ratio_given},
          {"foliage", at + kRounding, farm.rounding, farm.rounding_given},
          {"foliage", at + kSoftness, farm.softness, farm.softness_given}};
}

std::vector<ParameterPrior> angle_priors(const GimbalPrior& over_slope, bool roll_given) {
  std::vector<ParameterPrior> priors;
  if (over_slope.theta.usable()) priors.push_back({"pitch", kTheta, over_slope.theta, true});
  priors.push_back({"roll", kLambda, over_slope.lambda, roll_given});
  return priors;
}

ShotVector start_of(const Pencil& pencil, const Farm& farm) {
  const double s = farm.row_spacing_m.value, b = pencil.value[kPencilB];
  ShotVector x;
  x[kLogHeight] = std::log(-s / b);
  x[kTheta] = pencil.value[kPencilTheta];
  x[kLambda] = pencil.value[kPencilLambda];
  x[kPsi] = pencil.value[kPencilPsi];
  x[kCrossTrack] = pencil.value[kPencilA] * s / b;
  x[kPoseSize + kSpacing] = s;
  x[kPoseSize + kHalfWidth] = farm.half_width_m.value;
  x[kPoseSize + kDepth] = farm.foliage_depth_m.value;
  x[kPoseSize + kBaseRatio] = farm.base_width_ratio.value;
  x[kPoseSize + kRounding] = farm.rounding.value;
  x[kPoseSize + kSoftness] = farm.softness.value;
  return x;
}

void weigh(ShotSystem& system, const ShotVector& x) {
  const RowAxes<double> axes = row_axes(x[kTheta], x[kLambda], x[kPsi]);
  const double height = std::exp(x[kLogHeight]);
  for (WeightedBlock& block : system.blocks) {
    const VisibleRow<double> row = visible_row(x.data(), x.data() + kPoseSize, block.rows.row);
    const double top_centre = (-x[kCrossTrack] - block.rows.row * x[kPoseSize + kSpacing]) / height;
    std::vector<LinePlace> places;
    for (const EdgeLine& line : block.rows.lines)
      places.push_back(place_of(row, line.side, top_centre, height, system.wander));
    block.covariance = block_covariance(block.rows, places, axes, system.wander);
    block.whitener = whitener_of(block.covariance);
  }
}

Linearised linearise_blocks(const ShotSystem& system, const ShotVector& x) {
  ShotJet jets[kShotSize];
  for (int i = 0; i < kShotSize; ++i) jets[i] = ShotJet(x[i], i);
  const int n = system.block_residuals();
  Linearised result{Eigen::VectorXd(n), Eigen::Matrix<double, Eigen::Dynamic, kShotSize>(n, kShotSize)};
  std::vector<ShotJet> residuals(static_cast<std::size_t>(n));
  int at = 0;
  for (const WeightedBlock& block : system.blocks) {
    RowCost{&block}(jets, jets + kPoseSize, residuals.data() + at);
    at += block.rows.residuals();
  }
  for (int i = 0; i < n; ++i) {
    result.residuals[i] = residuals[static_cast<std::size_t>(i)].a;
    result.jacobian.row(i) = residuals[static_cast<std::size_t>(i)].v.transpose();
  }
  return result;
}

Linearised linearise_priors(const ShotSystem& system, const ShotVector& x) {
  const int n = static_cast<int>(system.priors.size());
  Linearised result{Eigen::VectorXd(n), Eigen::Matrix<double, Eigen::Dynamic, kShotSize>::Zero(n, kShotSize)};
  for (int i = 0; i < n; ++i) {
    const ParameterPrior& prior = system.priors[static_cast<std::size_t>(i)];
    result.residuals[i] = (x[prior.parameter] - prior.wanted.value) / prior.wanted.sigma;
    result.jacobian(i, prior.parameter) = 1.0 / prior.wanted.sigma;
  }
  return result;
}

Eigen::MatrixXd intrinsics_jacobian(const ShotSystem& system, const ShotVector& x, const Camera& camera) {
  const RowAxes<double> axes = row_axes(x[kTheta], x[kLambda], x[kPsi]);
  const Eigen::Index parameters = camera::intrinsics(camera).size();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(system.block_residuals(), parameters);
  int at = 0;
  for (const WeightedBlock& block : system.blocks) {
    Eigen::MatrixXd raw = Eigen::MatrixXd::Zero(block.rows.residuals(), parameters);
    for (int i = 0; i < block.rows.residuals(); ++i) {
      const EdgeLine& line = block.rows.lines[static_cast<std::size_t>(i / 2)];
      const Eigen::Vector2d& p = line.points[i % 2];
      const Vector3<double> l =
          line_at(axes, slope_at(axes, x.data(), x.data() + kPoseSize, block.rows.row, line.side, p));
      const Eigen::RowVector2d normal = Eigen::RowVector2d(l.x, l.y) / std::hypot(l.x, l.y);
      const auto projection = camera::project_with_jacobians(camera, p.homogeneous());
      if (!projection) continue;
      // The pixel stays; the point on the unit plane moves against the intrinsics.
      raw.row(i) = -normal * Eigen::Matrix2d(projection->d_point.leftCols<2>()).inverse() *
                   projection->by_all_intrinsics(parameters);
    }
    jacobian.middleRows(at, block.rows.residuals()) = block.whitener.triangularView<Eigen::Lower>() * raw;
    at += block.rows.residuals();
  }
  return jacobian;
}

double noise_scale2(double squares, double freedom) {
  constexpr double kClaimWeight = 20.0;
  return std::max(1.0, (kClaimWeight + squares) / (kClaimWeight + std::max(0.0, freedom)));
}

double chi_square_limit(int freedom, double chance) {
  const double a = 2.0 / (9.0 * freedom);
  const double root = 1.0 - a + normal_limit(chance) * std::sqrt(a);
  return freedom * root * root * root;
}

int drop_outliers(ShotSystem& system, const ShotVector& x, double chance) {
  std::vector<double> per_freedom;
  for (const WeightedBlock& block : system.blocks) {
    per_freedom.push_back(whitened_square(block, x) / block.rows.residuals());
  }
  // Where all rows fit worse than they claim, the claim is wrong, not every row.
  const double common = std::max(1.0, stats::median(per_freedom));
  std::vector<WeightedBlock> kept;
  for (std::size_t i = 0; i < per_freedom.size(); ++i) {
    const int n = system.blocks[i].rows.residuals();
    if (per_freedom[i] * n <= common * chi_square_limit(n, chance)) kept.push_back(system.blocks[i]);
  }
  if (kept.size() < 2) return 0;
  const int dropped = static_cast<int>(system.blocks.size() - kept.size());
  system.blocks = std::move(kept);
  return dropped;
}

}  // namespace furrow::altitude
