#include "furrow/camera/describe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace furrow::camera {
namespace {

std::optional<double> angle_between(const Camera& camera, const Eigen::Vector2d& a_px,
                                    const Eigen::Vector2d& b_px) {
  const auto a = unproject_ray(camera, a_px), b = unproject_ray(camera, b_px);
  if (!a || !b) return std::nullopt;
  // By way of the axis, so that more than 180 degrees come out as such.
  const auto off = [](const Eigen::Vector3d& ray) { return std::acos(std::clamp(ray.z(), -1.0, 1.0)); };
  const double plain = std::acos(std::clamp(a->dot(*b), -1.0, 1.0));
  return off(*a) + off(*b) > std::numbers::pi ? 2.0 * std::numbers::pi - plain : plain;
}

/// The corner of the picture farthest from the principal point.
Eigen::Vector2d farthest_corner(const Camera& camera) {
  return {camera.cx > 0.5 * (camera.width - 1) ? 0.0 : camera.width - 1.0,
          camera.cy > 0.5 * (camera.height - 1) ? 0.0 : camera.height - 1.0};
}

/// A pinhole's radius has doubled by here and soon has no bound.
constexpr double kWidestCompared_rad = std::numbers::pi / 3.0;

/// Radius of a pixel minus that of the same ray in a pinhole of the same focal length.
std::optional<double> shift_px(const Camera& camera, const Eigen::Vector2d& focal_px,
                               const Eigen::Vector2d& px) {
  const auto xy = unproject(camera, px);
  if (!xy || xy->norm() > std::tan(kWidestCompared_rad)) return std::nullopt;
  return (px - Eigen::Vector2d(camera.cx, camera.cy)).norm() - xy->cwiseProduct(focal_px).norm();
}

}  // namespace

Description describe(const Camera& camera) {
  Description out;
  out.focal_px = focal_on_axis_px(camera);
  const double right = camera.width - 1.0, low = camera.height - 1.0;
  // Between the outer edges of the outermost pixels, as a sensor's size is meant.
  out.horizontal_rad = angle_between(camera, {-0.5, 0.5 * low}, {right + 0.5, 0.5 * low});
  out.vertical_rad = angle_between(camera, {0.5 * right, -0.5}, {0.5 * right, low + 0.5});
  out.diagonal_rad = angle_between(camera, {-0.5, -0.5}, {right + 0.5, low + 0.5});
  out.corner_distortion_px = shift_px(camera, out.focal_px, farthest_corner(camera));
  constexpr int kColumns = 64, kRows = 48;
  int without = 0;
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const Eigen::Vector2d px(right * i / (kColumns - 1), low * j / (kRows - 1));
      if (unproject_ray(camera, px)) continue;
      ++without;
      const double radius = (px - Eigen::Vector2d(camera.cx, camera.cy)).norm();
      out.inverse_reach_px = std::min(out.inverse_reach_px.value_or(radius), radius);
    }
  }
  out.without_inverse = static_cast<double>(without) / (kColumns * kRows);
  return out;
}

std::vector<DistortionPoint> distortion_curve(const Camera& camera, int count) {
  check(count > 1, "distortion_curve: two places at least");
  const Eigen::Vector2d middle(camera.cx, camera.cy), way = farthest_corner(camera) - middle;
  const Eigen::Vector2d focal_px = focal_on_axis_px(camera);
  std::vector<DistortionPoint> out;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d px = middle + way * i / (count - 1);
    const auto ray = unproject_ray(camera, px);
    if (!ray) break;
    DistortionPoint point;
    point.radius_px = (px - middle).norm();
    point.angle_rad = std::acos(std::clamp(ray->z(), -1.0, 1.0));
    point.shift_px = shift_px(camera, focal_px, px).value_or(std::numeric_limits<double>::quiet_NaN());
    out.push_back(point);
  }
  return out;
}

}  // namespace furrow::camera
