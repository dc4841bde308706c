#pragma once
#include "furrow/base/result.h"
#include "furrow/camera/camera.h"
#include "furrow/depth/depth_map.h"

namespace furrow::depth {

/// Monodepth2's range of depths, in its own unit, and metres in that unit: KITTI's stereo rig of 54 cm over a
/// nominal 0.1 (thesis, section 6).
inline constexpr double kNearestDepth = 0.1, kFarthestDepth = 100.0, kMetresPerUnit = 5.4;
/// fx over the picture's width of the camera that the networks were trained with.
inline constexpr double kTrainedFocalShare = 0.58;

/// Sigmoid disparity in [0, 1] -> metres: 5.4 / (1/100 + (1/0.1 - 1/100) disparity). Of stereo-trained
/// networks only; what the others say has no scale. NaN outside [0, 1].
double thesis_metres(double disparity);

/// The same for a map.
DepthMap thesis_metres(const DepthMap& disparity);

/// What the thesis calls L: the value at [512, 160] of 1024 x 320, and at the same place of a map of another
/// size (the nearest pixel). Error: no_depth (nothing is known there).
Result<double> thesis_slant_distance_m(const DepthMap& metres);

/// A network tells distance by size, so what it says of another camera's picture is too near or too far by
/// (fx / width) / 0.58: the map times that.
DepthMap for_focal_length(DepthMap metres, const Camera& camera);

/// The value is along the optical axis, and so is the slant distance at the principal point only; elsewhere
/// the range along the ray is longer. Error: no_ray (the lens has no ray there).
Result<double> range_m(double z_depth_m, const Camera& camera, double u_px, double v_px);

}  // namespace furrow::depth
