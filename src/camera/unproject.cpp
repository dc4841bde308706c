#include <cmath>
#include <Eigen/Dense>
#include <limits>

#include "camera/distort.h"
#include "camera/wide.h"
#include "furrow/camera/camera.h"

namespace furrow::camera {
namespace {

/// How near a projection must come to the pixel that was asked for, px.
constexpr double kConvergedPx = 1e-9;

/// Distance on the unit plane whose radial distortion gives `distorted`; nothing when none below the fold
/// does.
std::optional<double> invert_radial(const Coefficients& k, double distorted, double fold) {
  double low = 0.0, high = std::isfinite(fold) ? fold : std::max(1.0, distorted);
  if (!std::isfinite(fold)) {
    constexpr double kFarthestRadius = 1e9;
    while (radial(k, high) < distorted && high < kFarthestRadius) high *= 2.0;
  }
  if (!(radial(k, high) >= distorted)) return std::nullopt;
  // A few halvings put Newton's method in two dimensions within its reach; 60 would give the last bit.
  constexpr int kHalvings = 24;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (radial(k, middle) < distorted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Newton's method with step halving; nothing when it does not reach `wanted` (within kConvergedPx).
std::optional<Eigen::Vector2d> newton(const Camera& camera, const Coefficients& k,
                                      const Eigen::Vector2d& wanted, Eigen::Vector2d xy) {
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  constexpr int kMaxSteps = 60;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector2d residual = wanted - distort(k, xy);
    const double miss_px = residual.cwiseProduct(focal).norm();
    // Below the promise by a margin, above the rounding of pixel numbers in the thousands.
    if (miss_px < 1e-2 * kConvergedPx) return xy;
    const Eigen::Vector2d delta = distort_jacobian(k, xy).inverse() * residual;
    if (!delta.allFinite()) return std::nullopt;
    double share = 1.0;
    constexpr double kSmallestShare = 1e-6;
    while (share > kSmallestShare && !((wanted - distort(k, xy + share * delta)).norm() < residual.norm()))
      share *= 0.5;
    if (share <= kSmallestShare) return miss_px < kConvergedPx ? std::optional(xy) : std::nullopt;
    xy += share * delta;
  }
  return std::nullopt;
}

/// Whether the model keeps its orientation all the way from the axis to xy, so that xy lies on the sheet that
/// a lens can show.
bool unfolded_from_axis(const Coefficients& k, const Eigen::Vector2d& xy) {
  constexpr int kSamples = 8;
  for (int i = 1; i <= kSamples; ++i) {
    if (!(distort_jacobian(k, xy * (static_cast<double>(i) / kSamples)).determinant() > 0.0)) return false;
  }
  return true;
}

/// By the radial inverse below the fold, which is found for this call: the slow and sure way.
std::optional<Eigen::Vector2d> unproject_below_fold(const Camera& camera, const Coefficients& k,
                                                    const Eigen::Vector2d& wanted) {
  const double fold = radial_fold(k), distorted = wanted.norm();
  // Near the fold the tangential terms may carry a pixel across the radial limit: start just inside and let
  // Newton decide.
  constexpr double kJustInside = 0.98;
  const std::optional<double> r = invert_radial(k, distorted, fold);
  if (!r && !std::isfinite(fold)) return std::nullopt;
  const double share = distorted > 0.0 ? r.value_or(kJustInside * fold) / distorted : 1.0;
  const std::optional<Eigen::Vector2d> xy = newton(camera, k, wanted, wanted * share);
  if (!xy || !unfolded_from_axis(k, *xy)) return std::nullopt;
  return xy;
}

/// Point of the unit plane that distorts to `wanted`.
std::optional<Eigen::Vector2d> unproject_on_unit_plane(const Camera& camera, const Eigen::Vector2d& wanted) {
  const Coefficients k = coefficients(camera);
  if (k.isZero(0.0)) return wanted;
  // Newton from the pixel itself is right nearly everywhere; only where that cannot be shown is the fold
  // looked for.
  const std::optional<Eigen::Vector2d> quick = newton(camera, k, wanted, wanted);
  if (quick && surely_grows_to(k, quick->norm()) && unfolded_from_axis(k, *quick)) return quick;
  return unproject_below_fold(camera, k, wanted);
}

}  // namespace

std::optional<Eigen::Vector3d> unproject_ray(const Camera& camera, const Eigen::Vector2d& px) {
  const Eigen::Vector2d wanted((px.x() - camera.cx) / camera.fx, (px.y() - camera.cy) / camera.fy);
  if (!wanted.allFinite()) return std::nullopt;
  if (!is_on_unit_plane(camera.model)) return straighten(camera, wanted);
  const std::optional<Eigen::Vector2d> xy = unproject_on_unit_plane(camera, wanted);
  return xy ? std::optional<Eigen::Vector3d>(xy->homogeneous().normalized()) : std::nullopt;
}

std::optional<Eigen::Vector2d> unproject(const Camera& camera, const Eigen::Vector2d& px) {
  const Eigen::Vector2d wanted((px.x() - camera.cx) / camera.fx, (px.y() - camera.cy) / camera.fy);
  if (!wanted.allFinite()) return std::nullopt;
  if (is_on_unit_plane(camera.model)) return unproject_on_unit_plane(camera, wanted);
  const std::optional<Eigen::Vector3d> ray = straighten(camera, wanted);
  // Half a milliradian short of 90 degrees; beyond, the unit plane holds no digits.
  constexpr double kFarthestOff = 5e-4;
  if (!ray || ray->z() < kFarthestOff) return std::nullopt;
  return Eigen::Vector2d(ray->head<2>() / ray->z());
}

std::optional<Eigen::Matrix2d> unproject_jacobian(const Camera& camera,
                                                  const Eigen::Vector2d& on_unit_plane) {
  if (!on_unit_plane.allFinite()) return std::nullopt;
  const auto at = project_with_jacobians(camera, on_unit_plane.homogeneous());
  if (!at) return std::nullopt;
  const Eigen::Matrix2d d_px = at->d_point.leftCols<2>();
  if (!(d_px.determinant() > 0.0)) return std::nullopt;
  return d_px.inverse();
}

}  // namespace furrow::camera
