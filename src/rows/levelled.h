#pragma once
#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"
#include "rows/green_map.h"

namespace furrow::rows {

/// The picture sheared along its columns so that a horizon of slope dv/du becomes level:
/// v_level = v - slope (u - u_middle). The field model is exact there for straight rows, since shears keep
/// lines, parallels and what lies at infinity. Places outside the picture repeat its border.
Image levelled(const Image& picture, double slope);

/// The same of a map's greenness alone: light and chroma stay empty.
GreenMap levelled(const GreenMap& map, double slope);

/// Rows of a levelled picture as rows of the picture itself; edges again on the same picture row as their
/// centre. Rows that come to lie nearly along the picture's rows are left out. The common field stays that of
/// the levelled picture (RowLines::horizon_slope).
void tilt_back(RowLines& lines, double slope);

}  // namespace furrow::rows
