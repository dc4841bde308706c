#pragma once
#include <optional>

#include "rows/green_map.h"
#include "rows/relief.h"
#include "rows/row_shape.h"

namespace furrow::rows {

/// The map without the greenness of what does not look like this picture's own leaves
/// (docs/formulation/rows.md): grass, weeds and moss in an alley are green too, and an edge of excess green
/// follows them. `tooth` is the width of a row that explains most, spacings. The map comes back as it was
/// where it has no colour, or where the rows' cores look like their surroundings (closed canopy).
GreenMap leaf_map(GreenMap map, const CommonModel& model, double tooth,
                  const std::optional<Relief>& relief = {});

}  // namespace furrow::rows
