#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "camera/other_formats.h"
#include "camera/wide.h"
#include "furrow/base/text.h"
#include "furrow/camera/model_files.h"

namespace furrow::camera {
namespace {

/// What a format can hold.
struct Format {
  CameraFormat format;
  const char* name;                ///< on the command line
  const char* title;               ///< in sentences
  std::size_t plane_coefficients;  ///< of OpenCV's, in its order
  bool fisheye;
};
constexpr std::array<Format, 8> kFormats{{{CameraFormat::mrcal, "mrcal", "mrcal", 12, false},
                                          {CameraFormat::opencv, "opencv", "OpenCV's YAML", 12, true},
                                          {CameraFormat::ros, "ros", "ROS camera_info", 8, true},
                                          {CameraFormat::kalibr, "kalibr", "a Kalibr camchain", 4, true},
                                          {CameraFormat::colmap, "colmap", "COLMAP's cameras.txt", 8, true},
                                          {CameraFormat::metashape, "metashape", "Metashape's XML", 5, true},
                                          {CameraFormat::pix4d, "pix4d", "Pix4D .cam", 5, false},
                                          {CameraFormat::matlab, "matlab", "MATLAB's text", 5, false}}};

const Format& entry(CameraFormat format) {
  const auto found =
      std::find_if(kFormats.begin(), kFormats.end(), [&](const Format& f) { return f.format == format; });
  check(found != kFormats.end(), "camera format without an entry");
  return *found;
}

/// What the format cannot hold of this camera; empty when it holds all.
std::string what_is_lost(const Camera& camera, const Format& format) {
  const std::string title = format.title;
  if (camera.model == CameraModel::fisheye)
    return format.fisheye ? "" : title + " knows no Kannala-Brandt fisheye";
  if (!is_on_unit_plane(camera.model)) {
    return format.format == CameraFormat::mrcal ? ""
                                                : title + " knows no " + model_name(camera.model) + " lens";
  }
  const std::vector<std::string> names = intrinsic_names(camera);
  for (std::size_t i = format.plane_coefficients; i < camera.distortion.size(); ++i) {
    if (camera.distortion[i] != 0.0) return title + " has no room for " + names[4 + i];
  }
  if (format.format == CameraFormat::pix4d && camera.fx != camera.fy)
    return title + " has one focal length, and fx is not fy here";
  return "";
}

std::string written(const Camera& camera, CameraFormat format, const ExportOptions& options) {
  switch (format) {
    case CameraFormat::mrcal:
      return to_mrcal_cameramodel(camera);
    case CameraFormat::opencv:
      return to_opencv_yaml(camera);
    case CameraFormat::ros:
      return to_ros(camera);
    case CameraFormat::kalibr:
      return to_kalibr(camera);
    case CameraFormat::colmap:
      return to_colmap(camera);
    case CameraFormat::metashape:
      return to_metashape(camera);
    case CameraFormat::pix4d:
      return to_pix4d(camera, options.sensor_width_mm);
    case CameraFormat::matlab:
      return to_matlab(camera);
  }
  throw base::CheckFailure("camera format without a writer");
}

/// Largest distance between the two cameras' pixels over a grid on the picture, px; infinite when one of them
/// has none.
double largest_difference_px(const Camera& a, const Camera& b) {
  double worst = 0.0;
  constexpr int kPlaces = 12;
  for (int j = 0; j <= kPlaces; ++j) {
    for (int i = 0; i <= kPlaces; ++i) {
      const auto ray = unproject_ray(a, {(a.width - 1.0) * i / kPlaces, (a.height - 1.0) * j / kPlaces});
      if (!ray) continue;
      const auto in_a = project(a, *ray), in_b = project(b, *ray);
      if (!in_a || !in_b) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, (*in_a - *in_b).norm());
    }
  }
  return worst;
}

Error cannot_hold(const std::string& what, const std::string& hint) {
  return {"camera_export_failed", "camera", what, "a lens this format can hold", hint};
}

}  // namespace

std::optional<CameraFormat> format_from_name(const std::string& name) {
  for (const Format& f : kFormats) {
    if (name == f.name) return f.format;
  }
  return std::nullopt;
}

std::string format_names() {
  std::string out;
  for (const Format& f : kFormats) out += (out.empty() ? "" : ", ") + std::string(f.name);
  return out;
}

Result<std::string> export_camera(const Camera& camera, CameraFormat format, const ExportOptions& options) {
  FURROW_DO(validate(camera));
  check(options.sensor_width_mm > 0.0, "export_camera: the sensor's width must be above 0");
  if (const std::string lost = what_is_lost(camera, entry(format)); !lost.empty()) {
    return cannot_hold(lost,
                       format == CameraFormat::mrcal
                           ? "calibrate with --model splined_stereographic or one of OpenCV's"
                           : "calibrate with a smaller model" +
                                 std::string(format == CameraFormat::pix4d ? " and --square-pixels" : ""));
  }
  const std::string text = written(camera, format, options);
  FURROW_TRY(const Camera back, parse_camera(text, "export"));
  constexpr double kLargestDifferencePx = 1e-6;
  const double difference_px = largest_difference_px(camera, back);
  if (!(difference_px <= kLargestDifferencePx)) {
    return cannot_hold("pixels move by " + base::format_double(difference_px) + " px when it is read back",
                       "");
  }
  return text;
}

}  // namespace furrow::camera
