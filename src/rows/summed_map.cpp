#include "rows/summed_map.h"

#include <algorithm>
#include <array>
#include <utility>

namespace furrow::rows {

SummedMap::SummedMap(GreenMap map) : map_(std::move(map)) {
  constexpr int kTogether = 4;  // rows: one sum waits for the addition before
  const auto width = static_cast<std::size_t>(map_.width), stride = width + 2;
  sums_.resize(stride * static_cast<std::size_t>(map_.height));
  for (int top = 0; top < map_.height; top += kTogether) {
    std::array<const float*, kTogether> in{};
    std::array<float*, kTogether> out{};
    std::array<float, kTogether> sum{};
    for (int i = 0; i < kTogether; ++i) {
      const int row = std::min(top + i, map_.height - 1);
      in[static_cast<std::size_t>(i)] = map_.row(row);
      out[static_cast<std::size_t>(i)] = sums_.data() + static_cast<std::size_t>(row) * stride;
    }
    for (std::size_t u = 0; u < width; ++u)
      for (std::size_t i = 0; i < kTogether; ++i) out[i][u + 1] = sum[i] += in[i][u];
    for (std::size_t i = 0; i < kTogether; ++i) out[i][width + 1] = sum[i];
  }
}

}  // namespace furrow::rows
