#pragma once
#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "furrow/base/random.h"
#include "furrow/camera/camera.h"
#include "furrow/geom/rigid3.h"
#include "furrow/image/image.h"
#include "furrow/target/artwork.h"
#include "furrow/target/board.h"

namespace furrow::target {

/// Binomial blur of 1-2-1 both ways: about what a lens and a Bayer pattern leave (sigma 0.7 px).
inline Image softened(const Image& picture) {
  Image out = picture;
  for (int v = 1; v + 1 < picture.height; ++v) {
    for (int u = 1; u + 1 < picture.width; ++u) {
      int sum = 8;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du)
          sum += (2 - std::abs(du)) * (2 - std::abs(dv)) * *picture.at(u + du, v + dv);
      }
      *out.at(u, v) = static_cast<std::uint8_t>(sum / 16);
    }
  }
  return out;
}

/// A board in front of a camera, each pixel the mean of n x n samples, softened; independent of the
/// estimators but for unproject(). The first square (before the first corner) is black; a white margin of one
/// square surrounds the squares; the rest is grey.
inline Image render_board(const Camera& camera, const BoardSpec& board, const Rigid3& cam_from_board,
                          int samples = 5) {
  constexpr double kBlack = 30, kWhite = 220, kAround = 120;
  Image out = image::make_image(camera.width, camera.height, 1);
  const Rigid3 board_from_cam = geom::inverse(cam_from_board);
  const Artwork artwork = make_artwork(board);
  const PrintedExtent printed = printed_extent(board);
  const auto brightness = [&](const Eigen::Vector2d& xy) {
    const Eigen::Vector3d way = board_from_cam.rotation * Eigen::Vector3d(xy.x(), xy.y(), 1.0);
    const double t = -board_from_cam.translation.z() / way.z();
    if (!(t > 0.0)) return kAround;
    const Eigen::Vector3d x = board_from_cam.translation + t * way;
    const Eigen::Vector2d paper(board.square_m, board.square_m * board.aspect), at = x.head<2>();
    if ((at.array() < (printed.low_m - paper).array()).any() ||
        (at.array() > (printed.high_m + paper).array()).any())
      return kAround;
    return is_black(artwork, at) ? kBlack : kWhite;
  };
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      const auto centre = camera::unproject(camera, {u, v});
      const auto slope = centre ? camera::unproject_jacobian(camera, *centre) : std::nullopt;
      double sum = 0.0;
      for (int a = 0; a < samples; ++a) {
        for (int b = 0; b < samples; ++b) {
          // Sheared, so that no two samples share a row or column and an upright edge moves in steps of 1 /
          // n^2.
          const Eigen::Vector2d step((a + (b + 0.5) / samples) / samples - 0.5,
                                     (b + (a + 0.5) / samples) / samples - 0.5);
          sum += slope ? brightness(*centre + *slope * step) : kAround;
        }
      }
      *out.at(u, v) = static_cast<std::uint8_t>(std::lround(sum / (samples * samples)));
    }
  }
  return softened(out);
}

inline Image with_noise(Image picture, double sigma_grey, std::uint64_t seed) {
  base::Random random(seed);
  for (auto& value : picture.data) {
    value =
        static_cast<std::uint8_t>(std::clamp(std::lround(value + random.normal(0.0, sigma_grey)), 0L, 255L));
  }
  return picture;
}

inline Camera plain_camera(int width, int height, double focal_px) {
  Camera camera;
  camera.model = camera::CameraModel::opencv5;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_px;
  camera.cx = 0.5 * (width - 1) + 3.0;
  camera.cy = 0.5 * (height - 1) - 2.0;
  camera.distortion = {-0.2, 0.05, 1e-4, -1e-4, 0.0};
  return camera;
}

/// A pose that looks at the board's middle from `distance_m`, turned by the rotation vector.
inline Rigid3 facing(const BoardSpec& board, double distance_m, const Eigen::Vector3d& turn_rad,
                     const Eigen::Vector2d& shift_m = {0.0, 0.0}) {
  Rigid3 pose;
  pose.rotation = geom::rotation_from_vector(turn_rad);
  const Eigen::Vector3d middle = 0.5 * corner_in_board(board, board.corners_x - 1, board.corners_y - 1);
  pose.translation = Eigen::Vector3d(shift_m.x(), shift_m.y(), distance_m) - pose.rotation * middle;
  return pose;
}

}  // namespace furrow::target
