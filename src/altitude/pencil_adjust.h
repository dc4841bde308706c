#pragma once
#include <vector>

#include "gimbal_prior.h"
#include "pencil.h"
#include "relative_farm.h"

namespace furrow::altitude {

/// What the picture leaves open: the pitch where rows are parallel or alone, and then b, which a row alone
/// hardly tells and nobody asks of it.
struct OpenParts {
  bool pitch = false, step = false;
};

/// Weighted adjustment of the pencil from its start; covariance from the normal equations.
Status adjust(const std::vector<EdgeLine>& lines, const GimbalPrior& prior, const OpenParts& open,
              const RelativeFarm& farm, Pencil& pencil);

/// Adds to the covariance what the tops' depth, shallower by a sigma, does to the pencil (eq. 3.9).
Status add_top_depth(std::vector<EdgeLine> lines, const GimbalPrior& prior, const OpenParts& open,
                     const RelativeFarm& farm, Pencil& pencil);

}  // namespace furrow::altitude
