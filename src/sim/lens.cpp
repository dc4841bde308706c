#include "sim/lens.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "furrow/base/parallel.h"
#include "furrow/base/random.h"

namespace furrow::sim {
namespace {

constexpr double kExposure = 1.75;  // nominal gain: sunlit soil comes out at half of full scale

/// IEC 61966-2-1.
double srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

constexpr int kCurveSteps = 8192;

std::vector<float> srgb_curve() {
  std::vector<float> curve(kCurveSteps + 1);
  for (int i = 0; i <= kCurveSteps; ++i) {
    curve[static_cast<std::size_t>(i)] =
        static_cast<float>(255.0 * srgb(static_cast<double>(i) / kCurveSteps));
  }
  return curve;
}

void blur_lines(const LightImage& from, LightImage& to, const std::vector<float>& kernel, bool across) {
  const int half = static_cast<int>(kernel.size()) / 2;
  for (int v = 0; v < from.height; ++v) {
    for (int u = 0; u < from.width; ++u) {
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      for (int i = -half; i <= half; ++i) {
        const int su = across ? std::clamp(u + i, 0, from.width - 1) : u;
        const int sv = across ? v : std::clamp(v + i, 0, from.height - 1);
        sum += kernel[static_cast<std::size_t>(i + half)] *
               from.data[static_cast<std::size_t>(sv) * static_cast<std::size_t>(from.width) +
                         static_cast<std::size_t>(su)];
      }
      to.at(u, v) = sum;
    }
  }
}

LightImage blur(LightImage light, double sigma_px) {
  if (sigma_px <= 0.05) return light;
  const int half = std::max(1, static_cast<int>(std::ceil(3.0 * sigma_px)));
  std::vector<float> kernel;
  double sum = 0.0;
  for (int i = -half; i <= half; ++i) {
    const double w = std::exp(-0.5 * i * i / (sigma_px * sigma_px));
    kernel.push_back(static_cast<float>(w));
    sum += w;
  }
  for (float& w : kernel) w /= static_cast<float>(sum);
  LightImage half_done(light.width, light.height);
  blur_lines(light, half_done, kernel, true);
  blur_lines(half_done, light, kernel, false);
  return light;
}

/// Nearly normal, from the four 16-bit parts of a word: their sum has variance 4 / 12.
float noise_of(std::uint64_t bits) {
  const auto part = [bits](int i) {
    return static_cast<float>((bits >> (16 * i)) & 0xffffU) / 65536.0F - 0.5F;
  };
  return (part(0) + part(1) + part(2) + part(3)) * 1.7320508F;
}

}  // namespace

RayTable::RayTable(const Camera& camera)
    : width_(camera.width),
      height_(camera.height),
      rays_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)) {
  base::parallel_for(static_cast<std::size_t>(height_), 0, [&](std::size_t v) {
    for (int u = 0; u < width_; ++u) {
      const auto ray = camera::unproject(camera, {static_cast<double>(u), static_cast<double>(v)});
      // A pixel beyond the lens model's fold sees nothing of the world; it gets the pinhole's direction.
      const Eigen::Vector2d pinhole((u - camera.cx) / camera.fx,
                                    (static_cast<double>(v) - camera.cy) / camera.fy);
      rays_[v * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)] = ray.value_or(pinhole);
    }
  });
  for (const Eigen::Vector2d& ray : rays_) reach_ = std::max(reach_, ray.norm());
}

Eigen::Vector2d RayTable::at(double u, double v) const {
  const int u0 = std::clamp(static_cast<int>(std::floor(u)), 0, width_ - 2);
  const int v0 = std::clamp(static_cast<int>(std::floor(v)), 0, height_ - 2);
  const double a = u - u0, b = v - v0;
  return (1.0 - b) * ((1.0 - a) * pixel(u0, v0) + a * pixel(u0 + 1, v0)) +
         b * ((1.0 - a) * pixel(u0, v0 + 1) + a * pixel(u0 + 1, v0 + 1));
}

Image develop(LightImage light, const Pictures& pictures, std::uint64_t key) {
  static const std::vector<float> kCurve = srgb_curve();
  light = blur(std::move(light), pictures.blur_px);
  const auto gain = static_cast<float>(kExposure * pictures.exposure);
  const auto noise = static_cast<float>(pictures.noise);
  Image picture = image::make_image(light.width, light.height, 3);
  std::size_t out = 0;
  for (std::size_t i = 0; i < light.data.size(); ++i) {
    for (int c = 0; c < 3; ++c, ++out) {
      float value = gain * light.data[i][c];
      // Counting noise grows with the root of the light; a floor stands for the reading noise.
      value += noise * std::sqrt(std::max(value, 0.0F) + 0.02F) * noise_of(base::mix_bits(key + out));
      const float step = std::clamp(value, 0.0F, 1.0F) * static_cast<float>(kCurveSteps);
      picture.data[out] = static_cast<std::uint8_t>(kCurve[static_cast<std::size_t>(step + 0.5F)] + 0.5F);
    }
  }
  return picture;
}

}  // namespace furrow::sim
