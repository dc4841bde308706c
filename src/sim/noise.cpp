#include "sim/noise.h"

#include <cmath>

#include "furrow/base/random.h"

namespace furrow::sim {
namespace {

// Lattice values are uniform in [-1, 1] (variance 1/3); the smoothstep blend of two keeps the mean of w^2 +
// (1-w)^2 over the cell, 26/35, of it.
const double kLineNoiseSigma = std::sqrt(26.0 / 35.0 / 3.0);

float lattice_value(std::uint32_t key, std::int32_t x, std::int32_t y) {
  return static_cast<float>(lattice_hash(key, x, y) >> 8) * (2.0F / 16777216.0F) - 1.0F;
}

float fade(float q) {
  return q * q * (3.0F - 2.0F * q);
}

}  // namespace

double unit_hash(std::uint64_t key) {
  return static_cast<double>(base::mix_bits(key) >> 11) * 0x1.0p-53;
}

double line_noise(std::uint64_t key, double x, double wavelength) {
  const double at = x / wavelength;
  const double cell = std::floor(at);
  const auto value = [&](double i) {
    return 2.0 * unit_hash(key ^ base::mix_bits(static_cast<std::uint64_t>(static_cast<std::int64_t>(i)))) -
           1.0;
  };
  const double q = at - cell;
  const double w = q * q * (3.0 - 2.0 * q);
  return ((1.0 - w) * value(cell) + w * value(cell + 1.0)) / kLineNoiseSigma;
}

std::uint32_t lattice_hash(std::uint32_t key, std::int32_t x, std::int32_t y) {
  // Two rounds of multiply and shift (Wellons's lowbias32 constants) over the three words.
  std::uint32_t h = key + static_cast<std::uint32_t>(x) * 0x9e3779b1U;
  h = (h ^ (h >> 16)) * 0x7feb352dU;
  h += static_cast<std::uint32_t>(y) * 0x85ebca77U;
  h = (h ^ (h >> 15)) * 0x846ca68bU;
  return h ^ (h >> 16);
}

float plane_noise(std::uint32_t key, float x, float y) {
  const float cell_x = std::floor(x), cell_y = std::floor(y);
  const auto ix = static_cast<std::int32_t>(cell_x), iy = static_cast<std::int32_t>(cell_y);
  const float wx = fade(x - cell_x), wy = fade(y - cell_y);
  const float top = lattice_value(key, ix, iy) * (1.0F - wx) + lattice_value(key, ix + 1, iy) * wx;
  const float bottom = lattice_value(key, ix, iy + 1) * (1.0F - wx) + lattice_value(key, ix + 1, iy + 1) * wx;
  return top * (1.0F - wy) + bottom * wy;
}

}  // namespace furrow::sim
