#pragma once
#include <ceres/ceres.h>

#include "shot_system.h"

namespace furrow::altitude {

/// Adds a prior on the number at `place` in a parameter block of `kSize` numbers.
template <int kSize>
void add_prior(ceres::Problem& problem, const ParameterPrior& prior, int place, double* block) {
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<PriorCost, 1, kSize>(new PriorCost{prior, place}),
                           nullptr, block);
}

/// Solves silently, by one thread: sums in another order would change the last digits.
inline SolveReport solve(ceres::Problem& problem, ceres::Solver::Options settings) {
  settings.num_threads = 1;
  settings.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(settings, &problem, &summary);
  return {static_cast<int>(summary.iterations.size()),
          ceres::TerminationTypeToString(summary.termination_type), summary.IsSolutionUsable()};
}

}  // namespace furrow::altitude
