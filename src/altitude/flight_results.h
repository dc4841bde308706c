#pragma once
#include "flight_normal.h"

namespace furrow::altitude {

/// Fills in what the flight says of its shared quantities and of each shot that took part, with the
/// covariance `inverse` at the solution (section 9). Iterations, termination and misfit are in `result`
/// before.
void describe(const FlightSystem& flight, const ArrowInverse& inverse, double noise_scale2,
              const Camera& camera, const FieldKnowledge& field, RefinedFlight& result);

}  // namespace furrow::altitude
