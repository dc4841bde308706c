#pragma once
#include <algorithm>
#include <array>
#include <cmath>

#include "furrow/base/random.h"
#include "furrow/image/image.h"
#include "furrow/rows/planar_field.h"

namespace furrow::rows::testing {

/// A field drawn from its own model, so that every edge is known exactly.
struct DrawnField {
  PlanarField field;
  int width = 640, height = 480;
  double half_width = 0.2;  ///< of a row, spacings
  double ragged = 0.0;      ///< one-sigma of the edges along the row, spacings
  double noise = 6.0;       ///< one-sigma, grey levels
  double grass = 0.0;       ///< half width of row and a strip of grass along it, spacings; 0: none
  std::array<double, 3> grass_colour = {92.0, 120.0, 58.0};
  double leaf_contrast = 0.0;   ///< one-sigma of the light of a leaf, 4 px wide, relative
  double gaps = 0.0;            ///< part of the plants that are missing
  double light_gradient = 0.0;  ///< relative change of light from left to right
  std::uint64_t seed = 1;
};

/// Coverage of each pixel by leaf is exact along the picture row; colours mix linearly, as light does on a
/// sensor.
inline Image draw(const DrawnField& drawn) {
  constexpr double kLeaf[] = {55.0, 105.0, 40.0}, kSoil[] = {150.0, 125.0, 95.0},
                   kSky[] = {170.0, 195.0, 225.0};
  constexpr double kBox = 1.15;  // px: half of sqrt(12 (1/12 + 0.6^2))
  base::Random random(drawn.seed);
  Image picture = image::make_image(drawn.width, drawn.height, 3);
  const auto wobble = [&](int k, double y, int side) {  // smooth along the row, its own for each side
    const auto at = [&](int i) {
      base::Random one(base::mix_bits(drawn.seed * 7919 +
                                      static_cast<std::uint64_t>((k + 500) * 4096 + side * 2048 + i + 1024)));
      return one.normal();
    };
    const double place = y * 40.0, whole = std::floor(place), part = place - whole;
    return drawn.ragged *
           (at(static_cast<int>(whole)) * (1.0 - part) + at(static_cast<int>(whole) + 1) * part);
  };
  const auto is_gap = [&](int k, double y) {
    base::Random one(base::mix_bits(
        drawn.seed * 104729 +
        static_cast<std::uint64_t>((k + 500) * 8192 + static_cast<int>(std::floor(y * 12.0)) + 4096)));
    return one.uniform() < drawn.gaps;
  };
  for (int v = 0; v < drawn.height; ++v) {
    const double scale = drawn.field.scale(v);
    for (int u = 0; u < drawn.width; ++u) {
      double cover = 0.0;
      if (scale > 0.01) {
        const double y = drawn.field.t(v) / scale;
        const int k = static_cast<int>(std::lround(drawn.field.k_at(u, v)));
        for (int row = k - 1; row <= k + 1; ++row) {
          if (is_gap(row, y)) continue;
          const double spacing = drawn.field.spacing_at(v), centre = drawn.field.u_at(v, row);
          const double left = centre - (drawn.half_width + wobble(row, y, 0)) * spacing;
          const double right = centre + (drawn.half_width + wobble(row, y, 1)) * spacing;
          cover += std::max(0.0, std::min(right, u + kBox) - std::max(left, u - kBox)) / (2.0 * kBox);
        }
      }
      cover = std::min(cover, 1.0);
      bool is_grass = false;
      if (scale > 0.01 && drawn.grass > 0.0) {
        const double k = drawn.field.k_at(u, v);
        is_grass = std::abs(k - std::round(k)) < drawn.grass;
      }
      base::Random leaf(
          base::mix_bits(drawn.seed * 15485863 + static_cast<std::uint64_t>((v / 4) * 8192 + u / 4)));
      const double leaf_light =
          drawn.leaf_contrast > 0.0 ? std::exp(drawn.leaf_contrast * leaf.normal()) : 1.0;
      const double light = 1.0 + drawn.light_gradient * (u / (drawn.width - 1.0) - 0.5);
      for (int i = 0; i < 3; ++i) {
        const double ground = scale <= 0.01 ? kSky[i]
                              : is_grass    ? drawn.grass_colour[static_cast<std::size_t>(i)]
                                            : kSoil[i];
        const double value = light * (cover * leaf_light * kLeaf[i] + (1.0 - cover) * ground) +
                             random.normal(0.0, drawn.noise);
        picture.at(u, v)[i] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
      }
    }
  }
  return picture;
}

inline DrawnField oblique(int width = 640, int height = 480) {
  DrawnField drawn;
  drawn.width = width, drawn.height = height;
  drawn.field.u0 = 0.5 * (width - 1), drawn.field.v0 = height - 1.0, drawn.field.length = height;
  drawn.field.convergence = 0.8;
  drawn.field.spacing = 0.34 * width;
  drawn.field.offset = 0.07 * width;
  drawn.field.slope = 0.05 * width;
  return drawn;
}

inline DrawnField nadir(int width = 640, int height = 480) {
  DrawnField drawn = oblique(width, height);
  drawn.field.convergence = 0.0;
  drawn.field.spacing = 0.12 * width;
  drawn.field.slope = 0.0;
  return drawn;
}

}  // namespace furrow::rows::testing
