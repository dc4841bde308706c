#pragma once
#include <vector>

namespace furrow::camera {

/// c[0] + c[1] s + ...
using Polynomial = std::vector<double>;

double evaluate(const Polynomial& c, double s);

/// Real roots in (0, limit) in rising order, found between those of the derivative, where the polynomial is
/// monotone.
std::vector<double> roots_within(const Polynomial& c, double limit);

}  // namespace furrow::camera
