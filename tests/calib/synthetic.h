#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/camera/camera.h"
#include "furrow/geom/rigid3.h"
#include "furrow/target/detect.h"

namespace furrow::calib {

inline Camera true_camera() {
  Camera camera;
  camera.model = camera::CameraModel::opencv5;
  camera.width = 1280;
  camera.height = 720;
  camera.fx = 874.33;  // the thesis's camera
  camera.fy = 872.39;
  camera.cx = 640.49;
  camera.cy = 360.81;
  camera.distortion = {-0.12, 0.09, 8e-4, -5e-4, -0.02};
  return camera;
}

inline const target::BoardSpec& true_board() {
  static const target::BoardSpec board{"board", 9, 6, 0.038, 1.0};
  return board;
}

/// How the pictures of a synthetic session are taken.
struct Session {
  int views = 12;
  double noise_px = 0.2;
  double largest_tilt_rad = 0.7;
  double nearest_m = 0.45, farthest_m = 1.1;
  std::uint64_t seed = 1;
  double largest_roll_rad = 0.2;  ///< about the viewing direction
};

/// Corners of a board (bent by `warp_m`, as warped_corner() has it) held before a camera, with Gaussian
/// noise. Written apart from the estimator.
inline std::vector<target::BoardDetection> session(const Camera& camera, const target::BoardSpec& board,
                                                   const Session& how,
                                                   const Eigen::Vector2d& warp_m = {0.0, 0.0}) {
  base::Random random(how.seed);
  std::vector<target::BoardDetection> out;
  while (static_cast<int>(out.size()) < how.views) {
    const double distance = random.uniform(how.nearest_m, how.farthest_m);
    Rigid3 pose;
    pose.rotation =
        geom::rotation_from_vector(Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0.0) *
                                   how.largest_tilt_rad) *
        geom::rotation_from_vector(Eigen::Vector3d(0.0, 0.0, random.uniform(-1, 1) * how.largest_roll_rad));
    const Eigen::Vector3d middle(0.5 * (board.corners_x - 1) * board.square_m,
                                 0.5 * (board.corners_y - 1) * board.square_m, 0.0);
    pose.translation =
        distance * Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.28, 0.28), 1.0) -
        pose.rotation * middle;
    target::BoardDetection view;
    view.image = "view_" + std::to_string(100 + out.size()) + ".jpg";
    view.width = camera.width;
    view.height = camera.height;
    view.found = true;
    for (int j = 0; j < board.corners_y; ++j) {
      for (int i = 0; i < board.corners_x; ++i) {
        const double a = 2.0 * i / (board.corners_x - 1) - 1.0, b = 2.0 * j / (board.corners_y - 1) - 1.0;
        const Eigen::Vector3d x(i * board.square_m, j * board.square_m * board.aspect,
                                warp_m.x() * (1 - a * a) + warp_m.y() * (1 - b * b));
        const auto px = camera::project(camera, pose * x);
        const bool inside =
            px && px->x() > 0 && px->y() > 0 && px->x() < camera.width - 1 && px->y() < camera.height - 1;
        view.found = view.found && inside;
        if (!view.found) break;
        view.corners_px.push_back(
            *px + Eigen::Vector2d(random.normal(0, how.noise_px), random.normal(0, how.noise_px)));
        view.sigma_px.push_back(how.noise_px);
      }
    }
    if (view.found) out.push_back(std::move(view));
  }
  return out;
}

}  // namespace furrow::calib
