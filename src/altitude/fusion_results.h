#pragma once
#include "fusion_settle.h"

namespace furrow::altitude {

/// Heights, biases and what became of each source's readings.
FusedFlight describe(const std::vector<HeightSample>& samples, const Settled& settled);

}  // namespace furrow::altitude
