#include "sim/ground.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "furrow/base/random.h"
#include "sim/noise.h"

namespace furrow::sim {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kFarthest_m = 4000.0;   // beyond it the land is one with the haze
constexpr double kAirLength_m = 5000.0;  // distance over which haze takes all but 1/e
const Vector3f kHaze(0.36F, 0.41F, 0.45F);

float ramp(double x, double low, double high) {
  const double q = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return static_cast<float>(q * q * (3.0 - 2.0 * q));
}

Vector3f mix(const Vector3f& a, const Vector3f& b, float w) {
  return a + w * (b - a);
}

/// Part of a texture of that wavelength that a footprint lets through: all at four samples a wave, nothing at
/// two.
float kept(double wavelength, double footprint) {
  return static_cast<float>(std::clamp(wavelength / (2.0 * footprint) - 1.0, 0.0, 1.0));
}

struct Octave {
  double wavelength_m;
  float weight;
};

template <std::size_t N>
float texture(std::uint32_t key, double x, double y, double footprint, const std::array<Octave, N>& octaves) {
  float sum = 0.0F;
  for (const Octave& octave : octaves) {
    const float part = kept(octave.wavelength_m, footprint);
    if (part <= 0.0F) continue;
    key += 0x9e37U;
    sum += part * octave.weight *
           plane_noise(key, static_cast<float>(x / octave.wavelength_m),
                       static_cast<float>(y / octave.wavelength_m));
  }
  return sum;
}

}  // namespace

Backdrop::Backdrop(const Scene& scene, const Terrain& terrain, const RowFrame& rows, const Canopy& canopy,
                   double first_s, double last_s)
    : scene_(scene),
      terrain_(terrain),
      rows_(rows),
      canopy_(canopy),
      first_s_(first_s),
      last_s_(last_s),
      half_breadth_m_((scene.field.rows_each_side + 0.5) * scene.field.spacing_m),
      key_(static_cast<std::uint32_t>(base::mix_bits(scene.seed ^ 0x50118))) {}

Vector3f Backdrop::through_air(const Vector3f& colour, double distance_m) {
  return mix(kHaze, colour, static_cast<float>(std::exp(-distance_m / kAirLength_m)));
}

std::optional<double> Backdrop::meet_ground(const Vector3d& centre, const Vector3d& ray) const {
  const double level = std::hypot(ray.x(), ray.y());
  if (terrain_.flat()) {
    const double closing = terrain_.slope().dot(ray.head<2>()) - ray.z();
    const double above = centre.z() - terrain_.height(centre.x(), centre.y());
    const double t = above / closing;
    if (!(closing > 0.0) || above <= 0.0 || t * level > kFarthest_m) return std::nullopt;
    return t;
  }
  // No step can pass the ground: the gap closes at most at the ray's own fall plus the steepest slope.
  const double fastest = terrain_.steepest() * level - ray.z();
  if (fastest <= 0.0) return std::nullopt;
  constexpr double kTouch_m = 0.002;
  constexpr int kMostSteps = 200;
  double t = 0.0;
  for (int i = 0; i < kMostSteps; ++i) {
    const Vector3d at = centre + t * ray;
    const double gap = at.z() - terrain_.height(at.x(), at.y());
    if (gap < kTouch_m * (1.0 + t)) return t;
    t += gap / fastest;
    if (t * level > kFarthest_m) return std::nullopt;
  }
  return t;
}

Vector3f Backdrop::soil(double s, double l, double footprint_s, double footprint_l) const {
  const Field& f = scene_.field;
  const double across = l - f.spacing_m * std::round(l / f.spacing_m);
  const double footprint = std::max(footprint_s, footprint_l);
  constexpr std::array<Octave, 8> kClods = {{{3.1, 0.10F},
                                             {1.1, 0.10F},
                                             {0.37, 0.11F},
                                             {0.13, 0.15F},
                                             {0.055, 0.20F},
                                             {0.023, 0.24F},
                                             {0.009, 0.24F},
                                             {0.004, 0.15F}}};
  Vector3f colour(static_cast<float>(f.soil_rgb[0]), static_cast<float>(f.soil_rgb[1]),
                  static_cast<float>(f.soil_rgb[2]));
  colour *= 1.0F + texture(key_, s, l, footprint, kClods);
  // Tillage marks run along the rows; two wheel tracks press each alley smooth and pale.
  const float marks = kept(0.16, footprint_l) *
                      plane_noise(key_ + 5, static_cast<float>(l / 0.16), static_cast<float>(s / 6.0));
  colour *= 1.0F + 0.10F * marks;
  const double track = std::abs(std::abs(across) - 0.5 * f.spacing_m) - 0.24 * f.spacing_m;
  colour *= 1.0F + 0.10F * (1.0F - ramp(std::abs(track) / f.spacing_m, 0.02, 0.07));

  // Grass keeps to the middle of the alleys and grows in patches.
  constexpr std::array<Octave, 4> kPatches = {{{2.3, 0.6F}, {0.8, 0.45F}, {0.3, 0.35F}, {0.1, 0.3F}}};
  const double from_row = std::abs(across) / (0.5 * f.spacing_m);
  const double lush = 0.5 * (1.0 + static_cast<double>(texture(key_ + 77, s, l, footprint, kPatches))) +
                      0.55 * static_cast<double>(ramp(from_row, 0.25, 0.9)) - 0.35;
  const double limit = 1.25 - 1.3 * f.grass_cover;
  const float grass = f.grass_cover > 0.0 ? ramp(lush, limit - 0.12, limit + 0.12) : 0.0F;
  if (grass <= 0.0F) return colour;
  constexpr std::array<Octave, 4> kBlades = {{{0.5, 0.12F}, {0.12, 0.18F}, {0.04, 0.25F}, {0.014, 0.3F}}};
  const float blades = texture(key_ + 99, s, l, footprint, kBlades);
  const float dry = ramp(
      static_cast<double>(plane_noise(key_ + 111, static_cast<float>(s / 4.0), static_cast<float>(l / 2.0))),
      -0.6, 0.8);
  const Vector3f green = mix({0.070F, 0.105F, 0.030F}, {0.17F, 0.145F, 0.065F}, dry) * (1.0F + blades);
  return mix(colour, green, grass * (0.75F + 0.25F * std::clamp(0.5F + 2.0F * blades, 0.0F, 1.0F)));
}

