#pragma once
#include <vector>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/altitude/shot_height.h"
#include "furrow/audit/fusion.h"
#include "furrow/sync/locate.h"

namespace furrow::project {

/// What the pictures alone say about one shot's height; unusable where they say nothing.
struct VisionHeight {
  Estimate above_canopy_m;
  std::vector<altitude::SigmaShare> shared;  ///< what other shots err by too (HeightSample::vision_shared)
  double reach_m = 0.0;  ///< how far ahead the optical axis meets the canopy; 0: not known
  Estimate outline_rise_m = {};  ///< RefinedShot::outline_rise_m; unusable where the height is none of rows
};

/// H cot(-pitch), with the cotangent at most 6 as for the outline (docs/formulation/altitude.md, eq. 8.7).
double reach_of(const altitude::RefinedShot& shot);

/// Of a shot refined alone: all but its own picture and plants is taken for shared by the flight's shots,
/// cause by cause.
VisionHeight vision_of_shot(const altitude::RefinedShot& shot);

/// Of a shot refined within a flight, which names what is shared.
VisionHeight vision_in_flight(const altitude::RefinedShot& shot);

/// Vision, depth maps (by shot, or none), barometer, downward sensor and GNSS of every shot that has a time, fused; then again with each
/// source off. Readings are those of the log at the shots. Errors: no_times, those of altitude::fuse.
Result<audit::FlightFusion> fuse_flight(const sync::Located& located, const std::vector<VisionHeight>& vision,
                                        const altitude::FieldKnowledge& field,
                                        const std::vector<VisionHeight>& depth = {});

}  // namespace furrow::project
