#pragma once
#include <vector>

#include "fusion_labels.h"

namespace furrow::altitude {

/// What the readings are taken for, and the flight's noise and curvature that go with it.
struct Settled {
  std::vector<Labels> labels;
  FusionSetup setup;
  int passes = 0;  ///< of smoothing
};

/// Labels and noise that stay when the flight is smoothed by them, from the likelier of two starts (eq. 11.5,
/// 11.8), and again over ground that curves where the readings say so (eq. 11.7).
Settled settle(const std::vector<HeightSample>& samples, const FusionSetup& setup);

}  // namespace furrow::altitude
