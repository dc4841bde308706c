#pragma once
#include <array>
#include <vector>

#include "fusion_readings.h"

namespace furrow::altitude {

/// What each reading was taken for in the last pass.
struct Labels {
  std::array<bool, kHeightSources> left_out = {};
  Seen vps = Seen::nothing;
};

bool takes_part(const Labels& labels, HeightSource source);

/// Everything takes part at first; a downward sensor's surface is the likeliest by the sources of `options`.
std::vector<Labels> first_labels(const std::vector<HeightSample>& samples, const FuseOptions& options);

/// What each reading is taken for by all of them: canopy, soil, or one too far from the rest. `before`: what
/// it was taken for when `beliefs` were made (eq. 11.3).
std::vector<Labels> next_labels(const std::vector<HeightSample>& samples, const std::vector<Belief>& beliefs,
                                const std::vector<Labels>& before, const FusionSetup& setup);

bool same(const std::vector<Labels>& a, const std::vector<Labels>& b);

/// Whether all downward readings were taken for one surface.
bool on_one_level(const std::vector<Labels>& labels);

}  // namespace furrow::altitude
