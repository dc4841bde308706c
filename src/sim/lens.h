#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/image/image.h"
#include "furrow/sim/scene.h"

namespace furrow::sim {

/// Directions of all pixels of a camera: (x, y) on the plane z = 1.
class RayTable {
 public:
  explicit RayTable(const Camera& camera);
  /// Straight between pixel centres; (u, v) may lie up to a pixel outside the picture.
  Eigen::Vector2d at(double u, double v) const;
  const Eigen::Vector2d& pixel(int u, int v) const {
    return rays_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(u)];
  }
  /// The smallest box on the plane z = 1 that holds all rays.
  const Eigen::Vector2d& low() const { return low_; }
  const Eigen::Vector2d& high() const { return high_; }

 private:
  int width_, height_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero(), high_ = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> rays_;
};

/// A picture in linear light, R G B.
struct LightImage {
  int width = 0, height = 0;
  std::vector<Eigen::Vector3f> data;
  LightImage(int w, int h)
      : width(w),
        height(h),
        data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), Eigen::Vector3f::Zero()) {}
  Eigen::Vector3f& at(int u, int v) {
    return data[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
  }
};

/// Lens blur, exposure, shot noise and the sRGB curve. `key` seeds the noise.
Image develop(LightImage light, const Pictures& pictures, std::uint64_t key);

}  // namespace furrow::sim
