#pragma once
#include "furrow/altitude/field_knowledge.h"
#include "row_block.h"

namespace furrow::altitude {

/// Half width over spacing with sigma, the shape of the tops, and the rows' wander over spacing.
struct RelativeFarm {
  Estimate width_ratio;
  Estimate log_top_depth;  ///< of the rounded top over the half width
  RowWander wander;
};

RelativeFarm relative_farm(const FieldKnowledge& field);

}  // namespace furrow::altitude
