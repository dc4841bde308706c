#pragma once
#include <cstddef>
#include <vector>

#include "rows/green_map.h"

namespace furrow::rows {

/// A map with the running sum of each of its rows, which takes longer than a look at the rows through it.
class SummedMap {
 public:
  explicit SummedMap(GreenMap map);
  const GreenMap& map() const { return map_; }
  /// running(row)[u] is the sum over [0, u) for 0 <= u <= width, and once more at width + 1, so that places
  /// between need no test.
  const float* running(int row) const {
    return sums_.data() + static_cast<std::ptrdiff_t>(row) * (map_.width + 2);
  }

 private:
  GreenMap map_;
  std::vector<float> sums_;
};

}  // namespace furrow::rows
