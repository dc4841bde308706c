#pragma once
#include <vector>

#include "furrow/rows/row_lines.h"
#include "rows/common_model.h"
#include "rows/summed_map.h"

namespace furrow::rows {

/// Gives the rows their own centres and the edges of their visible green, from a map that may be finer than
/// the search's. `rows` come with samples at the model's places; samples that show no row of their own keep
/// them.
void shape_rows(const SummedMap& map, const CommonModel& model, std::vector<RowLine>& rows);

}  // namespace furrow::rows
