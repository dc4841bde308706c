#include "furrow/follow/same_row.h"

#include <cmath>

namespace furrow::follow {

RowPlace place_of(const rows::RowLines& lines) {
  RowPlace place;
  if (!lines.ok()) return place;
  place.width = lines.width, place.height = lines.height;
  const double v = 0.5 * (lines.height - 1);
  std::optional<double> middle, left, right;
  for (const rows::RowLine& row : lines.rows) {
    if (row.index == 0) middle = rows::u_at(row, v);
    if (row.index == -1) left = rows::u_at(row, v);
    if (row.index == 1) right = rows::u_at(row, v);
  }
  if (!middle) return place;
  place.u_px = *middle;
  if (left && right) {
    place.spacing_px = 0.5 * (*right - *left);
  } else if (right) {
    place.spacing_px = *right - *middle;
  } else if (left) {
    place.spacing_px = *middle - *left;
  }
  return place;
}

std::optional<int> index_shift(const RowPlace& before, const RowPlace& now) {
  constexpr double kSpacingChange = 0.25, kDoubtful = 0.35;
  if (!before.is_seen() || !now.is_seen() || before.width != now.width || before.height != now.height)
    return std::nullopt;
  if (std::abs(now.spacing_px / before.spacing_px - 1.0) > kSpacingChange) return std::nullopt;
  const double spacing_px = now.usable() ? now.spacing_px : before.spacing_px;
  if (!(spacing_px > 0.0)) return 0;
  // Where the old row 0 lies now, as an index of the new rows; rows move less than half a spacing between
  // pictures.
  const double index = (before.u_px - now.u_px) / spacing_px, nearest = std::round(index);
  if (std::abs(index - nearest) > kDoubtful) return std::nullopt;
  return -static_cast<int>(nearest);
}

std::optional<int> index_shift(const rows::RowLines& before, const rows::RowLines& now) {
  return index_shift(place_of(before), place_of(now));
}

RowNumbers next_number(const RowNumbers& before, const RowPlace& now, int most_missing) {
  RowNumbers next = before;
  next.number.reset();
  if (next.is_lost) return next;
  if (!now.is_seen()) {
    next.missing += next.last_number ? 1 : 0;
    return next;
  }
  if (!next.last_number) {
    next.number = 0;
  } else if (next.missing <= most_missing) {
    if (const auto shift = index_shift(next.last, now)) next.number = *next.last_number + *shift;
  }
  next.is_lost = !next.number;
  if (!next.number) return next;
  next.last = now, next.last_number = next.number, next.missing = 0;
  if (!now.usable()) next.last.spacing_px = before.last.spacing_px;  // the neighbours went out of view
  return next;
}

std::vector<std::optional<int>> followed_rows(const std::vector<rows::RowLines>& sequence, int most_missing) {
  std::vector<std::optional<int>> numbers;
  RowNumbers state;
  for (const rows::RowLines& lines : sequence) {
    state = next_number(state, place_of(lines), most_missing);
    numbers.push_back(state.number);
  }
  return numbers;
}

}  // namespace furrow::follow
