#include "sim/board.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/world.h"
#include "furrow/target/artwork.h"
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

/// What is printed and the paper around it.
struct Sheet {
  target::Artwork artwork;
  target::PrintedExtent paper;
};

Sheet make_sheet(const Boards& boards) {
  const target::BoardSpec board = printed_board(boards);
  Sheet out{target::make_artwork(board), target::printed_extent(board)};
  const Vector2d margin = Vector2d::Constant(kPaperMargin * boards.square_m);
  out.paper.low_m -= margin;
  out.paper.high_m += margin;
  return out;
}

/// Light of the sheet's plane at a point of the board.
double light_of(const Sheet& sheet, const Vector2d& x_in_board) {
  const bool off = (x_in_board.array() < sheet.paper.low_m.array()).any() ||
                   (x_in_board.array() > sheet.paper.high_m.array()).any();
  if (off) return kWall;
  return target::is_black(sheet.artwork, x_in_board) ? kBlack : kWhite;
}

/// Where rays meet the board's plane: x_in_board is the dehomogenised product.
Eigen::Matrix3d board_from_ray(const Rigid3& cam_from_board) {
  Eigen::Matrix3d plane;
  const Eigen::Matrix3d rotation = cam_from_board.rotation.toRotationMatrix();
  plane << rotation.col(0), rotation.col(1), cam_from_board.translation;
  return plane.inverse();
}

/// Whether all that is printed is in the picture, or no farther out than the scene allows; the paper around
/// it need not be.
bool fits(const Scene& scene, const Rigid3& cam_from_board) {
  const target::PrintedExtent printed = target::printed_extent(printed_board(scene.boards));
  const double margin_px =
      scene.boards.outside > 0.0 ? -scene.boards.outside * scene.camera.width : kPictureMargin_px;
  for (const double x : {printed.low_m.x(), printed.high_m.x()}) {
    for (const double y : {printed.low_m.y(), printed.high_m.y()}) {
      const auto px = camera::project(scene.camera, cam_from_board * Vector3d(x, y, 0.0));
      if (!px || px->x() < margin_px || px->y() < margin_px || px->x() > scene.camera.width - 1 - margin_px ||
          px->y() > scene.camera.height - 1 - margin_px) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace

target::BoardSpec printed_board(const Boards& boards) {
  target::BoardSpec out{"board", boards.corners_x, boards.corners_y, boards.square_m, 1.0, boards.type};
  if (boards.type == target::BoardKind::charuco) {
    out.marker_m = boards.marker_m;
    out.dictionary = "5x5_250";
  } else if (boards.type == target::BoardKind::aprilgrid) {
    out.gap_m = boards.gap_m;
    out.dictionary = "apriltag_36h11";
  }
  return out;
}

std::vector<Rigid3> true_boards(const Scene& scene) {
  const Boards& b = scene.boards;
  const target::PrintedExtent printed = target::printed_extent(printed_board(b));
  const Vector2d centre = 0.5 * (printed.low_m + printed.high_m);
  const Vector3d middle(centre.x(), centre.y(), 0.0);
  const double breadth_m = printed.high_m.x() - printed.low_m.x();
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
  const Sheet sheet = make_sheet(b);
  const Eigen::Matrix3d to_board = board_from_ray(cam_from_board);
  base::Random random(key);
  const double toward = random.uniform(0.0, 2.0 * geom::kPi);
  const Vector2d gradient =
      Vector2d(std::cos(toward), std::sin(toward)) * b.light_gradient / std::hypot(width, height);
  const auto texture_key = static_cast<std::uint32_t>(key);
  const auto at = [&](const Vector2d& ray) {
    const Vector3d hit = to_board * Vector3d(ray.x(), ray.y(), 1.0);
    return hit.z() > 0.0 ? light_of(sheet, hit.head<2>() / hit.z()) : kWall;
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
