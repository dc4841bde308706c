#pragma once
#include <cstdint>

namespace furrow::sim {

/// Smooth random function of a line: mean 0, one-sigma 1, values change over about `wavelength`. Depends on
/// nothing but its arguments.
double line_noise(std::uint64_t key, double x, double wavelength);

/// The same on a plane, in [-1, 1] (lattice noise, one-sigma about 0.43).
float plane_noise(std::uint32_t key, float x, float y);

/// A fixed number in [0, 1) for a key.
double unit_hash(std::uint64_t key);

/// A well-mixed 32-bit hash of a lattice point.
std::uint32_t lattice_hash(std::uint32_t key, std::int32_t x, std::int32_t y);

}  // namespace furrow::sim
