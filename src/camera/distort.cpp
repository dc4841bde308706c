#include "camera/distort.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "camera/polynomial.h"

namespace furrow::camera {
namespace {

/// Coefficients in OpenCV's order.
enum Index { k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 };

/// The radial quotient N / D and its derivative by s = r^2.
struct Radial {
  double numerator, denominator, value, slope;
};

Radial radial_terms(const Coefficients& k, double s) {
  Radial out;
  out.numerator = 1.0 + s * (k[k1] + s * (k[k2] + s * k[k3]));
  out.denominator = 1.0 + s * (k[k4] + s * (k[k5] + s * k[k6]));
  const double numerator_slope = k[k1] + s * (2.0 * k[k2] + 3.0 * s * k[k3]);
  const double denominator_slope = k[k4] + s * (2.0 * k[k5] + 3.0 * s * k[k6]);
  out.value = out.numerator / out.denominator;
  out.slope = (numerator_slope - out.value * denominator_slope) / out.denominator;
  return out;
}

Eigen::Vector2d distort(const Coefficients& k, const Eigen::Vector2d& xy, double a) {
  const double x = xy.x(), y = xy.y(), s = xy.squaredNorm();
  return {x * a + 2.0 * k[p1] * x * y + k[p2] * (s + 2.0 * x * x) + s * (k[s1] + s * k[s2]),
          y * a + k[p1] * (s + 2.0 * y * y) + 2.0 * k[p2] * x * y + s * (k[s3] + s * k[s4])};
}

Eigen::Matrix2d distort_jacobian(const Coefficients& k, const Eigen::Vector2d& xy, const Radial& a) {
  const double x = xy.x(), y = xy.y(), s = xy.squaredNorm();
  const double prism_x = k[s1] + 2.0 * s * k[s2], prism_y = k[s3] + 2.0 * s * k[s4];
  const double cross = 2.0 * x * y * a.slope + 2.0 * k[p1] * x + 2.0 * k[p2] * y;
  Eigen::Matrix2d out;
  out(0, 0) = a.value + 2.0 * x * x * a.slope + 2.0 * k[p1] * y + 6.0 * k[p2] * x + 2.0 * x * prism_x;
  out(0, 1) = cross + 2.0 * y * prism_x;
  out(1, 0) = cross + 2.0 * x * prism_y;
  out(1, 1) = a.value + 2.0 * y * y * a.slope + 6.0 * k[p1] * y + 2.0 * k[p2] * x + 2.0 * y * prism_y;
  return out;
}

}  // namespace

Coefficients coefficients(const Camera& camera) {
  Coefficients out = Coefficients::Zero();
  for (std::size_t i = 0; i < camera.distortion.size() && i < kMaxDistortion; ++i) {
    out[static_cast<Eigen::Index>(i)] = camera.distortion[i];
  }
  return out;
}

Eigen::Vector2d distort(const Coefficients& k, const Eigen::Vector2d& xy) {
  return distort(k, xy, radial_terms(k, xy.squaredNorm()).value);
}

Eigen::Matrix2d distort_jacobian(const Coefficients& k, const Eigen::Vector2d& xy) {
  return distort_jacobian(k, xy, radial_terms(k, xy.squaredNorm()));
}

Distorted distort_with_jacobians(const Coefficients& k, const Eigen::Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), s = xy.squaredNorm();
  const Radial a = radial_terms(k, s);
  Distorted out;
  out.xy = distort(k, xy, a.value);
  out.d_xy = distort_jacobian(k, xy, a);
  const double by_numerator = 1.0 / a.denominator, by_denominator = -a.value / a.denominator;
  const std::array<double, 3> powers{s, s * s, s * s * s};
  out.d_coefficients.setZero();
  const std::array<Index, 3> upper{k1, k2, k3}, lower{k4, k5, k6};
  for (std::size_t i = 0; i < 3; ++i) {
    out.d_coefficients.col(upper[i]) = by_numerator * powers[i] * xy;
    out.d_coefficients.col(lower[i]) = by_denominator * powers[i] * xy;
  }
  out.d_coefficients.col(p1) << 2.0 * x * y, s + 2.0 * y * y;
  out.d_coefficients.col(p2) << s + 2.0 * x * x, 2.0 * x * y;
  out.d_coefficients.col(s1) << s, 0.0;
  out.d_coefficients.col(s2) << s * s, 0.0;
  out.d_coefficients.col(s3) << 0.0, s;
  out.d_coefficients.col(s4) << 0.0, s * s;
  return out;
}

double radial(const Coefficients& k, double r) {
  return r * radial_terms(k, r * r).value;
}

namespace {

/// Terms of s whose sign is that of d/dr (r N/D): (N + 2 s N') D - 2 s N D'.
std::array<double, 7> growth_terms(const Coefficients& k) {
  const std::array<double, 4> n{1.0, k[k1], k[k2], k[k3]}, d{1.0, k[k4], k[k5], k[k6]};
  std::array<double, 7> out{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) {
      const double order = 1.0 + 2.0 * static_cast<double>(i) - 2.0 * static_cast<double>(j);
      out[i + j] += order * n[i] * d[j];
    }
  }
  return out;
}

/// Whether c[0] + c[1] s + ... stays above 0 on [0, limit] even with every negative term at its largest.
template <std::size_t kCount>
bool surely_positive(const std::array<double, kCount>& c, double limit) {
  double bound = c[0], power = 1.0;
  for (std::size_t i = 1; i < kCount; ++i) {
    power *= limit;
    bound += std::min(0.0, c[i]) * power;
  }
  return bound > 0.0;
}

}  // namespace

bool surely_grows_to(const Coefficients& k, double r) {
  return surely_positive(growth_terms(k), r * r) &&
         surely_positive(std::array<double, 4>{1.0, k[k4], k[k5], k[k6]}, r * r);
}

double radial_fold(const Coefficients& k) {
  const std::array<double, 7> growth = growth_terms(k);
  // Half a milliradian short of 90 degrees off the axis; no unit-plane model is used farther out.
  constexpr double kFarthestRadius = 2000.0;
  const double limit = kFarthestRadius * kFarthestRadius;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Polynomial& c :
       {Polynomial(growth.begin(), growth.end()), Polynomial{1.0, k[k4], k[k5], k[k6]}}) {
    const std::vector<double> roots = roots_within(c, limit);
    if (!roots.empty()) nearest = std::min(nearest, std::sqrt(roots.front()));
  }
  return nearest;
}

}  // namespace furrow::camera
