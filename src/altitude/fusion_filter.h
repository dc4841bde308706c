#pragma once
#include <vector>

#include "fusion_labels.h"

namespace furrow::altitude {

/// What the readings up to each sample say of it, with what was expected before its own.
struct Filtered {
  std::vector<Belief> predicted, filtered;
  double minus_2_log_likelihood = 0.0;
};

/// Forward Kalman filter (eq. 11.2).
Filtered filter(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                const FusionSetup& setup);

/// Forward, then backward by Rauch, Tung and Striebel (eq. 11.2).
std::vector<Belief> smooth(const std::vector<HeightSample>& samples, const std::vector<Labels>& labels,
                           const FusionSetup& setup);

}  // namespace furrow::altitude
