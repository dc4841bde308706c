#include "bench/perturb.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/random.h"

namespace furrow::bench {
namespace {

Image mirrored(const Image& picture) {
  Image out = picture;
  for (int v = 0; v < picture.height; ++v)
    for (int u = 0; u < picture.width; ++u)
      std::copy_n(picture.at(picture.width - 1 - u, v), picture.channels, out.at(u, v));
  return out;
}

Image columns(const Image& picture, int first, int last) {
  Image out = image::make_image(last - first, picture.height, picture.channels);
  for (int v = 0; v < picture.height; ++v)
    std::copy_n(picture.at(first, v), static_cast<std::size_t>(out.width * out.channels), out.at(0, v));
  return out;
}

Image scaled(const Image& picture, double scale) {
  return image::resize(picture, static_cast<int>(std::lround(scale * picture.width)),
                       static_cast<int>(std::lround(scale * picture.height)));
}

/// Every channel times its gain, with noise of that sigma in grey levels.
Image relit(Image picture, const std::vector<double>& gains, double sigma) {
  base::Random random(1);
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    const double value = gains[i % gains.size()] * picture.data[i] + random.normal(0.0, sigma);
    picture.data[i] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
  }
  return picture;
}

}  // namespace

std::vector<Perturbed> perturbed_copies(const Image& original) {
  constexpr int kJpegQuality = 40;
  const int left = original.width / 16, right = original.width / 24;
  std::vector<Perturbed> copies;
  copies.push_back({.name = "mirrored", .picture = mirrored(original), .is_mirrored = true});
  copies.push_back(
      {.name = "cropped", .picture = columns(original, left, original.width - right), .first_u = left});
  for (const double scale : {0.85, 1.25})
    copies.push_back(
        {.name = scale < 1.0 ? "smaller" : "larger", .picture = scaled(original, scale), .scale = scale});
  copies.push_back({.name = "dark, red", .picture = relit(original, {0.7, 0.63, 0.6}, 0.0)});
  copies.push_back({.name = "noise", .picture = relit(original, {1.0, 1.0, 1.0}, 8.0)});
  if (auto decoded = image::decode_image(image::encode_image(original, ".jpg", kJpegQuality), "copy");
      decoded.ok())
    copies.push_back({.name = "JPEG 40", .picture = std::move(*decoded)});
  return copies;
}

rows::RowLines in_original(const rows::RowLines& lines, const Perturbed& copy, const Image& original) {
  rows::RowLines result = lines;
  result.width = original.width, result.height = original.height;
  for (rows::RowLine& row : result.rows) {
    if (copy.is_mirrored) row.index = -row.index;
    for (rows::RowSample& sample : row.samples) {
      double& u = sample.centre_px.x();
      if (copy.is_mirrored) u = lines.width - 1.0 - u;
      u = (u + 0.5) / copy.scale - 0.5 + copy.first_u;
      sample.centre_px.y() = (sample.centre_px.y() + 0.5) / copy.scale - 0.5;
    }
  }
  return result;
}

}  // namespace furrow::bench
