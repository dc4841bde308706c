#pragma once
#include <algorithm>
#include <cmath>

namespace furrow::base {

/// The next whole number at or above `x`, no less than `low` and no more than `high`; `low` for NaN. Held in
/// its bounds before it becomes an int: a quotient by next to nothing, or by 0, fits none.
inline int ceil_between(double x, int low, int high) {
  return x > low ? static_cast<int>(std::min(std::ceil(x), static_cast<double>(high))) : low;
}

/// The next whole number at or below `x`, likewise.
inline int floor_between(double x, int low, int high) {
  return x > low ? static_cast<int>(std::min(std::floor(x), static_cast<double>(high))) : low;
}

}  // namespace furrow::base
