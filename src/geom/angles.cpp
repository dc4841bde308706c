#include "furrow/geom/angles.h"

#include <cmath>

namespace furrow::geom {

double wrap_angle(double radians) {
  const double wrapped = std::remainder(radians, 2.0 * kPi);
  return wrapped >= kPi ? wrapped - 2.0 * kPi : wrapped;
}

}  // namespace furrow::geom
