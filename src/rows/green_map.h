#pragma once
#include <cstdint>
#include <vector>

#include "furrow/image/image.h"

namespace furrow::rows {

/// Chromas are told apart by this many levels of red's and of green's share.
inline constexpr int kChromaLevels = 64;
inline constexpr int kChromaCells = kChromaLevels * kChromaLevels;

/// Added to R + G + B so that the noise of nearly black pixels is not blown up: ten grey levels a channel,
/// about the noise and chroma error of a small JPEG.
inline constexpr float kDarkLevel = 30.0F;

/// How green a picture is, at a reduced size: chromatic excess green (2 G - R - B) / (R + G + B) (Woebbecke
/// et al. 1995), which light and shadow change little.
struct GreenMap {
  int width = 0, height = 0;
  double scale_u = 1.0, scale_v = 1.0;  ///< px of the picture per px of the map
  std::vector<float> value;             ///< width * height
  std::vector<std::uint16_t> light;     ///< R + G + B, same places; empty for a grey picture
  std::vector<std::uint16_t> chroma;    ///< cell of the chroma, below kChromaCells; empty for a grey picture

  const float* row(int v) const { return value.data() + static_cast<std::ptrdiff_t>(v) * width; }
  /// Pixel (0, 0) is a pixel's centre in both.
  double u_in_picture(double u) const { return (u + 0.5) * scale_u - 0.5; }
  double v_in_picture(double v) const { return (v + 0.5) * scale_v - 0.5; }
};

/// Area-averaged to at most `most_pixels`, never enlarged, same shape within half a pixel.
GreenMap green_map(const Image& picture, double most_pixels);

}  // namespace furrow::rows
