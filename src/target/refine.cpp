#include "target/refine.h"

#include <algorithm>
#include <cmath>
#include <Eigen/LU>
#include <vector>

namespace furrow::target {
namespace {

/// Sobel's derivative along x, per grey level and px; along y its transpose. Smoothing across the derivative
/// keeps narrow edges from looking different by where they fall between pixels.
constexpr double kDerivative[3][3] = {{-0.125, 0.0, 0.125}, {-0.25, 0.0, 0.25}, {-0.125, 0.0, 0.125}};

/// Gradients at whole pixels of a square window. Nothing is interpolated: that would smooth by the window's
/// own phase.
class Window {
 public:
  Window(const Image& grey, const Eigen::Vector2d& centre_px, int half)
      : u0_(static_cast<int>(std::lround(centre_px.x())) - half),
        v0_(static_cast<int>(std::lround(centre_px.y())) - half),
        side_(2 * half + 1) {
    gradient_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    for (int y = 0; y < side_; ++y) {
      const std::uint8_t* above = grey.at(u0_, v0_ + y - 1);
      const std::uint8_t* level = grey.at(u0_, v0_ + y);
      const std::uint8_t* below = grey.at(u0_, v0_ + y + 1);
      for (int x = 0; x < side_; ++x) {
        const int right = above[x + 1] + 2 * level[x + 1] + below[x + 1],
                  left = above[x - 1] + 2 * level[x - 1] + below[x - 1];
        const int down = below[x - 1] + 2 * below[x] + below[x + 1],
                  up = above[x - 1] + 2 * above[x] + above[x + 1];
        at(x, y) = 0.125 * Eigen::Vector2d(right - left, down - up);
      }
    }
  }

  static bool fits(const Image& grey, const Eigen::Vector2d& centre_px, int half) {
    const double reach = half + 2.0;
    return centre_px.x() >= reach && centre_px.y() >= reach && centre_px.x() + reach < grey.width &&
           centre_px.y() + reach < grey.height;
  }

  int side() const { return side_; }
  Eigen::Vector2d place(int x, int y) const { return {u0_ + x, v0_ + y}; }
  const Eigen::Vector2d& gradient(int x, int y) const {
    return gradient_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
                     static_cast<std::size_t>(x)];
  }

 private:
  Eigen::Vector2d& at(int x, int y) {
    return gradient_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
                     static_cast<std::size_t>(x)];
  }
  int u0_, v0_, side_;
  std::vector<Eigen::Vector2d> gradient_;
};

double weight_at(const Eigen::Vector2d& from_corner, double half_width_px) {
  return std::exp(-from_corner.squaredNorm() / (half_width_px * half_width_px));
}

/// The normal equations of sum w (g . (p - c))^2, with the pixels counted from `centre_px`.
struct Normal {
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
};

Normal normal_equations(const Window& window, const Eigen::Vector2d& centre_px, double half_width_px) {
  Normal out;
  for (int y = 0; y < window.side(); ++y) {
    for (int x = 0; x < window.side(); ++x) {
      const Eigen::Vector2d p = window.place(x, y) - centre_px, g = window.gradient(x, y);
      const Eigen::Matrix2d gg = weight_at(p, half_width_px) * g * g.transpose();
      out.matrix += gg;
      out.right += gg * p;
    }
  }
  return out;
}

