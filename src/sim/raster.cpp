#include "sim/raster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace furrow::sim {
namespace {

// Offsets of the samples from the pixel's centre: each row and each column of a 4 x 4 grid holds one, so that
// edges of any direction near horizontal or vertical get four levels.
constexpr SampleBuffer::Float4 kSampleU = {-0.125F, 0.375F, -0.375F, 0.125F};
constexpr SampleBuffer::Float4 kSampleV = {-0.375F, -0.125F, 0.125F, 0.375F};
constexpr std::size_t kMostCorners = 12;

struct Edge {
  float du, dv, c;  // du u + dv v + c >= 0 inside
};

float twice_area(std::span<const Eigen::Vector2f> p) {
  float sum = 0.0F;
  for (std::size_t i = 1; i + 1 < p.size(); ++i) {
    const Eigen::Vector2f a = p[i] - p[0], b = p[i + 1] - p[0];
    sum += a.x() * b.y() - a.y() * b.x();
  }
  return sum;
}

bool none(SampleBuffer::Int4 mask) {
  const auto halves = reinterpret_cast<SampleBuffer::Long2>(mask);
  return (halves[0] | halves[1]) == 0;
}

/// First and last pixel that [low, high] touches, within [0, count).
std::pair<int, int> pixels_between(float low, float high, int count) {
  const float last = static_cast<float>(count - 1);
  return {static_cast<int>(std::clamp(std::floor(low + 0.5F), 0.0F, last)),
          static_cast<int>(std::clamp(std::floor(high + 0.5F), 0.0F, last))};
}

}  // namespace

bool SampleBuffer::hides(const Eigen::Vector2f& middle, float half_px, float inverse_depth) const {
  const auto [u0, u1] = pixels_between(middle.x() - half_px, middle.x() + half_px, width_);
  const auto [v0, v1] = pixels_between(middle.y() - half_px, middle.y() + half_px, height_);
  const Float4 depth = {inverse_depth, inverse_depth, inverse_depth, inverse_depth};
  for (int v = v0; v <= v1; ++v) {
    const std::size_t line = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_);
    for (int u = u0; u <= u1; ++u) {
      if (!none(depth > nearness_[line + static_cast<std::size_t>(u)])) return false;
    }
  }
  return true;
}

SampleBuffer::SampleBuffer(int width, int height) : width_(width), height_(height) {
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  nearness_.resize(count);
  surface_.resize(count);
  clear();
}

void SampleBuffer::clear() {
  std::fill(nearness_.begin(), nearness_.end(), Float4{});
  std::fill(surface_.begin(), surface_.end(), Int4{});
}

bool SampleBuffer::fill(std::span<const Eigen::Vector2f> corners, float inverse_depth, std::int32_t surface) {
  if (corners.size() < 3 || corners.size() > kMostCorners) return false;
  Eigen::Vector2f low = corners[0], high = corners[0];
  for (const Eigen::Vector2f& corner : corners) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  // Written so that NaN falls out.
  if (!(high.x() > -0.5F && high.y() > -0.5F && low.x() < static_cast<float>(width_) - 0.5F &&
        low.y() < static_cast<float>(height_) - 0.5F)) {
    return false;
  }
  const auto [u0, u1] = pixels_between(low.x(), high.x(), width_);
  const auto [v0, v1] = pixels_between(low.y(), high.y(), height_);

  const float side = twice_area(corners) < 0.0F ? -1.0F : 1.0F;
  std::array<Edge, kMostCorners> edges;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2f a = corners[i], b = corners[(i + 1) % corners.size()];
    edges[i] = {side * (a.y() - b.y()), side * (b.x() - a.x()), 0.0F};
    edges[i].c = -edges[i].du * a.x() - edges[i].dv * a.y();
  }
  const Float4 depth = {inverse_depth, inverse_depth, inverse_depth, inverse_depth};
  const Int4 mark = {surface, surface, surface, surface};
  bool shown = false;
  for (int v = v0; v <= v1; ++v) {
    const Float4 sample_v = kSampleV + static_cast<float>(v);
    std::array<Float4, kMostCorners> row;
    for (std::size_t i = 0; i < corners.size(); ++i) row[i] = edges[i].dv * sample_v + edges[i].c;
    std::size_t pixel =
        static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(u0);
    for (int u = u0; u <= u1; ++u, ++pixel) {
      const Float4 sample_u = kSampleU + static_cast<float>(u);
      Int4 inside = depth > nearness_[pixel];
      if (none(inside)) continue;
      for (std::size_t i = 0; i < corners.size(); ++i) inside &= (edges[i].du * sample_u + row[i]) >= 0.0F;
      if (none(inside)) continue;
      shown = true;
      nearness_[pixel] = inside ? depth : nearness_[pixel];
      surface_[pixel] = inside ? mark : surface_[pixel];
    }
  }
  return shown;
}

}  // namespace furrow::sim
