#pragma once
#include <optional>

#include "fusion_state.h"

namespace furrow::altitude {

/// One source's reading as a scalar measurement of the state.
struct Reading {
  State row;
  double value = 0.0, sigma = 1.0;
};

/// A source's reading at a sample, with its noise as the flight shows it, or nothing when it is silent or not
/// used. `vps`: what a downward sensor is taken to have seen.
std::optional<Reading> reading_of(const HeightSample& s, HeightSource source, Seen vps,
                                  const FusionSetup& setup);

/// Whether a source speaks at any sample.
bool any(const std::vector<HeightSample>& samples, HeightSource source, const FusionSetup& setup);
/// Whether one does whose zero is the canopy.
bool any_absolute(const std::vector<HeightSample>& samples, const FusionSetup& setup);

}  // namespace furrow::altitude
