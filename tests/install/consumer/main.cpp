// The thesis's worked example: 95 px at f 873.35 px is 5.5 m along the axis.
#include <cmath>
#include <cstdio>

#include "furrow/altitude/thesis.h"
#include "furrow/rows/detect.h"

int main() {
  const auto slant_m = furrow::altitude::thesis_slant_distance_m(0.60, 873.35, 95.0);
  const auto lines = furrow::rows::detect(furrow::image::make_image(64, 48, 3));
  std::printf("%.2f m, rows in a black picture: %s\n", slant_m.value(), lines.status.c_str());
  return std::abs(slant_m.value() - 5.5) < 0.05 && !lines.ok() ? 0 : 1;
}
