#pragma once
#include <string>

#include "furrow/sim/scene.h"

namespace furrow::sim {

/// The flight's log in AirData's CSV export format: its columns in its order, feet and miles per hour.
std::string airdata_csv(const Scene& scene);

}  // namespace furrow::sim
