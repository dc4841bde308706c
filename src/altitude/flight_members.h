#pragma once
#include <vector>

#include "flight_system.h"

namespace furrow::altitude {

/// The shots that take part in a flight, in order: those whose rows settle alone and that the others do not
/// deny, prepared in parallel. The rest leave their reason in `result`, which holds a place for each shot.
std::vector<FlightMember> members_of(const std::vector<ShotInput>& shots, const Camera& camera,
                                     const FieldKnowledge& field, const Farm& farm,
                                     const FlightOptions& options, RefinedFlight& result);

}  // namespace furrow::altitude
