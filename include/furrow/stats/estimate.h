#pragma once
#include <cmath>
#include <limits>

namespace furrow::stats {

/// A value, its one-sigma in the same unit, and how many observations carry it. The default says "never
/// estimated".
struct Estimate {
  double value = std::numeric_limits<double>::quiet_NaN();
  double sigma = std::numeric_limits<double>::quiet_NaN();
  int observations = 0;

  /// A finite value with a finite, non-negative sigma.
  bool usable() const { return std::isfinite(value) && std::isfinite(sigma) && sigma >= 0.0; }
};

}  // namespace furrow::stats

namespace furrow {
using stats::Estimate;
}
