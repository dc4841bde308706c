#include "target/saddle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace furrow::target {
namespace {

constexpr double kPi = std::numbers::pi;

/// Weakest saddle: a corner of 10 grey levels' contrast after the blur has Ixy = 2, squared.
constexpr double kWeakestSaddle = 4.0;
/// Most saddles that are looked at: bounds the work on foliage and noise.
constexpr std::size_t kMostSaddles = 4000;
/// Circle on which a corner's four sides are told apart, px, and the samples on it.
constexpr double kRingPx = 4.0;
constexpr int kRingSamples = 32;
/// Weakest corner, grey levels between its bright and dark squares.
constexpr double kWeakestContrast = 10.0;

/// 1-4-6-4-1 along a line of `count` values `step` apart; ends are carried outwards.
void blur_line(const float* in, float* out, int count, std::ptrdiff_t step) {
  const auto at = [&](int i) { return in[std::clamp(i, 0, count - 1) * step]; };
  for (int i = 0; i < count; ++i) {
    out[i * step] = (at(i - 2) + at(i + 2) + 4.0F * (at(i - 1) + at(i + 1)) + 6.0F * at(i)) / 16.0F;
  }
}

struct Hessian {
  double uu, uv, vv, u, v;
  double strength() const { return uv * uv - uu * vv; }
};

Hessian hessian(const SmoothGrey& g, int u, int v) {
  const double middle = g.at(u, v);
  Hessian out;
  out.u = 0.5 * (g.at(u + 1, v) - g.at(u - 1, v));
  out.v = 0.5 * (g.at(u, v + 1) - g.at(u, v - 1));
  out.uu = g.at(u + 1, v) - 2.0 * middle + g.at(u - 1, v);
  out.vv = g.at(u, v + 1) - 2.0 * middle + g.at(u, v - 1);
  out.uv = 0.25 * (g.at(u + 1, v + 1) - g.at(u - 1, v + 1) - g.at(u + 1, v - 1) + g.at(u - 1, v - 1));
  return out;
}

bool is_local_maximum(const std::vector<float>& strength, int width, int u, int v) {
  constexpr int kReach = 2;
  const auto at = [&](int a, int b) {
    return strength[static_cast<std::size_t>(b) * static_cast<std::size_t>(width) +
                    static_cast<std::size_t>(a)];
  };
  const float own = at(u, v);
  for (int dv = -kReach; dv <= kReach; ++dv) {
    for (int du = -kReach; du <= kReach; ++du) {
      const float other = at(u + du, v + dv);
      // Of equal neighbours the first in reading order stays.
      if (other > own || (other == own && (dv < 0 || (dv == 0 && du < 0)))) return false;
    }
  }
  return true;
}

/// Angles at which the ring crosses its middle level, in order; `rises` tells the way.
struct Crossing {
  double angle_rad;
  bool rises;
};

std::vector<Crossing> crossings(const std::array<double, kRingSamples>& ring, double level) {
  std::vector<Crossing> out;
  constexpr double kStep = 2.0 * kPi / kRingSamples;
  for (int i = 0; i < kRingSamples; ++i) {
    const double a = ring[static_cast<std::size_t>(i)] - level;
    const double b = ring[static_cast<std::size_t>((i + 1) % kRingSamples)] - level;
    if ((a > 0.0) == (b > 0.0)) continue;
    out.push_back({-kPi + kStep * (i + a / (a - b)), b > 0.0});
  }
  return out;
}

std::optional<CornerSeed> seed_at(const SmoothGrey& grey, const Saddle& saddle) {
  std::array<double, kRingSamples> ring{};
  for (int i = 0; i < kRingSamples; ++i) {
    const double angle = -kPi + 2.0 * kPi * i / kRingSamples;
    const Eigen::Vector2d px = saddle.px + kRingPx * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    if (!grey.inside(px)) return std::nullopt;
    ring[static_cast<std::size_t>(i)] = grey.sample(px);
  }
  const auto [low, high] = std::minmax_element(ring.begin(), ring.end());
  CornerSeed out;
  out.px = saddle.px;
  out.contrast = *high - *low;
  if (out.contrast < kWeakestContrast) return std::nullopt;
  const std::vector<Crossing> found = crossings(ring, 0.5 * (*low + *high));
  if (found.size() != 4) return std::nullopt;
  for (std::size_t i = 0; i < 4; ++i) {
    out.ray_rad[i] = found[i].angle_rad;
    out.bright_beyond[i] = found[i].rises;
  }
  // Edges run straight through: opposite crossings are half a turn apart. And no square's corner is a needle.
  constexpr double kStraight_rad = 0.6, kThinnest_rad = 0.2;
  if (std::abs(out.ray_rad[2] - out.ray_rad[0] - kPi) > kStraight_rad) return std::nullopt;
  if (std::abs(out.ray_rad[3] - out.ray_rad[1] - kPi) > kStraight_rad) return std::nullopt;
  for (std::size_t i = 0; i < 4; ++i) {
    const double gap =
        i < 3 ? out.ray_rad[i + 1] - out.ray_rad[i] : out.ray_rad[0] + 2.0 * kPi - out.ray_rad[3];
    if (gap < kThinnest_rad) return std::nullopt;
  }
  return out;
}

}  // namespace

