#include "furrow/follow/same_row.h"

#include <cmath>
#include <limits>

namespace furrow::follow {
namespace {

struct Place {
  double u = std::numeric_limits<double>::quiet_NaN(), spacing = u;
};

/// Place of row 0 on the picture's middle row and the distance to a neighbour there.
Place place_of(const rows::RowLines& lines) {
  const double v = 0.5 * (lines.height - 1);
  std::optional<double> middle, left, right;
  for (const rows::RowLine& row : lines.rows) {
    if (row.index == 0) middle = rows::u_at(row, v);
    if (row.index == -1) left = rows::u_at(row, v);
    if (row.index == 1) right = rows::u_at(row, v);
  }
  Place place;
  if (!middle) return place;
  place.u = *middle;
  if (left && right) {
    place.spacing = 0.5 * (*right - *left);
  } else if (right) {
    place.spacing = *right - *middle;
  } else if (left) {
    place.spacing = *middle - *left;
  }
  return place;
}

}  // namespace

std::optional<int> index_shift(const rows::RowLines& before, const rows::RowLines& now) {
  constexpr double kSpacingChange = 0.25, kDoubtful = 0.35;
  if (!before.ok() || !now.ok() || before.width != now.width || before.height != now.height)
    return std::nullopt;
  const Place a = place_of(before), b = place_of(now);
  if (!(a.spacing > 0.0) || !(b.spacing > 0.0) || std::abs(b.spacing / a.spacing - 1.0) > kSpacingChange)
    return std::nullopt;
  // Where the old row 0 lies now, as an index of the new rows; rows move less than half a spacing between
  // pictures.
  const double index = (a.u - b.u) / b.spacing, nearest = std::round(index);
  if (std::abs(index - nearest) > kDoubtful) return std::nullopt;
  return -static_cast<int>(nearest);
}

std::vector<std::optional<int>> followed_rows(const std::vector<rows::RowLines>& sequence, int most_missing) {
  std::vector<std::optional<int>> numbers;
  std::optional<std::size_t> last;
  bool is_lost = false;
  for (std::size_t i = 0; i < sequence.size(); ++i) {
    numbers.emplace_back();
    if (is_lost || !sequence[i].ok()) continue;
    if (!last) {
      numbers[i] = 0;
    } else if (static_cast<int>(i - *last) <= most_missing + 1) {
      if (const auto shift = index_shift(sequence[*last], sequence[i])) numbers[i] = *numbers[*last] + *shift;
    }
    is_lost = !numbers[i].has_value();
    if (numbers[i]) last = i;
  }
  return numbers;
}

}  // namespace furrow::follow
