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

constexpr int kNode_px = 8;

/// Catmull-Rom weights of the nodes before, at, after and next after a place `step` pixels beyond a node.
std::array<double, 4> cubic_weights(int step) {
  const double q = static_cast<double>(step) / kNode_px;
  return {0.5 * q * (q * (2.0 - q) - 1.0), 0.5 * (q * q * (3.0 * q - 5.0) + 2.0),
          0.5 * q * (q * (4.0 - 3.0 * q) + 1.0), 0.5 * q * q * (q - 1.0)};
}

}  // namespace

RayTable::RayTable(const Camera& camera)
    : width_(camera.width),
      height_(camera.height),
      rays_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height)) {
  // Exact directions at every kNode_px-th pixel, and one node beyond each border; Catmull-Rom cubics between
  // them. Lens distortion is so smooth that the difference stays below 1e-5 px (a test holds it).
  const int nodes_u = (width_ - 1) / kNode_px + 4, nodes_v = (height_ - 1) / kNode_px + 4;
  std::vector<Eigen::Vector2d> nodes(static_cast<std::size_t>(nodes_u) * static_cast<std::size_t>(nodes_v));
  base::parallel_for(nodes.size(), 0, [&](std::size_t i) {
    const int u = (static_cast<int>(i) % nodes_u - 1) * kNode_px,
              v = (static_cast<int>(i) / nodes_u - 1) * kNode_px;
    // A pixel beyond the lens model's fold sees nothing of the world; it gets the pinhole's direction.
    const Eigen::Vector2d pinhole((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
    nodes[i] = camera::unproject(camera, {static_cast<double>(u), static_cast<double>(v)}).value_or(pinhole);
  });
  base::parallel_for(static_cast<std::size_t>(height_), 0, [&](std::size_t row) {
    const int v = static_cast<int>(row);
    const auto weights_v = cubic_weights(v % kNode_px);
    for (int u = 0; u < width_; ++u) {
      const auto weights_u = cubic_weights(u % kNode_px);
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      for (std::size_t j = 0; j < 4; ++j) {
        const std::size_t line =
            (static_cast<std::size_t>(v / kNode_px) + j) * static_cast<std::size_t>(nodes_u);
        for (std::size_t i = 0; i < 4; ++i) {
          sum += weights_u[i] * weights_v[j] * nodes[line + static_cast<std::size_t>(u / kNode_px) + i];
        }
      }
      rays_[row * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u)] = sum;
    }
  });
  for (const Eigen::Vector2d& ray : rays_) {
    low_ = low_.cwiseMin(ray);
    high_ = high_.cwiseMax(ray);
  }
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
