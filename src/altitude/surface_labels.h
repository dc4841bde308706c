#pragma once
#include <vector>

#include "furrow/altitude/fuse.h"

namespace furrow::altitude {

/// What a downward sensor most likely saw at each sample, leaves or soil, before anything is fused: the
/// cheapest sequence by its steps against barometer or GNSS and by its distance from vision or depth (eq.
/// 11.4; Viterbi 1967). Samples without a reading are `nothing`; where nothing tells the two apart, leaves.
std::vector<Seen> likely_surfaces(const std::vector<HeightSample>& samples, const FuseOptions& options);

}  // namespace furrow::altitude
