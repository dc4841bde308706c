#pragma once
#include "furrow/altitude/shot_height.h"

namespace furrow::altitude {

/// The priors on theta and lambda that an AttitudePrior means; unusable parts stay unusable. A roll that is
/// not known becomes level within kUnknownRollSigma.
struct GimbalPrior {
  Estimate theta, lambda;
};
/// Errors: not_finite, naming the angle.
Result<GimbalPrior> gimbal_prior(const AttitudePrior& prior);

}  // namespace furrow::altitude
