#include "furrow/camera/camera.h"

#include <array>
#include <cmath>
#include <Eigen/LU>
#include <limits>
#include <utility>

#include "camera/distort.h"
#include "furrow/base/text.h"

namespace furrow::camera {
namespace {

struct ModelEntry {
  CameraModel model;
  const char* name;
  int distortion_count;
};
constexpr std::array<ModelEntry, 5> kModels{{{CameraModel::pinhole, "pinhole", 0},
                                             {CameraModel::opencv4, "opencv4", 4},
                                             {CameraModel::opencv5, "opencv5", 5},
                                             {CameraModel::opencv8, "opencv8", 8},
                                             {CameraModel::opencv12, "opencv12", 12}}};

const ModelEntry& entry(CameraModel model) {
  for (const ModelEntry& e : kModels) {
    if (e.model == model) return e;
  }
  throw base::CheckFailure("camera model without an entry");
}

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

std::optional<std::string> invalid_field(const Camera& camera) {
  if (camera.width <= 0 || camera.height <= 0) return "image size";
  const std::array<std::pair<const char*, double>, 4> core{
      {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}}};
  for (const auto& [name, value] : core) {
    if (!std::isfinite(value)) return name;
  }
  if (!(camera.fx > 0.0)) return "fx";
  if (!(camera.fy > 0.0)) return "fy";
  if (static_cast<int>(camera.distortion.size()) != distortion_count(camera.model))
    return "distortion (count)";
  for (const double k : camera.distortion) {
    if (!std::isfinite(k)) return "distortion";
  }
  const Eigen::Index n = 4 + distortion_count(camera.model);
  const bool absent = camera.covariance.size() == 0;
  if (!absent && (camera.covariance.rows() != n || camera.covariance.cols() != n)) return "covariance (size)";
  if (!absent && !camera.covariance.allFinite()) return "covariance";
  return std::nullopt;
}

}  // namespace

int distortion_count(CameraModel model) {
  return entry(model).distortion_count;
}

std::string model_name(CameraModel model) {
  return entry(model).name;
}

std::optional<CameraModel> model_from_name(const std::string& name) {
  for (const ModelEntry& e : kModels) {
    if (name == e.name) return e.model;
  }
  return std::nullopt;
}

Eigen::VectorXd intrinsics(const Camera& camera) {
  Eigen::VectorXd out(4 + static_cast<Eigen::Index>(camera.distortion.size()));
  out.head<4>() << camera.fx, camera.fy, camera.cx, camera.cy;
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    out[4 + static_cast<Eigen::Index>(i)] = camera.distortion[i];
  return out;
}

Camera with_intrinsics(Camera camera, const Eigen::VectorXd& values) {
  check(values.size() == 4 + distortion_count(camera.model),
        "with_intrinsics: count of values does not fit the model");
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  camera.distortion.assign(values.data() + 4, values.data() + values.size());
  return camera;
}

Status validate(const Camera& camera) {
  const std::optional<std::string> field = invalid_field(camera);
  if (!field) return Done{};
  return Error{"camera_invalid", *field, "a camera with an impossible " + *field,
               "a positive image size, finite values, focal lengths above 0 and " +
                   std::to_string(distortion_count(camera.model)) + " distortion coefficients for " +
                   model_name(camera.model),
               ""};
}

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0.0)) return std::nullopt;
  const Eigen::Vector2d xy = distort(coefficients(camera), x_in_cam.head<2>() / x_in_cam.z());
  const Eigen::Vector2d px(camera.fx * xy.x() + camera.cx, camera.fy * xy.y() + camera.cy);
  if (!px.allFinite()) return std::nullopt;
  return px;
}

std::optional<Projection> project_with_jacobians(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0.0)) return std::nullopt;
  const double z_inverse = 1.0 / x_in_cam.z();
  const Eigen::Vector2d unit = x_in_cam.head<2>() * z_inverse;
  const Distorted at = distort_with_jacobians(coefficients(camera), unit);
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  Projection out;
  out.px = at.xy.cwiseProduct(focal) + Eigen::Vector2d(camera.cx, camera.cy);
  if (!out.px.allFinite()) return std::nullopt;
  const Eigen::Matrix2d d_unit = focal.asDiagonal() * at.d_xy;
  out.d_point.leftCols<2>() = d_unit * z_inverse;
  out.d_point.col(2) = -(d_unit * unit) * z_inverse;
  const Eigen::Index n = static_cast<Eigen::Index>(camera.distortion.size());
  out.d_intrinsics.setZero(2, 4 + n);
  out.d_intrinsics(0, 0) = at.xy.x();
  out.d_intrinsics(1, 1) = at.xy.y();
  out.d_intrinsics(0, 2) = 1.0;
  out.d_intrinsics(1, 3) = 1.0;
  if (n > 0) out.d_intrinsics.rightCols(n) = focal.asDiagonal() * at.d_coefficients.leftCols(n);
  return out;
}

