#include "camera/distort.h"

#include <array>
#include <cmath>
#include <limits>
#include <vector>

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

/// c[0] + c[1] s + ...
using Polynomial = std::vector<double>;

double evaluate(const Polynomial& c, double s) {
  double sum = 0.0;
  for (auto it = c.rbegin(); it != c.rend(); ++it) sum = sum * s + *it;
  return sum;
}

Polynomial multiply(const Polynomial& a, const Polynomial& b) {
  Polynomial out(a.size() + b.size() - 1, 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) out[i + j] += a[i] * b[j];
  }
  return out;
}

double bisect(const Polynomial& c, double low, double high) {
  const bool low_positive = evaluate(c, low) > 0.0;
  // 200 halvings pass the spacing of doubles from any start.
  for (int i = 0; i < 200 && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    ((evaluate(c, middle) > 0.0) == low_positive ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Real roots in (0, limit) in rising order, found between those of the derivative, where the polynomial is
/// monotone.
std::vector<double> roots_within(const Polynomial& c, double limit) {
  if (c.size() < 2) return {};
  Polynomial derivative(c.size() - 1);
  for (std::size_t i = 1; i < c.size(); ++i) derivative[i - 1] = static_cast<double>(i) * c[i];
  std::vector<double> knots = roots_within(derivative, limit);
  knots.insert(knots.begin(), 0.0);
  knots.push_back(limit);
  std::vector<double> roots;
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    if ((evaluate(c, knots[i]) > 0.0) != (evaluate(c, knots[i + 1]) > 0.0)) {
      roots.push_back(bisect(c, knots[i], knots[i + 1]));
    }
  }
  return roots;
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
  const double x = xy.x(), y = xy.y(), s = xy.squaredNorm();
  const double a = radial_terms(k, s).value;
  return {x * a + 2.0 * k[p1] * x * y + k[p2] * (s + 2.0 * x * x) + s * (k[s1] + s * k[s2]),
          y * a + k[p1] * (s + 2.0 * y * y) + 2.0 * k[p2] * x * y + s * (k[s3] + s * k[s4])};
}

Distorted distort_with_jacobians(const Coefficients& k, const Eigen::Vector2d& xy) {
  const double x = xy.x(), y = xy.y(), s = xy.squaredNorm();
  const Radial a = radial_terms(k, s);
  Distorted out;
  out.xy = distort(k, xy);
  const double prism_x = k[s1] + 2.0 * s * k[s2], prism_y = k[s3] + 2.0 * s * k[s4];
  const double cross = 2.0 * x * y * a.slope + 2.0 * k[p1] * x + 2.0 * k[p2] * y;
  out.d_xy(0, 0) = a.value + 2.0 * x * x * a.slope + 2.0 * k[p1] * y + 6.0 * k[p2] * x + 2.0 * x * prism_x;
  out.d_xy(0, 1) = cross + 2.0 * y * prism_x;
  out.d_xy(1, 0) = cross + 2.0 * x * prism_y;
  out.d_xy(1, 1) = a.value + 2.0 * y * y * a.slope + 6.0 * k[p1] * y + 2.0 * k[p2] * x + 2.0 * y * prism_y;
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

double radial_fold(const Coefficients& k) {
  // d/dr (r N/D) has the sign of (N + 2 s N') D - 2 s N D'.
  const Polynomial n{1.0, k[k1], k[k2], k[k3]}, d{1.0, k[k4], k[k5], k[k6]};
  const Polynomial n_and_slope{1.0, 3.0 * k[k1], 5.0 * k[k2], 7.0 * k[k3]};
  const Polynomial two_s_d_slope{0.0, 2.0 * k[k4], 4.0 * k[k5], 6.0 * k[k6]};
  Polynomial growth = multiply(n_and_slope, d);
  const Polynomial drag = multiply(n, two_s_d_slope);
  for (std::size_t i = 0; i < growth.size(); ++i) growth[i] -= drag[i];
  // Half a milliradian short of 90 degrees off the axis; no unit-plane model is used farther out.
  constexpr double kFarthestRadius = 2000.0;
  const double limit = kFarthestRadius * kFarthestRadius;
  double nearest = std::numeric_limits<double>::infinity();
  for (const Polynomial& c : {growth, d}) {
    const std::vector<double> roots = roots_within(c, limit);
    if (!roots.empty()) nearest = std::min(nearest, std::sqrt(roots.front()));
  }
  return nearest;
}

}  // namespace furrow::camera
