#pragma once
#include <vector>

#include "project/pages.h"
#include "project/shot_chain.h"

namespace furrow::project {

/// Some shots with their rows, and from straight above where the flight's refinement holds them.
Result<std::vector<figures::Figure>> overlays(const std::vector<telemetry::Shot>& shots,
                                              const std::vector<ShotResult>& results,
                                              const Result<altitude::RefinedFlight>& flight);

/// Adds the figures of the page's sections on heights.
Status draw_heights(RunContent& content);

}  // namespace furrow::project
