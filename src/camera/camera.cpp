#include "furrow/camera/camera.h"

#include <array>
#include <cmath>
#include <Eigen/LU>
#include <numbers>
#include <utility>

#include "camera/distort.h"
#include "camera/wide.h"
#include "furrow/base/text.h"

namespace furrow::camera {
namespace {

struct ModelEntry {
  CameraModel model;
  const char* name;
  int distortion_count;
};
constexpr std::array<ModelEntry, 9> kModels{
    {{CameraModel::pinhole, "pinhole", 0},
     {CameraModel::opencv4, "opencv4", 4},
     {CameraModel::opencv5, "opencv5", 5},
     {CameraModel::opencv8, "opencv8", 8},
     {CameraModel::opencv12, "opencv12", 12},
     {CameraModel::fisheye, "fisheye", 4},
     {CameraModel::stereographic, "stereographic", 0},
     {CameraModel::latlon, "latlon", 0},
     {CameraModel::splined_stereographic, "splined_stereographic", 0}}};

const ModelEntry& entry(CameraModel model) {
  for (const ModelEntry& e : kModels) {
    if (e.model == model) return e;
  }
  throw base::CheckFailure("camera model without an entry");
}

/// As many knots as a patch needs, and no more than a lens could ever want.
bool is_possible(const SplineGrid& grid) {
  constexpr int kMostKnots = 1000;
  return (grid.order == 2 || grid.order == 3) && std::min(grid.columns, grid.rows) > grid.order &&
         std::max(grid.columns, grid.rows) <= kMostKnots && grid.fov_x_deg >= 1 && grid.fov_x_deg < 360;
}

/// Pictures have at most 200 megapixels; work that goes along a side must end.
constexpr int kLargestSide = 100'000;
/// No lens is shorter than a hundredth of the picture's larger side (a circle of all directions takes a
/// sixth) or longer than a thousand of them (a telescope): outside, the numbers are of another unit or size.
constexpr double kShortestFocal = 0.01, kLongestFocal = 1000.0;
/// Cinema lenses squeeze by 2; more is a slip in one of the two focal lengths.
constexpr double kMostSqueezed = 4.0;

bool is_possible_focal(double focal_px, const Camera& camera) {
  const double side = std::max(camera.width, camera.height);
  return focal_px >= kShortestFocal * side && focal_px <= kLongestFocal * side;
}

/// Finite, no variance below 0, no correlation beyond 1 (by more than printed digits cost).
bool is_covariance(const Eigen::MatrixXd& c) {
  constexpr double kSlack = 1e-6;
  if (!c.allFinite() || (c.diagonal().array() < 0.0).any()) return false;
  const Eigen::VectorXd sigma = c.diagonal().cwiseSqrt();
  return (c.array().abs() <= (1.0 + kSlack) * (sigma * sigma.transpose()).array()).all();
}

std::optional<std::string> invalid_field(const Camera& camera) {
  if (std::min(camera.width, camera.height) <= 0 || std::max(camera.width, camera.height) > kLargestSide)
    return "image size";
  const std::array<std::pair<const char*, double>, 4> core{
      {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}}};
  for (const auto& [name, value] : core) {
    if (!std::isfinite(value)) return name;
  }
  if (!is_possible_focal(camera.fx, camera)) return "fx";
  if (!is_possible_focal(camera.fy, camera)) return "fy";
  if (std::max(camera.fx, camera.fy) > kMostSqueezed * std::min(camera.fx, camera.fy)) return "fx / fy";
  if (camera.model == CameraModel::splined_stereographic && !is_possible(camera.spline))
    return "grid of knots";
  if (static_cast<int>(camera.distortion.size()) != distortion_count(camera.model, camera.spline))
    return "distortion (count)";
  for (const double k : camera.distortion) {
    if (!std::isfinite(k)) return "distortion";
  }
  const Eigen::Index n = 4 + distortion_count(camera.model, camera.spline);
  const bool absent = camera.covariance.size() == 0;
  if (!absent && (camera.covariance.rows() != n || camera.covariance.cols() != n)) return "covariance (size)";
  if (!absent && !is_covariance(camera.covariance)) return "covariance";
  return std::nullopt;
}

}  // namespace

