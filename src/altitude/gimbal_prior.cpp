#include "gimbal_prior.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "prism.h"

namespace furrow::altitude {
namespace {

/// A camera whose roll nobody states is taken as level like a hand-held one; gimbals do five times better.
const double kUnknownRollSigma = geom::deg_to_rad(3.0);
/// An exactly known angle still needs a sigma above 0.
constexpr double kExactAngleSigma = 1e-9;

Result<Estimate> checked_angle(const char* name, const Estimate& angle) {
  if (std::isnan(angle.value)) return Estimate{};
  const bool sound = std::isfinite(angle.value) && std::isfinite(angle.sigma) && angle.sigma >= 0.0;
  if (!sound) {
    return Error{"not_finite", name,
                 base::format_double(angle.value) + " with sigma " + base::format_double(angle.sigma),
                 "a finite angle with a finite sigma, or NaN for not known", ""};
  }
  return Estimate{angle.value, std::max(angle.sigma, kExactAngleSigma), angle.observations};
}

/// What holds of a roll that nobody states.
Estimate stated_or_level(const Estimate& roll) {
  return std::isnan(roll.value) ? Estimate{0.0, kUnknownRollSigma, 0} : roll;
}

}  // namespace

AttitudePrior over_slope(AttitudePrior prior, const RefineOptions& options) {
  prior.roll_rad = stated_or_level(prior.roll_rad);
  const auto widen = [](Estimate& angle, double sigma) {
    if (angle.usable()) angle.sigma = std::hypot(angle.sigma, sigma);
  };
  widen(prior.pitch_rad, options.terrain_slope_sigma_rad);
  widen(prior.roll_rad, options.slope_across_sigma_rad);
  return prior;
}

Result<GimbalPrior> gimbal_prior(const AttitudePrior& prior) {
  GimbalPrior result;
  FURROW_TRY(const Estimate pitch, checked_angle("pitch_rad", prior.pitch_rad));
  FURROW_TRY(const Estimate roll, checked_angle("roll_rad", stated_or_level(prior.roll_rad)));
  const double p = pitch.usable() ? pitch.value : 0.0;
  result.lambda = {lambda_of(p, roll.value), roll.sigma, roll.observations};
  if (pitch.usable()) {
    const double sine = std::sin(pitch.value) / std::cos(result.lambda.value);
    result.theta = {std::asin(std::clamp(sine, -1.0, 1.0)), pitch.sigma, 1};
  }
  return result;
}

}  // namespace furrow::altitude
