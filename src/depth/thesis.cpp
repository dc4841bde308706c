#include "furrow/depth/thesis.h"

#include <cmath>
#include <limits>

namespace furrow::depth {

double thesis_metres(double disparity) {
  if (!(disparity >= 0.0 && disparity <= 1.0)) return std::numeric_limits<double>::quiet_NaN();
  const double scaled = 1.0 / kFarthestDepth + (1.0 / kNearestDepth - 1.0 / kFarthestDepth) * disparity;
  return kMetresPerUnit / scaled;
}

DepthMap thesis_metres(const DepthMap& disparity) {
  DepthMap metres = disparity;
  for (float& value : metres.values) value = static_cast<float>(thesis_metres(static_cast<double>(value)));
  return metres;
}

Result<double> thesis_slant_distance_m(const DepthMap& metres) {
  constexpr int kU = 512, kV = 160, kWidth = 1024, kHeight = 320;
  const int u = kU * metres.width / kWidth, v = kV * metres.height / kHeight;
  const bool inside = u < metres.width && v < metres.height;
  const double value = inside ? static_cast<double>(metres.at(u, v)) : std::nan("");
  if (!std::isfinite(value))
    return Error{"no_depth", "thesis depth", "nothing is known at the map's middle", "a value there", ""};
  return value;
}

DepthMap for_focal_length(DepthMap metres, const Camera& camera) {
  const double factor = camera.fx / camera.width / kTrainedFocalShare;
  for (float& value : metres.values) value = static_cast<float>(factor * static_cast<double>(value));
  return metres;
}

Result<double> range_m(double z_depth_m, const Camera& camera, double u_px, double v_px) {
  const auto ray = camera::unproject(camera, {u_px, v_px});
  if (!ray) return Error{"no_ray", "range", "the lens has no ray at that pixel", "", ""};
  return z_depth_m * std::sqrt(1.0 + ray->squaredNorm());
}

}  // namespace furrow::depth
