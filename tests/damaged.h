#pragma once

#include <cstdint>
#include <string>

#include "furrow/base/random.h"

namespace furrow::testing {

/// What becomes of a file on its way: half the time cut short, up to 19 bytes changed, sometimes a part of it
/// once more elsewhere.
inline std::string damaged(const std::string& bytes, base::Random& random) {
  std::string out = bytes;
  const auto size = [&] { return static_cast<std::uint32_t>(out.size()); };
  if (random.below(2) == 0 && !out.empty()) out.resize(random.below(size()));
  const std::uint32_t flips = random.below(20);
  for (std::uint32_t k = 0; k < flips && !out.empty(); ++k)
    out[random.below(size())] = static_cast<char>(random.below(256));
  if (random.below(4) == 0 && !out.empty()) {
    const std::uint32_t from = random.below(size());
    out.insert(random.below(size()), out.substr(from, random.below(200)));
  }
  return out;
}

}  // namespace furrow::testing