std::optional<double> fold_radius(const Camera& camera) {
  const double fold = radial_fold(coefficients(camera));
  return std::isfinite(fold) ? std::optional(fold) : std::nullopt;
}

std::optional<Eigen::Vector2d> unproject(const Camera& camera, const Eigen::Vector2d& px) {
  const Coefficients k = coefficients(camera);
  const Eigen::Vector2d wanted((px.x() - camera.cx) / camera.fx, (px.y() - camera.cy) / camera.fy);
  if (!wanted.allFinite()) return std::nullopt;
  if (k.isZero(0.0)) return wanted;
  // Newton from the pixel itself is right nearly everywhere; only where that cannot be shown is the fold
  // looked for.
  const std::optional<Eigen::Vector2d> quick = newton(camera, k, wanted, wanted);
  if (quick && surely_grows_to(k, quick->norm()) && unfolded_from_axis(k, *quick)) return quick;
  return unproject_below_fold(camera, k, wanted);
}

std::optional<Eigen::Matrix2d> unproject_jacobian(const Camera& camera,
                                                  const Eigen::Vector2d& on_unit_plane) {
  if (!on_unit_plane.allFinite()) return std::nullopt;
  const Distorted at = distort_with_jacobians(coefficients(camera), on_unit_plane);
  const Eigen::Matrix2d d_px = Eigen::Vector2d(camera.fx, camera.fy).asDiagonal() * at.d_xy;
  if (!(d_px.determinant() > 0.0)) return std::nullopt;
  return d_px.inverse();
}

Camera resize_camera(const Camera& camera, int width, int height) {
  check(width > 0 && height > 0 && camera.width > 0 && camera.height > 0,
        "resize_camera: sizes must be positive");
  const double su = static_cast<double>(width) / camera.width,
               sv = static_cast<double>(height) / camera.height;
  Camera out = camera;
  out.width = width;
  out.height = height;
  out.fx = camera.fx * su;
  out.fy = camera.fy * sv;
  out.cx = (camera.cx + 0.5) * su - 0.5;
  out.cy = (camera.cy + 0.5) * sv - 0.5;
  if (camera.covariance.size() > 0) {
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(camera.covariance.rows());
    scale.head<4>() << su, sv, su, sv;
    out.covariance = scale.asDiagonal() * camera.covariance * scale.asDiagonal();
  }
  if (width != camera.width || height != camera.height) {
    out.provenance += (out.provenance.empty() ? "" : "; ");
    out.provenance += "resampled from " + std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                      " to " + std::to_string(width) + "x" + std::to_string(height);
  }
  return out;
}

Result<Camera> carry_camera(const Camera& camera, int width, int height) {
  FURROW_DO(validate(camera));
  const std::string from = std::to_string(camera.width) + "x" + std::to_string(camera.height);
  const std::string to = std::to_string(width) + "x" + std::to_string(height);
  if (width <= 0 || height <= 0) {
    return Error{"camera_aspect_differs", "camera", "a picture of " + to, "a picture with pixels", ""};
  }
  // Judged on the smaller of the two pictures: there half a pixel is what rounding the size may cost.
  const double su = static_cast<double>(width) / camera.width,
               sv = static_cast<double>(height) / camera.height;
  const double miss_px = std::abs(su - sv) * std::min(camera.height, camera.width) / std::max({1.0, su, sv});
  if (miss_px > 0.5) {
    return Error{"camera_aspect_differs", "camera", "a camera for " + from + " and a picture of " + to,
                 "pictures with the camera's ratio of width to height",
                 "a crop's place is not in the picture: calibrate with pictures of this size"};
  }
  return resize_camera(camera, width, height);
}

double focal_length_mm(double focal_px, double sensor_width_mm, int image_width_px) {
  check(image_width_px > 0, "focal_length_mm: image width must be positive");
  return focal_px * sensor_width_mm / image_width_px;
}

FieldOfView field_of_view(double sensor_width_mm, double sensor_height_mm, double focal_mm) {
  const auto angle_rad = [&](double side_mm) { return 2.0 * std::atan2(0.5 * side_mm, focal_mm); };
  return {angle_rad(sensor_width_mm), angle_rad(sensor_height_mm),
          angle_rad(std::hypot(sensor_width_mm, sensor_height_mm))};
}

}  // namespace furrow::camera
