#pragma once
#include <cmath>

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
    case CameraModel::fisheye:
      camera.fx = 380.25;
      camera.fy = 381.5;
      camera.distortion = {-0.0143, 0.0021, -0.0012, 1.1e-4};
      break;
    case CameraModel::stereographic:
    case CameraModel::latlon:
      break;
    case CameraModel::splined_stereographic:
      camera.spline = {3, 14, 11, 120};
      for (int i = 0; i < 2 * 14 * 11; ++i)
        camera.distortion.push_back(0.02 * std::sin(0.7 * i) + 0.01 * std::cos(0.11 * i * i));
      break;
  }
  return camera;
}

/// The same with quadratic patches.
inline Camera quadratic_camera() {
  Camera camera = test_camera(CameraModel::splined_stereographic);
  camera.spline.order = 2;
  return camera;
}

/// Those on the unit plane, with coefficients in OpenCV's order.
inline constexpr CameraModel kPlaneModels[] = {CameraModel::pinhole, CameraModel::opencv4,
                                               CameraModel::opencv5, CameraModel::opencv8,
                                               CameraModel::opencv12};
/// Those that see directions.
inline constexpr CameraModel kWideModels[] = {CameraModel::fisheye, CameraModel::stereographic,
                                              CameraModel::latlon, CameraModel::splined_stereographic};
inline constexpr CameraModel kAllModels[] = {
    CameraModel::pinhole,       CameraModel::opencv4,  CameraModel::opencv5,
    CameraModel::opencv8,       CameraModel::opencv12, CameraModel::fisheye,
    CameraModel::stereographic, CameraModel::latlon,   CameraModel::splined_stereographic};

}  // namespace furrow::camera
