#include "camera/wide.h"

#include <cmath>
#include <Eigen/LU>
#include <numbers>

#include "camera/polynomial.h"
#include "camera/spline.h"

namespace furrow::camera {
namespace {

constexpr double kPi = std::numbers::pi;

/// (X, Y) times a factor g of the point, with g's gradient.
Bent scaled(const Eigen::Vector3d& x, double g, const Eigen::Vector3d& d_g) {
  Bent out;
  out.xy = g * x.head<2>();
  out.d_point = x.head<2>() * d_g.transpose();
  out.d_point(0, 0) += g;
  out.d_point(1, 1) += g;
  out.d_coefficients.resize(2, 0);
  return out;
}

/// theta (1 + k1 theta^2 + ...) and its slope by theta.
Eigen::Vector2d fisheye_radius(const Camera& camera, double theta) {
  const std::vector<double>& k = camera.distortion;
  const double s = theta * theta;
  return {theta * (1.0 + s * (k[0] + s * (k[1] + s * (k[2] + s * k[3])))),
          1.0 + s * (3.0 * k[0] + s * (5.0 * k[1] + s * (7.0 * k[2] + s * 9.0 * k[3])))};
}

std::optional<Bent> bend_fisheye(const Camera& camera, const Eigen::Vector3d& x) {
  const double r = x.head<2>().norm(), theta = std::atan2(r, x.z());
  if (r == 0.0 && !(x.z() > 0.0)) return std::nullopt;
  Bent out;
  if (r == 0.0) {
    out = scaled(x, 1.0 / x.z(), {0.0, 0.0, -1.0 / (x.z() * x.z())});
  } else {
    const Eigen::Vector2d bent = fisheye_radius(camera, theta);
    const double square = x.squaredNorm();
    const Eigen::Vector3d d_r(x.x() / r, x.y() / r, 0.0);
    const Eigen::Vector3d d_theta(d_r.x() * x.z() / square, d_r.y() * x.z() / square, -r / square);
    out = scaled(x, bent[0] / r, (bent[1] * d_theta - bent[0] / r * d_r) / r);
  }
  out.d_coefficients.resize(2, 4);
  const Eigen::Vector2d way = r > 0.0 ? Eigen::Vector2d(x.head<2>() / r) : Eigen::Vector2d::Zero();
  double power = theta;
  for (int i = 0; i < 4; ++i) {
    power *= theta * theta;
    out.d_coefficients.col(i) = power * way;
    out.place[static_cast<std::size_t>(i)] = i;
  }
  return out;
}

std::optional<Eigen::Vector3d> straighten_fisheye(const Camera& camera, const Eigen::Vector2d& xy) {
  const double wanted = xy.norm();
  if (wanted == 0.0) return Eigen::Vector3d::UnitZ();
  double low = 0.0, high = fisheye_fold_rad(camera);
  if (!(fisheye_radius(camera, high)[0] >= wanted)) return std::nullopt;
  // Newton's method kept inside a shrinking bracket: the radius grows all the way to the fold.
  double theta = std::min(wanted, high);
  constexpr int kMostSteps = 100;
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::Vector2d at = fisheye_radius(camera, theta);
    (at[0] < wanted ? low : high) = theta;
    double next = theta + (wanted - at[0]) / at[1];
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - theta) <= 1e-16 * (1.0 + theta)) break;
    theta = next;
  }
  const double s = std::sin(theta) / wanted;
  return Eigen::Vector3d(s * xy.x(), s * xy.y(), std::cos(theta));
}

std::optional<Bent> bend_stereographic(const Eigen::Vector3d& x) {
  const double length = x.norm(), under = length + x.z();
  // Straight behind, or so near that the sum has lost its digits.
  constexpr double kBehind = 1e-14;
  if (!(under > kBehind * length)) return std::nullopt;
  const double g = 2.0 / under;
  return scaled(x, g, -0.5 * g * g * (x / length + Eigen::Vector3d::UnitZ()));
}

Eigen::Vector3d straighten_stereographic(const Eigen::Vector2d& xy) {
  return Eigen::Vector3d(xy.x(), xy.y(), 1.0 - 0.25 * xy.squaredNorm()).normalized();
}

/// Rows of constant longitude, counted about the x axis, as mrcal has it for stereo pairs side by side.
std::optional<Bent> bend_latlon(const Eigen::Vector3d& x) {
  const double across = std::hypot(x.y(), x.z()), square = x.squaredNorm();
  if (!(across > 0.0)) return std::nullopt;
  Bent out;
  out.xy = {std::atan2(x.x(), across), std::atan2(x.y(), x.z())};
  out.d_point.row(0) << across / square, -x.x() * x.y() / (across * square),
      -x.x() * x.z() / (across * square);
  out.d_point.row(1) << 0.0, x.z() / (across * across), -x.y() / (across * across);
  out.d_coefficients.resize(2, 0);
  return out;
}

std::optional<Eigen::Vector3d> straighten_latlon(const Eigen::Vector2d& xy) {
  if (!(std::abs(xy.y()) <= kPi && std::abs(xy.x()) < 0.5 * kPi)) return std::nullopt;
  return Eigen::Vector3d(std::sin(xy.x()), std::cos(xy.x()) * std::sin(xy.y()),
                         std::cos(xy.x()) * std::cos(xy.y()));
}

