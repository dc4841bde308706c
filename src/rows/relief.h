#pragma once
#include <optional>

#include "rows/green_map.h"
#include "rows/row_shape.h"

namespace furrow::rows {

/// What of a row is in sight at some place of the picture.
enum class Surface { top, wall, ground };

/// Tall rows over the ground they stand on, in real-valued row numbers of a field: lines parallel to the rows
/// keep theirs whatever their height, and what lies lower has its number nearer to the one below the camera.
struct Relief {
  double middle = 0.0;      ///< axis of the top nearest the picture's middle
  double spacing = 1.0;     ///< between tops
  double half_width = 0.2;  ///< of tops
  double camera = 0.0;      ///< below the camera
  double foot = 0.7;        ///< height of the camera above the tops over that above the ground

  Surface surface_at(double k) const;
  /// The same relief where row 0 is the top at `middle` and its neighbours are 1 and -1.
  Relief in_own_rows() const;
  /// The same relief where every row has a number so much larger.
  Relief renumbered(double more) const;
};

/// The relief that explains a picture.
struct FoundRelief {
  Relief relief;
  /// Its tops are not the field's rows, and explain much more than tops there do: strips of grass that are
  /// greener than the crop make rows, too, but walls hide them ever more to the sides.
  bool elsewhere = false;
};

/// The tops, walls and ground of any look that explain the picture best; with tops at the field's rows where
/// none explain it much better. `level` is the picture's map, levelled; the field's rows are straight and
/// meet in its picture. Nothing without colour or where rows are parallel in the picture.
std::optional<FoundRelief> find_relief(const GreenMap& level, const PlanarField& field);

}  // namespace furrow::rows
