#pragma once
#include <optional>
#include <vector>

#include "furrow/rows/row_lines.h"
#include "furrow/stats/estimate.h"
#include "rows/green_map.h"
#include "rows/common_model.h"

namespace furrow::rows {

/// The far edge of a row's top, where the light along the rows drops.
struct TopEdge {
  int row = 0;     ///< index, counted from the followed row
  Estimate place;  ///< real-valued row number in the model that was looked through
};

/// Tops of the rows beside the followed one, in row numbers of the model that was looked through.
struct TopComb {
  double middle = 0.0, spacing = 1.0;  ///< of the tops
  std::vector<TopEdge> edges;
};

struct FoundTops {
  /// Nothing where the followed row or its neighbours show no edges against the ground, or no light drops.
  std::optional<TopComb> comb;
  double explained = 0.0;  ///< part of the light's squares beside the followed row that the comb explains
  /// dv/du by which the plane of the tops is tilted against the one that was looked through, where that
  /// explains clearly more, else 0: on ground that slopes across, rows lie ever wider apart on the one side
  /// and ever closer on the other. Rows and tops are then to be found again in the picture levelled by it.
  double tilt = 0.0;
};

/// Finds the tops' far edges where they stand against the leaves of the next row, too: low above the canopy
/// neighbours hide the alleys, and green shows no edge. A top is lit by the whole sky and the wall behind it
/// is not, least of all at its foot, so the light along the rows drops at the far edge
/// (docs/formulation/rows.md). `tilt` is dv/du of the horizon.
FoundTops find_tops(const GreenMap& map, const CommonModel& model, double tilt,
                    const std::vector<RowLine>& rows);

/// Writes them into the rows of a field that has the tops' spacing, row 0 the followed one
/// (RowSample::top_left_u_px, top_right_u_px).
void write_tops(const TopComb& comb, const PlanarField& field, double tilt, std::vector<RowLine>& rows);

}  // namespace furrow::rows
