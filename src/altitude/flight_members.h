#pragma once
#include <vector>

#include "flight_system.h"

namespace furrow::altitude {

/// The shots that take part in a flight, in order: those whose rows settle alone and that the others do not
/// deny, prepared in parallel. The rest leave their reason in `result`, which holds a place for each shot.
std::vector<FlightMember> members_of(const std::vector<ShotInput>& shots, const Camera& camera,
                                     const FieldKnowledge& field, const Farm& farm,
                                     const FlightOptions& options, RefinedFlight& result);

/// Takes out members whose rows miss what the flight shows together, which `result` describes: rows that fit
/// some field alone may not fit this one. `member_rms` are their misfits. False when there are none. Heights
/// are not asked again: in the flight the log's steps tie them.
bool leave_out_misfits(const std::vector<ShotInput>& shots, const std::vector<double>& member_rms,
                       const FlightOptions& options, std::vector<FlightMember>& members,
                       RefinedFlight& result);

}  // namespace furrow::altitude
