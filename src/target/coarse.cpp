#include "target/coarse.h"

#include <algorithm>
#include <cmath>

namespace furrow::target {

Coarse coarse_copy(const Image& grey, int longest_px) {
  const int longest = std::max(grey.width, grey.height);
  if (longest <= longest_px) return {grey, 1.0, 1.0};
  const double scale = static_cast<double>(longest_px) / longest;
  const int width = std::max(1, static_cast<int>(std::lround(grey.width * scale)));
  const int height = std::max(1, static_cast<int>(std::lround(grey.height * scale)));
  return {image::resize(grey, width, height), static_cast<double>(grey.width) / width,
          static_cast<double>(grey.height) / height};
}

}  // namespace furrow::target
