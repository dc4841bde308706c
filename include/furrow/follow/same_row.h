#pragma once
#include <optional>
#include <vector>

#include "furrow/rows/row_lines.h"

namespace furrow::follow {

/// What to add to the row indices of `now` so that rows keep the numbers they had in `before`, a picture
/// shortly earlier of the same size: 0 while the followed row stays the nearest to the middle, +1 after the
/// camera moved over to the row on its right. Nothing when it cannot be told: rows missing in either,
/// spacings that differ by more than a quarter, or a row about half a spacing away from every other (0.35 to
/// 0.65).
std::optional<int> index_shift(const rows::RowLines& before, const rows::RowLines& now);

/// Row numbers through a sequence: the number of each picture's followed row (index 0), counted from the
/// first picture's. Nothing for pictures without rows, and from where continuity was lost until the end of
/// what can be linked: a number is never guessed. A gap of up to `most_missing` pictures without rows is
/// bridged.
std::vector<std::optional<int>> followed_rows(const std::vector<rows::RowLines>& sequence,
                                              int most_missing = 2);

}  // namespace furrow::follow