double SmoothGrey::sample(const Eigen::Vector2d& px) const {
  const int u = static_cast<int>(px.x()), v = static_cast<int>(px.y());
  const double a = px.x() - u, b = px.y() - v;
  return (1 - b) * ((1 - a) * at(u, v) + a * at(u + 1, v)) +
         b * ((1 - a) * at(u, v + 1) + a * at(u + 1, v + 1));
}

SmoothGrey smooth(const Image& grey) {
  SmoothGrey out{grey.width, grey.height, std::vector<float>(grey.data.begin(), grey.data.end())};
  std::vector<float> along(out.data.size());
  for (int v = 0; v < out.height; ++v)
    blur_line(&out.data[grey.offset(0, v)], &along[grey.offset(0, v)], out.width, 1);
  for (int u = 0; u < out.width; ++u)
    blur_line(&along[grey.offset(u, 0)], &out.data[grey.offset(u, 0)], out.height, out.width);
  return out;
}

std::vector<Saddle> find_saddles(const SmoothGrey& grey, SearchWork& work) {
  std::vector<float> strength(grey.data.size(), 0.0F);
  for (int v = 1; v + 1 < grey.height; ++v) {
    for (int u = 1; u + 1 < grey.width; ++u) {
      strength[static_cast<std::size_t>(v) * static_cast<std::size_t>(grey.width) +
               static_cast<std::size_t>(u)] = static_cast<float>(hessian(grey, u, v).strength());
    }
  }
  std::vector<Saddle> out;
  for (int v = 2; v + 2 < grey.height; ++v) {
    for (int u = 2; u + 2 < grey.width; ++u) {
      const float own = strength[static_cast<std::size_t>(v) * static_cast<std::size_t>(grey.width) +
                                 static_cast<std::size_t>(u)];
      if (static_cast<double>(own) < kWeakestSaddle || !is_local_maximum(strength, grey.width, u, v))
        continue;
      const Hessian h = hessian(grey, u, v);
      // Where the gradient of the local quadratic vanishes; det = -strength.
      const Eigen::Vector2d step(-(h.vv * h.u - h.uv * h.v) / -h.strength(),
                                 -(h.uu * h.v - h.uv * h.u) / -h.strength());
      constexpr double kLongestStep = 1.5;
      if (step.norm() > kLongestStep) continue;
      out.push_back({Eigen::Vector2d(u, v) + step, static_cast<double>(own)});
    }
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Saddle& a, const Saddle& b) { return a.strength > b.strength; });
  if (out.size() > kMostSaddles) {
    out.resize(kMostSaddles);
    work.leave_out();
  }
  return out;
}

std::vector<CornerSeed> find_corner_seeds(const SmoothGrey& grey, const std::vector<Saddle>& saddles) {
  std::vector<CornerSeed> out;
  for (const Saddle& saddle : saddles) {
    if (const auto seed = seed_at(grey, saddle)) out.push_back(*seed);
  }
  return out;
}

}  // namespace furrow::target
