#include "furrow/base/random.h"

#include <cmath>

namespace furrow::base {
namespace {
constexpr std::uint64_t kMultiplier = 6364136223846793005ULL;  // PCG32, pcg-random.org
constexpr std::uint64_t kIncrement = 1442695040888963407ULL;
}  // namespace

Random::Random(std::uint64_t seed) : state_(mix_bits(seed) + kIncrement) {
  bits();
}

std::uint32_t Random::bits() {
  const std::uint64_t old = state_;
  state_ = old * kMultiplier + kIncrement;
  const auto shifted = static_cast<std::uint32_t>(((old >> 18U) ^ old) >> 27U);
  const auto rotation = static_cast<std::uint32_t>(old >> 59U);
  return (shifted >> rotation) | (shifted << ((-rotation) & 31U));
}

double Random::uniform() {
  const std::uint64_t high = bits();
  const std::uint64_t low = bits();
  return static_cast<double>(((high << 32U) | low) >> 11U) * 0x1.0p-53;
}

std::uint32_t Random::below(std::uint32_t n) {
  const std::uint32_t unfair = (-n) % n;  // values under this would favour small results
  while (true) {
    const std::uint32_t value = bits();
    if (value >= unfair) return value % n;
  }
}

double Random::normal(double mean, double sigma) {
  if (has_spare_) {
    has_spare_ = false;
    return mean + sigma * spare_;
  }
  double x = 0.0;
  double y = 0.0;
  double r2 = 0.0;
  do {
    x = uniform(-1.0, 1.0);
    y = uniform(-1.0, 1.0);
    r2 = x * x + y * y;
  } while (r2 >= 1.0 || r2 == 0.0);
  const double scale = std::sqrt(-2.0 * std::log(r2) / r2);
  spare_ = y * scale;
  has_spare_ = true;
  return mean + sigma * x * scale;
}

std::uint64_t mix_bits(std::uint64_t x) {
  x += 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return x ^ (x >> 31U);
}

}  // namespace furrow::base
