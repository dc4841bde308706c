#pragma once
#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Cameras with a lens like real ones: a GoPro's five coefficients, and mrcal's published 24-megapixel
/// rational solve.
inline Camera test_camera(CameraModel model) {
  Camera camera;
  camera.model = model;
  camera.width = 1280;
  camera.height = 960;
  camera.fx = 561.25;
  camera.fy = 563.5;
  camera.cx = 651.5;
  camera.cy = 499.75;
  switch (model) {
    case CameraModel::pinhole:
      break;
    case CameraModel::opencv4:
      camera.distortion = {-0.2325, 0.0616, 1.5e-4, -3.3e-5};
      break;
    case CameraModel::opencv5:
      camera.distortion = {-0.2325, 0.0616, 1.5e-4, -3.3e-5, -0.0076};
      break;
    case CameraModel::opencv8:
      camera.distortion = {0.47916, 0.02668, 4.4e-4, -1.2e-4, 8.96e-5, 0.76669, 0.09634, 0.00141};
      break;
    case CameraModel::opencv12:
      camera.distortion = {0.47916, 0.02668, 4.4e-4, -1.2e-4, 8.96e-5, 0.76669,
                           0.09634, 0.00141, 1e-3,   -2e-4,   -5e-4,   1e-4};
      break;
  }
  return camera;
}

inline constexpr CameraModel kAllModels[] = {CameraModel::pinhole, CameraModel::opencv4, CameraModel::opencv5,
                                             CameraModel::opencv8, CameraModel::opencv12};

}  // namespace furrow::camera
