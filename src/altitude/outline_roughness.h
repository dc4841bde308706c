#pragma once
#include "furrow/altitude/unit_plane.h"
#include "shot_system.h"

namespace furrow::altitude {

/// One-sigma by which the outline of the canopy wanders sideways along the rows, metres: the scatter of far
/// edges against the ground about straight lines, where they lie near enough for leaves to be told from
/// pixels (eq. 8.9). The median of all such edges at x; NaN where there is none.
double outline_roughness_m(const RowsOnUnitPlane& rows, const ShotVector& x);

}  // namespace furrow::altitude