int distortion_count(CameraModel model, const SplineGrid& grid) {
  return model == CameraModel::splined_stereographic ? 2 * grid.columns * grid.rows
                                                     : entry(model).distortion_count;
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

std::string model_names() {
  std::string out;
  for (const ModelEntry& e : kModels) out += (out.empty() ? "" : ", ") + std::string(e.name);
  return out;
}

Eigen::Matrix2Xd Projection::by_all_intrinsics(Eigen::Index count) const {
  Eigen::Matrix2Xd out = Eigen::Matrix2Xd::Zero(2, count);
  for (Eigen::Index i = 0; i < d_intrinsics.cols(); ++i)
    out.col(place[static_cast<std::size_t>(i)]) = d_intrinsics.col(i);
  return out;
}

Eigen::VectorXd intrinsics(const Camera& camera) {
  Eigen::VectorXd out(4 + static_cast<Eigen::Index>(camera.distortion.size()));
  out.head<4>() << camera.fx, camera.fy, camera.cx, camera.cy;
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    out[4 + static_cast<Eigen::Index>(i)] = camera.distortion[i];
  return out;
}

Camera with_intrinsics(Camera camera, const Eigen::VectorXd& values) {
  check(values.size() == 4 + distortion_count(camera.model, camera.spline),
        "with_intrinsics: count of values does not fit the model");
  camera.fx = values[0];
  camera.fy = values[1];
  camera.cx = values[2];
  camera.cy = values[3];
  camera.distortion.assign(values.data() + 4, values.data() + values.size());
  return camera;
}

std::vector<std::string> intrinsic_names(const Camera& camera) {
  std::vector<std::string> out{"fx", "fy", "cx", "cy"};
  if (camera.model == CameraModel::splined_stereographic) {
    for (int j = 0; j < camera.spline.rows; ++j) {
      for (int i = 0; i < camera.spline.columns; ++i) {
        const std::string place = "(" + std::to_string(i) + "," + std::to_string(j) + ")";
        out.push_back("x" + place);
        out.push_back("y" + place);
      }
    }
    return out;
  }
  const std::vector<std::string> plane{"k1", "k2", "p1", "p2", "k3", "k4",
                                       "k5", "k6", "s1", "s2", "s3", "s4"};
  const std::vector<std::string> angle{"k1", "k2", "k3", "k4"};
  const std::vector<std::string>& names = camera.model == CameraModel::fisheye ? angle : plane;
  const auto count = std::min<std::size_t>(camera.distortion.size(), names.size());
  out.insert(out.end(), names.begin(), names.begin() + static_cast<std::ptrdiff_t>(count));
  return out;
}

Status validate(const Camera& camera) {
  const std::optional<std::string> field = invalid_field(camera);
  if (!field) return Done{};
  return Error{"camera_invalid", *field, "a camera with an impossible " + *field,
               "an image size of 1 to 100000 pixels a side, finite values, focal lengths of 0.01 to 1000 "
               "times the larger side and "
               "within a factor of 4 of each other, and " +
                   std::to_string(distortion_count(camera.model, camera.spline)) +
                   " distortion coefficients for " + model_name(camera.model) +
                   "; in a covariance no variance below 0 and no correlation beyond 1",
               ""};
}

namespace {

/// A point that has been through the lens, as a pixel; nothing when it is not finite.
std::optional<Eigen::Vector2d> pixel(const Camera& camera, const Eigen::Vector2d& xy) {
  const Eigen::Vector2d px(camera.fx * xy.x() + camera.cx, camera.fy * xy.y() + camera.cy);
  if (!px.allFinite()) return std::nullopt;
  return px;
}

/// The lens at a point in cam, whichever kind of model it is.
std::optional<Bent> lens_at(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!is_on_unit_plane(camera.model)) return bend(camera, x_in_cam);
  if (!(x_in_cam.z() > 0.0)) return std::nullopt;
  const double z_inverse = 1.0 / x_in_cam.z();
  const Eigen::Vector2d unit = x_in_cam.head<2>() * z_inverse;
  const Distorted at = distort_with_jacobians(coefficients(camera), unit);
  Bent out;
  out.xy = at.xy;
  out.d_point.leftCols<2>() = at.d_xy * z_inverse;
  out.d_point.col(2) = -(at.d_xy * unit) * z_inverse;
  const auto n = static_cast<Eigen::Index>(camera.distortion.size());
  out.d_coefficients = at.d_coefficients.leftCols(n);
  for (int i = 0; i < n; ++i) out.place[static_cast<std::size_t>(i)] = i;
  return out;
}

}  // namespace

std::optional<Eigen::Vector2d> project(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!is_on_unit_plane(camera.model)) {
    const std::optional<Bent> at = bend(camera, x_in_cam);
    return at ? pixel(camera, at->xy) : std::nullopt;
  }
  if (!(x_in_cam.z() > 0.0)) return std::nullopt;
  return pixel(camera, distort(coefficients(camera), x_in_cam.head<2>() / x_in_cam.z()));
}

namespace {

std::optional<Projection> projection(const Camera& camera, const std::optional<Bent>& at) {
  const std::optional<Eigen::Vector2d> px = at ? pixel(camera, at->xy) : std::nullopt;
  if (!px) return std::nullopt;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  Projection out;
  out.px = *px;
  out.d_point = focal.asDiagonal() * at->d_point;
  const Eigen::Index n = at->d_coefficients.cols();
  out.d_intrinsics.setZero(2, 4 + n);
  out.d_intrinsics(0, 0) = at->xy.x();
  out.d_intrinsics(1, 1) = at->xy.y();
  out.d_intrinsics(0, 2) = 1.0;
  out.d_intrinsics(1, 3) = 1.0;
  if (n > 0) out.d_intrinsics.rightCols(n) = focal.asDiagonal() * at->d_coefficients;
  for (int i = 0; i < 4; ++i) out.place[static_cast<std::size_t>(i)] = i;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) out.place[4 + i] = 4 + at->place[i];
  return out;
}

}  // namespace

std::optional<Projection> project_with_jacobians(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  return projection(camera, lens_at(camera, x_in_cam));
}

std::optional<Projection> project_by_patch(const Camera& camera, const Eigen::Vector3d& x_in_cam,
                                           const SplinePatch& patch) {
  return projection(camera, bend_by_patch(camera, x_in_cam, patch));
}

std::optional<double> fold_radius(const Camera& camera) {
  if (camera.model == CameraModel::fisheye) {
    const double fold_rad = fisheye_fold_rad(camera);
    return fold_rad < 0.5 * std::numbers::pi ? std::optional(std::tan(fold_rad)) : std::nullopt;
  }
  if (!is_on_unit_plane(camera.model)) return std::nullopt;
  const double fold = radial_fold(coefficients(camera));
  return std::isfinite(fold) ? std::optional(fold) : std::nullopt;
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

Eigen::Vector2d focal_on_axis_px(const Camera& camera) {
  const auto at = project_with_jacobians(camera, Eigen::Vector3d::UnitZ());
  return at ? Eigen::Vector2d(at->d_point(0, 0), at->d_point(1, 1)) : Eigen::Vector2d(camera.fx, camera.fy);
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
