#pragma once
#include <limits>
#include <utility>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/base/time.h"

namespace furrow::sync {

/// Reading of one clock from the reading t of another: t + offset + drift (t - at),
/// docs/formulation/georeferencing.md eq. (5).
struct ClockMap {
  base::Nanoseconds at_ns = 0;      ///< mean of the pairs' t: offset and drift are uncorrelated there
  base::Nanoseconds offset_ns = 0;  ///< at `at_ns`
  double offset_sigma_s = std::numeric_limits<double>::quiet_NaN();
  double drift = 0.0;  ///< seconds per second
  double drift_sigma = 0.0;
  double scatter_s = std::numeric_limits<double>::quiet_NaN();  ///< robust sigma of one pair
  int pairs = 0;
  int outliers = 0;  ///< pairs more than 3 scatter_s off
};

struct ClockFitOptions {
  /// Estimate the drift too. Needs three pairs that span some time; consumer clocks drift by 1e-5 to 1e-4.
  bool drift = false;
  /// Both clocks' reading step combined, s: the scatter is never taken to be below step / sqrt(12). EXIF cuts
  /// to 1 s.
  double step_s = 1e-3;
};

/// A ClockMap from pairs (reading of the first clock, reading of the second), robust against a minority of
/// wrong pairs (Huber). A second clock that is cut to whole steps is late by half a step in the mean: the
/// caller adds it. Errors: not_enough_pairs.
Result<ClockMap> fit_clock(const std::vector<std::pair<base::Nanoseconds, base::Nanoseconds>>& pairs,
                           const ClockFitOptions& options = {});

/// The second clock's reading at the first one's t, and its sigma, eq. (6).
base::Nanoseconds map_time(const ClockMap& map, base::Nanoseconds t_ns);
double map_sigma_s(const ClockMap& map, base::Nanoseconds t_ns);

}  // namespace furrow::sync
