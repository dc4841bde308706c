#pragma once
#include <cstddef>
#include <cstdint>
#include <Eigen/Core>
#include <span>
#include <vector>

namespace furrow::sim {

inline constexpr int kSamplesPerPixel = 4;

/// Four visibility samples a pixel (a rotated grid), each with its nearest surface: anti-aliased edges to a
/// quarter of a pixel, without bias. Surfaces are numbered from 1; 0 is what no polygon covers.
class SampleBuffer {
 public:
  using Float4 [[gnu::vector_size(16)]] = float;
  using Int4 [[gnu::vector_size(16)]] = std::int32_t;
  using Long2 [[gnu::vector_size(16)]] = std::int64_t;

  SampleBuffer(int width, int height);
  void clear();
  /// Fills a convex polygon of one surface at one depth. `inverse_depth` is 1 / z_cam, larger is nearer.
  /// Returns whether any sample shows it.
  bool fill(std::span<const Eigen::Vector2f> corners_px, float inverse_depth, std::int32_t surface);
  /// Whether nothing at that depth can show within the square of half side `half_px` about a place.
  bool hides(const Eigen::Vector2f& middle_px, float half_px, float inverse_depth) const;

  int width() const { return width_; }
  int height() const { return height_; }
  const Float4& nearness(std::size_t pixel) const { return nearness_[pixel]; }
  const Int4& surface(std::size_t pixel) const { return surface_[pixel]; }

 private:
  int width_, height_;
  std::vector<Float4> nearness_;
  std::vector<Int4> surface_;
};

}  // namespace furrow::sim
