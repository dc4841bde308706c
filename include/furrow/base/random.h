#pragma once
#include <cstdint>

namespace furrow::base {

/// Seeded random numbers, the same on every platform (the standard library's distributions are not). PCG32 by
/// O'Neill (2014).
class Random {
 public:
  explicit Random(std::uint64_t seed);
  std::uint32_t bits();
  /// In [0, 1).
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// In [0, n). n > 0.
  std::uint32_t below(std::uint32_t n);
  /// Gaussian, by the polar method.
  double normal(double mean = 0.0, double sigma = 1.0);

 private:
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// A well-mixed 64-bit hash of an integer (SplitMix64 finaliser): seeds that belong to a shot, a leaf or a
/// pixel.
std::uint64_t mix_bits(std::uint64_t x);

}  // namespace furrow::base
