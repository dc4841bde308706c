#pragma once
#include <array>
#include <Eigen/Core>
#include <vector>

#include "furrow/image/image.h"
#include "target/search_work.h"

namespace furrow::target {

/// A picture as smoothed float grey levels, for searching.
struct SmoothGrey {
  int width = 0, height = 0;
  std::vector<float> data;

  double at(int u, int v) const {
    return data[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)];
  }
  bool inside(const Eigen::Vector2d& px) const {
    return px.x() >= 0.0 && px.y() >= 0.0 && px.x() < width - 1 && px.y() < height - 1;
  }
  /// Bilinear; `px` must be inside().
  double sample(const Eigen::Vector2d& px) const;
};
/// Binomial blur 1-4-6-4-1 both ways (sigma 1 px).
SmoothGrey smooth(const Image& grey);

/// A place where the brightness is a saddle, strongest first.
struct Saddle {
  Eigen::Vector2d px;
  double strength = 0.0;  ///< Ixy^2 - Ixx Iyy
};
/// At most 4000 of them; weaker ones are left out.
std::vector<Saddle> find_saddles(const SmoothGrey& grey, SearchWork& work);

/// A saddle that looks like the corner of four squares: four edges leave it, by turns with the bright side to
/// their left and right.
struct CornerSeed {
  Eigen::Vector2d px;
  std::array<double, 4> ray_rad{};      ///< directions of the edges, rising, atan2(v, u)
  std::array<bool, 4> bright_beyond{};  ///< whether it is brighter just beyond the edge in rising angle
  double contrast = 0.0;                ///< bright minus dark, grey levels
};
std::vector<CornerSeed> find_corner_seeds(const SmoothGrey& grey, const std::vector<Saddle>& saddles);

}  // namespace furrow::target
