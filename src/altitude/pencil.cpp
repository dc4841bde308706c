#include "pencil.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "pencil_adjust.h"
#include "pencil_lines.h"
#include "pencil_start.h"

namespace furrow::altitude {
namespace {

/// Rows whose common point leaves the pitch open by more than this are parallel as far as the picture tells.
const double kParallelPitchSigma = geom::deg_to_rad(5.0);

/// Whether a line lies where an edge of its row can lie, within half a spacing (eq. 3.6): at the top edge;
/// or, for the near edge, from there to the foot of a wall as deep as the spacing, but not before the far
/// edge of the row in front. Others carry a wrong index.
bool lies_at_its_row(const EdgeLine& line, double slope, const PencilVector& x) {
  const double b = x[kPencilB], side = side_of(line);
  const double top = pencil_slope(x.data(), line);
  const double margin = 0.5 * std::abs(b);
  if (side == 0.0 || side * top >= 0.0) return std::abs(slope - top) <= margin;
  // Distances from the foot of the camera, both positive on the row's own side.
  const double away = top < 0.0 ? -1.0 : 1.0;
  const double foot = away * top / (1.0 + std::abs(b));
  const double front = away * top - std::abs(b) + 2.0 * x[kPencilG];
  const double seen = away * slope;
  return seen <= away * top + margin && seen >= std::max(foot, front) - margin;
}

}  // namespace

Result<Pencil> fit_pencil(const RowsOnUnitPlane& rows, const FieldKnowledge& field, const GimbalPrior& gimbal,
                          int least_rows) {
  FURROW_TRY(std::vector<EdgeLine> lines, usable_lines(rows, least_rows < 2 && gimbal.theta.usable()));
  const bool is_alone = distinct_rows(lines) < 2;
  const RowDirectionFit direction = fit_direction(lines);
  const bool parallel = is_alone || direction.pitch_sigma > kParallelPitchSigma;
  if (parallel && !gimbal.theta.usable()) {
    return degenerate("no_pitch", "rows that are parallel in the picture, and no pitch prior",
                      "a pitch from the gimbal");
  }
  const RelativeFarm farm = relative_farm(field);
  const PencilStart start = best_start(lines, direction, gimbal, parallel, farm);
  if (!(std::abs(start.value[kPencilPsi]) < kMaxYaw)) {
    return degenerate(
        "rows_across",
        "rows at " + base::format_fixed(geom::rad_to_deg(start.value[kPencilPsi]), 1) + " deg to the camera",
        "rows within 60 deg of the viewing direction");
  }
  lines = start.lines;
  const int needed = is_alone ? 1 : 2;
  if (distinct_rows(lines) < needed) {
    return degenerate("camera_along_horizon", "fewer than two rows below the horizon of the rows' plane",
                      "a camera that looks down on the rows");
  }
  const RowAxes<double>& axes = start.axes;
  std::vector<EdgeLine> tops = start.tops;
  Pencil pencil;
  pencil.value = start.value;
  const auto misplaced = [&](const EdgeLine& line) {
    return !lies_at_its_row(line, slope_at(axes, line), pencil.value);
  };
  const int rows_before = distinct_rows(lines);
  std::erase_if(lines, misplaced);
  std::erase_if(tops, misplaced);
  pencil.rows_left_out = rows_before - distinct_rows(lines);
  pencil.rows = distinct_rows(tops);
  if (pencil.rows < needed) {
    return degenerate("ill_conditioned", "rows that fit no set of equally spaced lines",
                      "rows in order from left to right");
  }
  const OpenParts open{parallel, is_alone};
  FURROW_DO(adjust(tops, gimbal, open, farm, pencil));
  FURROW_DO(add_top_depth(tops, gimbal, open, farm, pencil));
  pencil.blocks = group_by_row(lines);
  for (const EdgeLine& line : tops) pencil.observations += line.samples;
  return pencil;
}

}  // namespace furrow::altitude