std::optional<Bent> bend_splined(const Camera& camera, const Eigen::Vector3d& x, const SplinePatch* held) {
  std::optional<Bent> out = bend_stereographic(x);
  if (!out) return out;
  const SplineSample at =
      sample_patch(camera, out->xy, held != nullptr ? *held : patch_at(camera.spline, out->xy));
  out->xy += at.shift;
  out->d_point = (Eigen::Matrix2d::Identity() + at.d_shift) * out->d_point;
  out->d_coefficients.setZero(2, 2 * at.knots);
  for (int i = 0; i < at.knots; ++i) {
    const auto knot = static_cast<std::size_t>(i);
    for (int axis = 0; axis < 2; ++axis) {
      out->d_coefficients(axis, 2 * i + axis) = at.weight[knot];
      out->place[2 * knot + static_cast<std::size_t>(axis)] = 2 * at.knot[knot] + axis;
    }
  }
  return out;
}

/// Newton's method with step halving on u + shift(u) = xy, from xy itself; the way back to the middle must
/// keep its orientation, so that the answer lies on the sheet that the lens shows.
std::optional<Eigen::Vector3d> straighten_splined(const Camera& camera, const Eigen::Vector2d& xy) {
  Eigen::Vector2d u = xy;
  const auto miss_at = [&](const Eigen::Vector2d& place) -> Eigen::Vector2d {
    return xy - place - sample_spline(camera, place).shift;
  };
  Eigen::Vector2d miss = miss_at(u);
  // Far below 1e-9 px for any focal length of some thousand px.
  constexpr double kConverged = 1e-15;
  constexpr int kMostSteps = 60;
  for (int step = 0; step < kMostSteps && miss.norm() > kConverged; ++step) {
    const Eigen::Vector2d delta =
        (Eigen::Matrix2d::Identity() + sample_spline(camera, u).d_shift).inverse() * miss;
    if (!delta.allFinite()) return std::nullopt;
    double share = 1.0;
    constexpr double kSmallestShare = 1e-4;
    while (share > kSmallestShare && !(miss_at(u + share * delta).norm() < miss.norm())) share *= 0.5;
    if (share <= kSmallestShare) break;
    u += share * delta;
    miss = miss_at(u);
  }
  constexpr double kAccepted = 1e-13;
  if (!(miss.norm() <= kAccepted * std::max(1.0, xy.norm()))) return std::nullopt;
  constexpr int kSamples = 8;
  for (int i = 0; i <= kSamples; ++i) {
    const Eigen::Matrix2d d = Eigen::Matrix2d::Identity() + sample_spline(camera, u * i / kSamples).d_shift;
    if (!(d.determinant() > 0.0)) return std::nullopt;
  }
  return straighten_stereographic(u);
}

}  // namespace

bool is_on_unit_plane(CameraModel model) {
  return model == CameraModel::pinhole || model == CameraModel::opencv4 || model == CameraModel::opencv5 ||
         model == CameraModel::opencv8 || model == CameraModel::opencv12;
}

std::optional<Bent> bend(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!x_in_cam.allFinite()) return std::nullopt;
  switch (camera.model) {
    case CameraModel::fisheye:
      return bend_fisheye(camera, x_in_cam);
    case CameraModel::stereographic:
      return bend_stereographic(x_in_cam);
    case CameraModel::latlon:
      return bend_latlon(x_in_cam);
    case CameraModel::splined_stereographic:
      return bend_splined(camera, x_in_cam, nullptr);
    default:
      throw base::CheckFailure("bend: a model on the unit plane");
  }
}

std::optional<Bent> bend_by_patch(const Camera& camera, const Eigen::Vector3d& x_in_cam,
                                  const SplinePatch& patch) {
  check(camera.model == CameraModel::splined_stereographic, "bend_by_patch: a splined camera has patches");
  return x_in_cam.allFinite() ? bend_splined(camera, x_in_cam, &patch) : std::nullopt;
}

std::optional<SplinePatch> spline_patch(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  check(camera.model == CameraModel::splined_stereographic, "spline_patch: a splined camera has patches");
  const std::optional<Bent> at = x_in_cam.allFinite() ? bend_stereographic(x_in_cam) : std::nullopt;
  return at ? std::optional(patch_at(camera.spline, at->xy)) : std::nullopt;
}

std::optional<Eigen::Vector3d> straighten(const Camera& camera, const Eigen::Vector2d& xy) {
  switch (camera.model) {
    case CameraModel::fisheye:
      return straighten_fisheye(camera, xy);
    case CameraModel::stereographic:
      return straighten_stereographic(xy);
    case CameraModel::latlon:
      return straighten_latlon(xy);
    case CameraModel::splined_stereographic:
      return straighten_splined(camera, xy);
    default:
      throw base::CheckFailure("straighten: a model on the unit plane");
  }
}

double fisheye_fold_rad(const Camera& camera) {
  const std::vector<double>& k = camera.distortion;
  const std::vector<double> roots =
      roots_within({1.0, 3.0 * k[0], 5.0 * k[1], 7.0 * k[2], 9.0 * k[3]}, kPi * kPi);
  return roots.empty() ? kPi : std::sqrt(roots.front());
}

}  // namespace furrow::camera
