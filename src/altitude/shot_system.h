#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "farm.h"
#include "furrow/altitude/shot_height.h"
#include "gimbal_prior.h"
#include "pencil.h"
#include "row_block.h"

namespace furrow::altitude {

/// A shot's parameters in one vector: the pose block, then the farm block.
inline constexpr int kShotSize = kPoseSize + kFarmSize;
using ShotVector = Eigen::Matrix<double, kShotSize, 1>;

/// A row with the noise of its residuals at the place where the model now stands.
struct WeightedBlock {
  RowBlock rows;
  BlockCovariance covariance;
  Eigen::MatrixXd whitener;
};

/// A Gaussian prior on one parameter.
struct ParameterPrior {
  std::string cause;  ///< as in SigmaShare
  int parameter = 0;  ///< place in ShotVector
  Estimate wanted;
  bool given = false;  ///< stated by the caller, so that a contradiction is the caller's
};

/// Everything that the refinement of a shot minimises.
struct ShotSystem {
  std::vector<WeightedBlock> blocks;
  std::vector<ParameterPrior> priors;
  RowWander wander;
  /// Of the outline along the rows (outline_roughness_m).
  double roughness_m = std::numeric_limits<double>::quiet_NaN();

  int block_residuals() const;
};

/// Raw residuals of a row: perpendicular distances on the unit plane (eq. 7.1).
template <class T>
void row_residuals(const RowBlock& block, const T* pose, const T* farm, T* raw, const T& zoom = T(1.0)) {
  const RowAxes<T> axes = row_axes(pose[kTheta], pose[kLambda], pose[kPsi]);
  for (std::size_t i = 0; i < block.lines.size(); ++i) {
    for (std::size_t j = 0; j < 2; ++j) {
      const Eigen::Vector2d& p = block.lines[i].points[j];
      const T slope = slope_at(axes, pose, farm, block.row, block.lines[i].side, p);
      raw[2 * i + j] = distance(line_at(axes, slope), p, zoom);
    }
  }
}

/// Whitened residuals of a row.
template <class T>
void whitened_residuals(const WeightedBlock& block, const T* pose, const T* farm, T* residuals,
                        const T& zoom = T(1.0)) {
  const int n = block.rows.residuals();
  Eigen::Matrix<T, Eigen::Dynamic, 1, 0, 6, 1> raw(n);
  row_residuals(block.rows, pose, farm, raw.data(), zoom);
  for (int i = 0; i < n; ++i) {
    residuals[i] = T(0.0);
    for (int j = 0; j <= i; ++j) residuals[i] += block.whitener(i, j) * raw[j];
  }
}

/// Whether a pose is one that a solver may stand on: a step beyond it is refused instead of followed into
/// infinity. Heights from micrometres to 10,000 km.
template <class T>
bool sane_pose(const T* pose) {
  constexpr double kLargestLogHeight = 16.0;
  return pose[kLogHeight] > -kLargestLogHeight && pose[kLogHeight] < kLargestLogHeight;
}

/// Cost of one row for Ceres; parameter blocks pose and farm.
struct RowCost {
  const WeightedBlock* block = nullptr;

  template <class T>
  bool operator()(const T* pose, const T* farm, T* residuals) const {
    if (!sane_pose(pose)) return false;
    whitened_residuals(*block, pose, farm, residuals);
    return true;
  }
};

/// Cost of a prior for Ceres; one parameter block.
struct PriorCost {
  ParameterPrior prior;
  int place = 0;  ///< inside the block

  template <class T>
  bool operator()(const T* block, T* residual) const {
    residual[0] = (block[place] - prior.wanted.value) / prior.wanted.sigma;
    return true;
  }
};

/// Priors on the farm's numbers.
std::vector<ParameterPrior> farm_priors(const Farm& farm);
/// Priors on a shot's angles against the rows' plane.
std::vector<ParameterPrior> angle_priors(const GimbalPrior& over_slope, bool roll_given);

/// The pencil in metres: the start of the refinement.
ShotVector start_of(const Pencil& pencil, const Farm& farm);

/// Sets each block's covariance and whitener at x.
void weigh(ShotSystem& system, const ShotVector& x);

/// Whitened residuals of the blocks, with derivatives by the parameters.
struct Linearised {
  Eigen::VectorXd residuals;
  Eigen::Matrix<double, Eigen::Dynamic, kShotSize> jacobian;
};
Linearised linearise_blocks(const ShotSystem& system, const ShotVector& x);
Linearised linearise_priors(const ShotSystem& system, const ShotVector& x);

/// Effect of the camera's intrinsics on the whitened residuals of the blocks (eq. 8.4).
Eigen::MatrixXd intrinsics_jacobian(const ShotSystem& system, const ShotVector& x, const Camera& camera);

/// Solves one shot by Ceres from x; `robust`: rows under a Cauchy loss.
struct SolveReport {
  int iterations = 0;
  std::string termination;
  bool usable = false;
};
SolveReport solve(const ShotSystem& system, ShotVector& x, bool robust, const RefineOptions& options);

/// Effect of the parameters' covariance on what a RefinedShot reports: everything but budget, counts of
/// iterations and termination.
using ShotMatrix = Eigen::Matrix<double, kShotSize, kShotSize>;
RefinedShot describe(const ShotSystem& system, const ShotVector& x, const ShotMatrix& covariance,
                     const FieldKnowledge& field);

/// Whether the camera says how sure it is of itself.
bool has_covariance(const Camera& camera);

/// A shot up to the point where its rows are sorted out: robust solution, outliers gone, weights set.
struct PreparedShot {
  ShotSystem system;
  ShotVector x;
  int rows_left_out = 0;
  int iterations = 0;
};
Result<PreparedShot> prepare_shot(const rows::RowLines& lines, const Camera& camera,
                                  const FieldKnowledge& field, const Farm& farm, const AttitudePrior& prior,
                                  const RefineOptions& options);

/// The same from directions.
Result<PreparedShot> prepare_directions(const RowsOnUnitPlane& directions, const FieldKnowledge& field,
                                        const Farm& farm, const AttitudePrior& prior,
                                        const RefineOptions& options);

/// Least squares from where a prepared shot stands, with every check that refine_shot makes; the shot then
/// stands at the solution.
Result<RefinedShot> settle_shot(PreparedShot& shot, const Camera& camera, const FieldKnowledge& field,
                                const RefineOptions& options);

/// By how much the noise is larger than claimed, as the misfit shows, the claim counting as 20 residuals
/// (eq. 8.2). Not less than 1: lines are scaled by their samples' scatter already, and priors that are wider
/// than this field needs must not vouch for the picture.
double noise_scale2(double squares, double freedom);

/// Largest value that chi-square with `freedom` degrees passes with the given chance (Wilson and Hilferty
/// 1931).
double chi_square_limit(int freedom, double chance);

/// Takes rows out that do not belong to the field at x; keeps at least two. Returns how many were taken out.
int drop_outliers(ShotSystem& system, const ShotVector& x, double chance);

}  // namespace furrow::altitude
