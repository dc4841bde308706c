#pragma once
#include "furrow/base/result.h"
#include "furrow/camera/camera.h"
#include "furrow/depth/depth_map.h"
#include "furrow/stats/estimate.h"

namespace furrow::depth {

/// What stands beside a map when its plane is looked for.
struct SurfaceInput {
  DepthMap z_depth_m;  ///< along the optical axis
  Camera camera;       ///< of the map's field of view, in any resolution of it
  Estimate pitch_rad;  ///< gimbal, negative below the horizon
  Estimate roll_rad;   ///< unusable: level
  Estimate row_height_m;
};

struct SurfaceOptions {
  /// One-sigma of the map's common scale, as a share. Default: what is left of a network's scale once the
  /// focal length is corrected for is not known better than a tenth.
  double scale_sigma = 0.1;
  /// Rays flatter than this below the horizon say little of the height and much of the pitch, radians.
  double flattest_rad = 0.05;
  /// Width and height of what one independent value covers, as a share of the picture's width: networks
  /// smooth.
  double patch_share = 0.05;
};

/// Camera's height from a depth map.
struct DepthHeight {
  Estimate above_canopy_m;   ///< sigma: scale, angles, scatter, and leaves or soil where that is open
  double by_scale_m = 0.0;   ///< part of its sigma that all maps of one network err by together
  double by_angles_m = 0.0;  ///< part that the gimbal's pitch and roll make
  /// Downward tilt that the map itself shows against the picture's axis, to be held against the gimbal's:
  /// pitch of the plane that fits all of it best.
  double plane_pitch_rad = 0.0;
  double plane_height_m = 0.0;  ///< of the camera above that plane, along its normal
  double scatter_m = 0.0;       ///< robust, of single heights about the surfaces
  double soil_share = 0.0;      ///< part of the pixels that lie on the soil
};

/// Every pixel of z-depth z sees a point z sin(depression) / cos(angle from the axis) below the camera: with
/// the gimbal's angles these heights stand on two levels, canopy and soil, a row height apart. The level that
/// most of them agree on is the height (docs/formulation/depth.md). Errors: no_pitch, map_too_small,
/// no_surface (too few pixels below the horizon), camera_aspect_differs.
Result<DepthHeight> height_from_map(const SurfaceInput& input, const SurfaceOptions& options = {});

}  // namespace furrow::depth