Vector3f Backdrop::land(double s, double l, double footprint) const {
  constexpr std::array<Octave, 4> kFields = {{{90.0, 0.5F}, {31.0, 0.4F}, {9.0, 0.2F}, {2.0, 0.2F}}};
  constexpr std::array<Octave, 3> kFine = {{{0.6, 0.15F}, {0.2, 0.15F}, {0.06, 0.2F}}};
  const float kind = texture(key_ + 200, s, l, footprint, kFields);
  const Vector3f colour =
      mix({0.22F, 0.18F, 0.10F}, {0.10F, 0.125F, 0.05F}, ramp(static_cast<double>(kind), -0.35, 0.35));
  return colour * (1.0F + texture(key_ + 300, s, l, footprint, kFine));
}

Vector3f Backdrop::sky(const Vector3d& ray, double pixel_angle) const {
  const Vector3d toward = ray.normalized();
  const double up = std::asin(std::clamp(toward.z(), -1.0, 1.0));
  const double around = std::atan2(toward.y(), toward.x());
  const Vector3f high(0.13F, 0.25F, 0.52F), low(0.44F, 0.50F, 0.56F);
  Vector3f colour = mix(low, high, 1.0F - static_cast<float>(std::exp(-std::max(0.0, up) / 0.22)));
  // A far ridge, and a line of trees and houses before it.
  const auto a = static_cast<float>(around);
  const float ridge = 0.030F + 0.016F * plane_noise(key_ + 400, a * 4.0F, 0.5F) +
                      0.007F * plane_noise(key_ + 401, a * 13.0F, 0.5F);
  const float trees = 0.006F + 0.004F * plane_noise(key_ + 402, a * 40.0F, 0.5F) +
                      0.004F * plane_noise(key_ + 403, a * 160.0F, 0.5F);
  const double soft = 0.7 * pixel_angle;
  colour = mix(colour, {0.20F, 0.255F, 0.31F}, 1.0F - ramp(up - static_cast<double>(ridge), -soft, soft));
  return mix(colour, {0.075F, 0.095F, 0.07F}, 1.0F - ramp(up - static_cast<double>(trees), -soft, soft));
}

Backdrop::Hit Backdrop::look(const Vector3d& centre, const Vector3d& ray, double pixel_angle) const {
  Hit hit;
  const std::optional<double> t = meet_ground(centre, ray);
  if (!t) {
    hit.colour = sky(ray, pixel_angle);
    return hit;
  }
  const Vector3d at = centre + *t * ray;
  const double distance_m = *t * ray.norm();
  const double across_m = distance_m * pixel_angle;
  const double level = std::hypot(ray.x(), ray.y());
  const double graze = std::max(1e-4, -ray.z() / ray.norm());
  const double away_m = across_m / graze;
  const Eigen::Vector2d row = rows_.row_from_plan(at.x(), at.y());
  const double s = row.x(), l = row.y();
  const double direction = rows_.direction(s);
  const bool in_field = std::abs(l) < half_breadth_m_ && s > first_s_ && s < last_s_;
  if (in_field) {
    const double cosine =
        level > 0.0 ? (std::cos(direction) * ray.x() + std::sin(direction) * ray.y()) / level : 1.0;
    const double sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
    const double footprint_s = std::abs(cosine) * away_m + sine * across_m;
    const double footprint_l = sine * away_m + std::abs(cosine) * across_m;
    // Leaves leave a ragged edge and let flecks of sun through.
    constexpr std::array<Octave, 3> kFlecks = {{{0.45, 0.5F}, {0.16, 0.5F}, {0.06, 0.45F}}};
    const auto flecks =
        static_cast<double>(texture(key_ + 500, s, l, std::max(footprint_s, footprint_l), kFlecks));
    const double sun =
        canopy_.sunlight(s, l + 0.16 * flecks, 0.0, direction) + std::clamp(2.2 * (flecks - 0.33), 0.0, 0.55);
    // Sky that the plants hide from the soil beside them.
    const double across = std::abs(l - scene_.field.spacing_m * std::round(l / scene_.field.spacing_m));
    const double open = 0.45 + 0.55 * static_cast<double>(ramp(across, 0.0, 1.6 * scene_.field.half_width_m));
    const Vector3f light = kSunColour * static_cast<float>(std::min(sun, 1.0)) +
                           kSkyColour * static_cast<float>(scene_.sun.diffuse * open);
    hit.colour = soil(s, l, footprint_s, footprint_l).cwiseProduct(light);
  } else {
    hit.colour = land(s, l, std::max(across_m, away_m)) * static_cast<float>(1.0 + scene_.sun.diffuse);
  }
  hit.colour = through_air(hit.colour, distance_m);
  hit.inverse_depth = static_cast<float>(1.0 / *t);
  return hit;
}

}  // namespace furrow::sim