/// Covariance of the corner for unit noise of each pixel. The corner c solves F = sum w g (g . (p - c)) = 0,
/// so it moves by the inverse of dF/dc (the weights follow c) times dF/dpixel; both derivatives of g count,
/// and neighbouring gradients share pixels.
Eigen::Matrix2d unit_covariance(const Window& window, const Eigen::Vector2d& centre_px,
                                double half_width_px) {
  const int side = window.side() + 2;
  std::vector<Eigen::Vector2d> by_pixel(static_cast<std::size_t>(side) * static_cast<std::size_t>(side),
                                        Eigen::Vector2d::Zero());
  Eigen::Matrix2d by_corner = Eigen::Matrix2d::Zero();
  for (int y = 0; y < window.side(); ++y) {
    for (int x = 0; x < window.side(); ++x) {
      const Eigen::Vector2d p = window.place(x, y) - centre_px, g = window.gradient(x, y);
      const double w = weight_at(p, half_width_px), off = g.dot(p);
      by_corner += w * g * (2.0 * off / (half_width_px * half_width_px) * p - g).transpose();
      for (int dy = 0; dy < 3; ++dy) {
        for (int dx = 0; dx < 3; ++dx) {
          const Eigen::Vector2d d(kDerivative[dy][dx], kDerivative[dx][dy]);
          by_pixel[static_cast<std::size_t>((y + dy) * side + x + dx)] += w * (d.dot(p) * g + off * d);
        }
      }
    }
  }
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& d : by_pixel) sum += d * d.transpose();
  const Eigen::Matrix2d inverse = by_corner.inverse();
  return inverse * sum * inverse.transpose();
}

/// A corner has gradients both ways: the weaker way must carry this share of the stronger.
constexpr double kWeakestShare = 0.02;

bool is_corner(const Eigen::Matrix2d& m) {
  const double half_trace = 0.5 * m.trace();
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - m.determinant()));
  return half_trace > 0.0 && half_trace - root > kWeakestShare * (half_trace + root);
}

}  // namespace

std::optional<RefinedCorner> refine_corner(const Image& grey, const Eigen::Vector2d& start_px,
                                           double half_width_px, double noise_grey) {
  const int half = std::max(2, static_cast<int>(std::lround(half_width_px)));
  Eigen::Vector2d px = start_px;
  constexpr int kMaxRounds = 40;
  constexpr double kConvergedPx = 1e-3;
  for (int round = 0; round < kMaxRounds; ++round) {
    if (!px.allFinite() || !Window::fits(grey, px, half)) return std::nullopt;
    const Window window(grey, px, half);
    const Normal normal = normal_equations(window, px, half_width_px);
    if (!is_corner(normal.matrix)) return std::nullopt;
    const Eigen::Matrix2d inverse = normal.matrix.inverse();
    const Eigen::Vector2d step = inverse * normal.right;
    const Eigen::Vector2d before = px;
    px += step;
    if ((px - start_px).norm() > half) return std::nullopt;
    if (step.norm() < kConvergedPx) {
      const Eigen::Matrix2d covariance =
          noise_grey * noise_grey * unit_covariance(window, before, half_width_px);
      return RefinedCorner{px, std::sqrt(0.5 * covariance.trace())};
    }
  }
  return std::nullopt;
}

double noise_grey(const Image& grey) {
  constexpr double kRounding = 0.28867513459481287;  // 1 / sqrt(12): rounding to whole levels
  if (grey.width < 3 || grey.height < 3) return kRounding;
  // Every third pixel each way is plenty for a median.
  constexpr int kStride = 3;
  std::vector<int> magnitude;
  for (int v = 1; v + 1 < grey.height; v += kStride) {
    for (int u = 1; u + 1 < grey.width; u += kStride) {
      const auto at = [&](int du, int dv) { return static_cast<int>(*grey.at(u + du, v + dv)); };
      const int corners = at(-1, -1) + at(1, -1) + at(-1, 1) + at(1, 1);
      const int sides = at(0, -1) + at(-1, 0) + at(1, 0) + at(0, 1);
      magnitude.push_back(std::abs(corners - 2 * sides + 4 * at(0, 0)));
    }
  }
  const auto middle = magnitude.begin() + static_cast<std::ptrdiff_t>(magnitude.size() / 2);
  std::nth_element(magnitude.begin(), middle, magnitude.end());
  // The mask's weights have a root sum of squares of 6; the median magnitude of a Gaussian is 0.6745 sigma.
  return std::max(kRounding, *middle / (6.0 * 0.6745));
}

}  // namespace furrow::target
