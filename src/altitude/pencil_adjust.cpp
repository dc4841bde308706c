#include "pencil_adjust.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>
#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>

#include "pencil_lines.h"

namespace furrow::altitude {
namespace {

/// One prior of the pencil: coefficients on the parameters, value wanted, sigma.
struct PencilPrior {
  PencilVector coefficients = PencilVector::Zero();
  double value = 0.0, sigma = 1.0;
};

struct PencilBlock {
  RowBlock rows;
  Eigen::MatrixXd whitener;
};

struct PencilResidual {
  const std::vector<PencilBlock>* blocks = nullptr;
  const std::vector<PencilPrior>* priors = nullptr;

  int NumResiduals() const {
    int n = static_cast<int>(priors->size());
    for (const PencilBlock& block : *blocks) n += block.rows.residuals();
    return n;
  }

  template <class T>
  bool operator()(const T* x, T* residuals) const {
    const RowAxes<T> axes = row_axes(x[kPencilTheta], x[kPencilLambda], x[kPencilPsi]);
    int at = 0;
    for (const PencilBlock& block : *blocks) {
      const int n = block.rows.residuals();
      Eigen::Matrix<T, Eigen::Dynamic, 1> raw(n);
      for (int i = 0; i < n; ++i) {
        const EdgeLine& line = block.rows.lines[static_cast<std::size_t>(i / 2)];
        raw[i] = distance(line_at(axes, pencil_slope(x, line)), line.points[i % 2]);
      }
      for (int i = 0; i < n; ++i, ++at) {
        residuals[at] = T(0.0);
        for (int j = 0; j <= i; ++j) residuals[at] += block.whitener(i, j) * raw[j];
      }
    }
    for (const PencilPrior& prior : *priors) {
      T sum = T(-prior.value);
      for (int i = 0; i < kPencilSize; ++i) sum += prior.coefficients[i] * x[i];
      residuals[at++] = sum / prior.sigma;
    }
    return true;
  }
};

/// How wrong the top edge's slope is for a near edge, which may be the foot of a wall as deep as the spacing:
/// uniform over t to t / (1 + |b|), about its upper end (eq. 3.7).
double wall_slope_sigma(const EdgeLine& line, double slope, double b) {
  if (is_top_edge(line, slope)) return 0.0;
  return std::abs(slope * b) / (1.0 + std::abs(b)) / std::sqrt(3.0);
}

std::vector<PencilBlock> whitened_blocks(const std::vector<EdgeLine>& lines, const PencilVector& x,
                                         const RowWander& wander) {
  const RowAxes<double> axes = row_axes(x[kPencilTheta], x[kPencilLambda], x[kPencilPsi]);
  std::vector<PencilBlock> blocks;
  for (RowBlock& rows : group_by_row(lines)) {
    std::vector<LinePlace> places;
    for (const EdgeLine& line : rows.lines) {
      const double slope = pencil_slope(x.data(), line);
      // Lengths in units of the spacing: the drop is 1 / |b|.
      places.push_back({slope, 1.0 / std::abs(x[kPencilB]), wall_slope_sigma(line, slope, x[kPencilB])});
    }
    PencilBlock block;
    block.whitener = whitener_of(block_covariance(rows, places, axes, wander));
    block.rows = std::move(rows);
    blocks.push_back(std::move(block));
  }
  return blocks;
}

std::vector<PencilPrior> pencil_priors(const GimbalPrior& prior, const OpenParts& open,
                                       const RelativeFarm& farm, double b) {
  std::vector<PencilPrior> priors(2);
  priors[0].coefficients[kPencilLambda] = 1.0;
  priors[0].value = prior.lambda.value;
  priors[0].sigma = prior.lambda.sigma;
  // g = -ratio b.
  priors[1].coefficients[kPencilG] = 1.0;
  priors[1].coefficients[kPencilB] = farm.width_ratio.value;
  priors[1].sigma = farm.width_ratio.sigma * std::abs(b);
  if (open.pitch) {
    PencilPrior pitch;
    pitch.coefficients[kPencilTheta] = 1.0;
    pitch.value = prior.theta.value;
    pitch.sigma = prior.theta.sigma;
    priors.push_back(pitch);
  }
  if (open.step) {
    PencilPrior step;
    step.coefficients[kPencilB] = 1.0;
    step.value = b;
    step.sigma = std::abs(b);
    priors.push_back(step);
  }
  return priors;
}

}  // namespace

Status adjust(const std::vector<EdgeLine>& lines, const GimbalPrior& prior, const OpenParts& open,
              const RelativeFarm& farm, Pencil& pencil) {
  const std::vector<PencilBlock> blocks = whitened_blocks(lines, pencil.value, farm.wander);
  const std::vector<PencilPrior> priors = pencil_priors(prior, open, farm, pencil.value[kPencilB]);
  PencilResidual residual{&blocks, &priors};
  using Function = ceres::TinySolverAutoDiffFunction<PencilResidual, Eigen::Dynamic, kPencilSize>;
  Function function(residual);
  ceres::TinySolver<Function> solver;
  solver.options.max_num_iterations = 50;
  solver.options.gradient_tolerance = 1e-14;
  solver.options.parameter_tolerance = 1e-13;
  solver.options.function_tolerance = 1e-15;
  solver.Solve(function, &pencil.value);
  Eigen::MatrixXd jacobian(residual.NumResiduals(), kPencilSize);
  Eigen::VectorXd r(residual.NumResiduals());
  function(pencil.value.data(), r.data(), jacobian.data());
  const Eigen::LDLT<Eigen::MatrixXd> normal(jacobian.transpose() * jacobian);
  pencil.covariance = normal.solve(Eigen::MatrixXd::Identity(kPencilSize, kPencilSize));
  const bool sound = pencil.value.allFinite() && pencil.covariance.allFinite() &&
                     pencil.covariance.diagonal().minCoeff() > 0.0 && pencil.value[kPencilB] < 0.0;
  if (!sound)
    return degenerate("ill_conditioned", "rows that fit no set of equally spaced lines",
                      "rows in order from left to right");
  return Done{};
}

Status add_top_depth(std::vector<EdgeLine> lines, const GimbalPrior& prior, const OpenParts& open,
                     const RelativeFarm& farm, Pencil& pencil) {
  const GimbalAngles angles = pencil.angles();
  set_reaches(lines, row_axes(angles.theta, angles.lambda, angles.psi),
              std::exp(farm.log_top_depth.value - farm.log_top_depth.sigma));
  Pencil flatter = pencil;
  FURROW_DO(adjust(lines, prior, open, farm, flatter));
  const PencilVector moved = flatter.value - pencil.value;
  pencil.covariance += moved * moved.transpose();
  return Done{};
}

}  // namespace furrow::altitude
