#include "sim/board.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/world.h"
#include "sim/noise.h"

namespace furrow::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kBlack = 0.035, kWhite = 0.40, kWall = 0.11;  // linear, under the session's light
constexpr double kPaperMargin = 0.9;  // white paper beyond the outer squares, in squares
constexpr int kFine = 8;              // samples along each side of a pixel that holds an edge
constexpr double kPictureMargin_px = 6.0;

/// Light of the sheet's plane at a point of the board.
double sheet(const Boards& b, const Vector2d& x_in_board) {
  const double x = x_in_board.x() / b.square_m, y = x_in_board.y() / b.square_m;
  const double paper = 1.0 + kPaperMargin;
  if (x < -paper || y < -paper || x > b.corners_x - 1 + paper || y > b.corners_y - 1 + paper) return kWall;
  if (x < -1.0 || y < -1.0 || x > b.corners_x || y > b.corners_y) return kWhite;
  const auto parity = (static_cast<int>(std::floor(x)) + static_cast<int>(std::floor(y))) & 1;
  return parity == 0 ? kBlack : kWhite;
}

/// Where rays meet the board's plane: x_in_board is the dehomogenised product.
Eigen::Matrix3d board_from_ray(const Rigid3& cam_from_board) {
  Eigen::Matrix3d plane;
  const Eigen::Matrix3d rotation = cam_from_board.rotation.toRotationMatrix();
  plane << rotation.col(0), rotation.col(1), cam_from_board.translation;
  return plane.inverse();
}

/// Whether all squares are in the picture; the paper around them need not be.
bool fits(const Scene& scene, const Rigid3& cam_from_board) {
  const Boards& b = scene.boards;
  for (double x : {-1.0, static_cast<double>(b.corners_x)}) {
    for (double y : {-1.0, static_cast<double>(b.corners_y)}) {
      const auto px =
          camera::project(scene.camera, cam_from_board * Vector3d(x * b.square_m, y * b.square_m, 0.0));
      if (!px || px->x() < kPictureMargin_px || px->y() < kPictureMargin_px ||
          px->x() > scene.camera.width - 1 - kPictureMargin_px ||
          px->y() > scene.camera.height - 1 - kPictureMargin_px) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

std::vector<Rigid3> true_boards(const Scene& scene) {
  const Boards& b = scene.boards;
  const Vector3d middle(0.5 * (b.corners_x - 1) * b.square_m, 0.5 * (b.corners_y - 1) * b.square_m, 0.0);
  const double breadth_m = (b.corners_x + 1) * b.square_m;
  const double tilt = geom::deg_to_rad(b.max_tilt_deg);
  std::vector<Rigid3> poses;
  base::Random random(base::mix_bits(scene.seed ^ 0xb04d5));
  for (int i = 0; i < b.count; ++i) {
    // Places step through a 3 x 3 grid with the corners first; the tilts turn about ever other axes.
    constexpr std::array<std::pair<int, int>, 9> kPlaces = {
        {{-1, -1}, {1, 1}, {1, -1}, {-1, 1}, {0, 0}, {-1, 0}, {1, 0}, {0, -1}, {0, 1}}};
    const auto [right, down] = kPlaces[static_cast<std::size_t>(i) % kPlaces.size()];
    const double axis = 2.0 * geom::kPi * (0.618034 * i + 0.05 * random.uniform());
    const double angle = tilt * (i % 5 == 4 ? 0.15 : random.uniform(0.55, 1.0));
    const Vector3d tilt_axis(std::cos(axis), std::sin(axis), 0.0);
    const Eigen::Quaterniond rotation(
        Eigen::AngleAxisd(angle, tilt_axis) *
        Eigen::AngleAxisd(random.normal(0.0, geom::deg_to_rad(6.0)), Vector3d::UnitZ()));
    double part = random.uniform(0.30, 0.55);  // breadth of the board in the picture's
    Rigid3 pose;
    // Pulls the board towards the middle, then away from the camera, until all its squares are in the
    // picture.
    for (double pull = 0.0; part > 0.01; pull += 0.04) {
      const double distance_m = scene.camera.fx * breadth_m / (part * scene.camera.width);
      const double reach = std::max(0.0, 1.0 - pull);
      const Vector3d place(
          (scene.camera.cx + reach * right * 0.36 * scene.camera.width - scene.camera.cx) / scene.camera.fx,
          reach * down * 0.34 * scene.camera.height / scene.camera.fy, 1.0);
      pose.rotation = rotation;
      pose.translation = distance_m * place - rotation * middle;
      if (fits(scene, pose)) break;
      if (pull > 1.0) part *= 0.95;
    }
    poses.push_back(pose);
  }
  return poses;
}

LightImage light_board(const Scene& scene, const RayTable& rays, const Rigid3& cam_from_board,
                       std::uint64_t key) {
  const Boards& b = scene.boards;
  const int width = scene.camera.width, height = scene.camera.height;
  const Eigen::Matrix3d to_board = board_from_ray(cam_from_board);
  base::Random random(key);
  const double toward = random.uniform(0.0, 2.0 * geom::kPi);
  const Vector2d gradient =
      Vector2d(std::cos(toward), std::sin(toward)) * b.light_gradient / std::hypot(width, height);
  const auto texture_key = static_cast<std::uint32_t>(key);
  const auto at = [&](const Vector2d& ray) {
    const Vector3d hit = to_board * Vector3d(ray.x(), ray.y(), 1.0);
    return hit.z() > 0.0 ? sheet(b, hit.head<2>() / hit.z()) : kWall;
  };
  LightImage light(width, height);
  // What the pixels' corners see, along the upper and the lower border of one picture row: equal at all four,
  // no edge is in the pixel.
  std::vector<double> upper(static_cast<std::size_t>(width) + 1), lower(upper.size());
  const auto see_border = [&](std::vector<double>& border, double v) {
    for (int u = 0; u <= width; ++u) border[static_cast<std::size_t>(u)] = at(rays.at(u - 0.5, v));
  };
  see_border(lower, -0.5);
  for (int v = 0; v < height; ++v) {
    std::swap(upper, lower);
    see_border(lower, v + 0.5);
    for (int u = 0; u < width; ++u) {
      const auto i = static_cast<std::size_t>(u);
      const double corner = upper[i];
      const bool plain = corner == upper[i + 1] && corner == lower[i] && corner == lower[i + 1];
      double value = corner;
      if (!plain) {
        value = 0.0;
        for (int k = 0; k < kFine * kFine; ++k) {
          value += at(rays.at(u + (k % kFine + 0.5) / kFine - 0.5, v + (k / kFine + 0.5) / kFine - 0.5)) /
                   (kFine * kFine);
        }
      }
      if (plain && corner == kWall) {
        value *= 1.0 +
                 0.25 * static_cast<double>(plane_noise(texture_key, static_cast<float>(u) / 160.0F,
                                                        static_cast<float>(v) / 160.0F)) +
                 0.06 * static_cast<double>(plane_noise(texture_key + 1, static_cast<float>(u) / 9.0F,
                                                        static_cast<float>(v) / 9.0F));
      }
      value *= 1.0 + gradient.dot(Vector2d(u - 0.5 * width, v - 0.5 * height));
      light.at(u, v) = static_cast<float>(value) * Vector3f(1.0F, 0.98F, 0.95F);
    }
  }
  return light;
}

}  // namespace furrow::sim
