#pragma once
#include <limits>
#include <optional>
#include <vector>

#include "furrow/rows/row_lines.h"

namespace furrow::follow {

/// Where a picture's rows cross its middle row: all that row numbers are kept by.
struct RowPlace {
  double u_px = std::numeric_limits<double>::quiet_NaN();        ///< of row 0
  double spacing_px = std::numeric_limits<double>::quiet_NaN();  ///< to its neighbours, when there are any
  int width = 0, height = 0;                                     ///< of the picture

  bool is_seen() const { return u_px == u_px; }
  bool usable() const { return spacing_px > 0.0 && is_seen(); }
};

/// Not seen where no row crosses the picture's middle row; without a spacing where only one does.
RowPlace place_of(const rows::RowLines& lines);

/// What to add to the row indices of `now` so that rows keep the numbers they had in `before`, a picture
/// shortly earlier of the same size: 0 while the followed row stays the nearest to the middle, +1 after the
/// camera moved over to the row on its right. Nothing when it cannot be told: rows missing in either,
/// spacings that differ by more than a quarter, or a row about half a spacing away from every other (0.35 to
/// 0.65). A row alone in one of them goes by the other's spacing; alone in both it is the same: there is no
/// other to take it for.
std::optional<int> index_shift(const RowPlace& before, const RowPlace& now);
std::optional<int> index_shift(const rows::RowLines& before, const rows::RowLines& now);

/// Row numbers through a sequence, picture by picture.
struct RowNumbers {
  RowPlace last;  ///< of the last picture whose number is known
  std::optional<int> last_number;
  int missing = 0;       ///< pictures since
  bool is_lost = false;  ///< continuity was lost; only a new start helps
  /// Number of this picture's row 0, counted from the first picture's; nothing when it cannot be told.
  std::optional<int> number;
};

/// The numbers after one more picture. A gap of up to `most_missing` pictures without rows is bridged; from
/// where continuity is lost no number is given: it is never guessed.
RowNumbers next_number(const RowNumbers& before, const RowPlace& now, int most_missing = 2);

/// The same for a whole sequence.
std::vector<std::optional<int>> followed_rows(const std::vector<rows::RowLines>& sequence,
                                              int most_missing = 2);

}  // namespace furrow::follow
