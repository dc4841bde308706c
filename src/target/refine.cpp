#include "target/refine.h"

#include <algorithm>
#include <cmath>
#include <Eigen/LU>
#include <vector>

namespace furrow::target {
namespace {

/// A square patch sampled about a sub-pixel centre, one sample wider than the window on each side.
class Patch {
 public:
  Patch(const Image& grey, const Eigen::Vector2d& centre_px, int half) : side_(2 * half + 3) {
    samples_.resize(static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_));
    const double u0 = centre_px.x() - half - 1, v0 = centre_px.y() - half - 1;
    const int iu = static_cast<int>(std::floor(u0)), iv = static_cast<int>(std::floor(v0));
    const double a = u0 - iu, b = v0 - iv;
    for (int y = 0; y < side_; ++y) {
      const std::uint8_t* upper = grey.at(iu, iv + y);
      const std::uint8_t* lower = grey.at(iu, iv + y + 1);
      double* out = &samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_)];
      for (int x = 0; x < side_; ++x) {
        out[x] =
            (1 - b) * ((1 - a) * upper[x] + a * upper[x + 1]) + b * ((1 - a) * lower[x] + a * lower[x + 1]);
      }
    }
  }

  static bool fits(const Image& grey, const Eigen::Vector2d& centre_px, int half) {
    return centre_px.x() - half - 1 >= 0 && centre_px.y() - half - 1 >= 0 &&
           centre_px.x() + half + 2 < grey.width - 1 && centre_px.y() + half + 2 < grey.height - 1;
  }

  /// Central differences at window place (x, y), both from -half to half.
  Eigen::Vector2d gradient(int x, int y) const {
    const int cx = x + side_ / 2, cy = y + side_ / 2;
    return 0.5 * Eigen::Vector2d(at(cx + 1, cy) - at(cx - 1, cy), at(cx, cy + 1) - at(cx, cy - 1));
  }

 private:
  double at(int x, int y) const {
    return samples_[static_cast<std::size_t>(y) * static_cast<std::size_t>(side_) +
                    static_cast<std::size_t>(x)];
  }
  int side_;
  std::vector<double> samples_;
};

/// The normal equations of sum w (g . (p - c))^2 about the window's middle, and the spread that noise in g
/// gives them.
struct Normal {
  Eigen::Matrix2d matrix = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  Eigen::Matrix2d noise = Eigen::Matrix2d::Zero();  ///< for unit noise of a gradient's component
};

Normal normal_equations(const Patch& patch, int half, double half_width_px) {
  Normal out;
  for (int y = -half; y <= half; ++y) {
    for (int x = -half; x <= half; ++x) {
      const double weight = std::exp(-(x * x + y * y) / (half_width_px * half_width_px));
      const Eigen::Vector2d g = patch.gradient(x, y), p(x, y);
      const Eigen::Matrix2d gg = g * g.transpose();
      out.matrix += weight * gg;
      out.right += weight * gg * p;
      out.noise += weight * weight * p.squaredNorm() * gg;
    }
  }
  return out;
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
    if (!px.allFinite() || !Patch::fits(grey, px, half)) return std::nullopt;
    const Normal normal = normal_equations(Patch(grey, px, half), half, half_width_px);
    if (!is_corner(normal.matrix)) return std::nullopt;
    const Eigen::Matrix2d inverse = normal.matrix.inverse();
    const Eigen::Vector2d step = inverse * normal.right;
    px += step;
    if ((px - start_px).norm() > half) return std::nullopt;
    if (step.norm() < kConvergedPx) {
      // A central difference of two pixels' noise has 1 / sqrt(2) of it.
      const Eigen::Matrix2d covariance = 0.5 * noise_grey * noise_grey * inverse * normal.noise * inverse;
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
