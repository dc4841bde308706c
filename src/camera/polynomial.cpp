#include "camera/polynomial.h"

namespace furrow::camera {
namespace {

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

}  // namespace

double evaluate(const Polynomial& c, double s) {
  double sum = 0.0;
  for (auto it = c.rbegin(); it != c.rend(); ++it) sum = sum * s + *it;
  return sum;
}

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

}  // namespace furrow::camera
