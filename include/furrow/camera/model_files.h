#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Reads a camera model, finding the format from the content: mrcal `.cameramodel`, OpenCV YAML
/// (`camera_matrix` and `distortion_coefficients`, also as `K`/`D`; ROS camera_info has the same keys),
/// Kalibr camchain, COLMAP cameras.txt, or Furrow's `calibration.json`. Errors: file_*,
/// camera_format_unknown, camera_file_invalid (names the line or key), camera_model_unsupported.
Result<Camera> read_camera(const std::filesystem::path& file);

/// The same from a file's text; `name` stands in messages.
Result<Camera> parse_camera(const std::string& text, const std::string& name);

/// mrcal's format at full double precision (extrinsics identity).
std::string to_mrcal_cameramodel(const Camera& camera);
/// OpenCV FileStorage YAML: image_width, image_height, camera_matrix, distortion_model,
/// distortion_coefficients.
std::string to_opencv_yaml(const Camera& camera);

/// Files of other programs.
enum class CameraFormat {
  mrcal,   ///< .cameramodel
  opencv,  ///< FileStorage YAML
  ros,     ///< camera_info YAML: plumb_bob or rational_polynomial
  kalibr,  ///< camchain YAML: pinhole with radtan; no k3
  colmap,  ///< cameras.txt: PINHOLE, OPENCV or FULL_OPENCV; its pixel (0.5, 0.5) is our (0, 0)
};
std::optional<CameraFormat> format_from_name(const std::string& name);

/// The camera in another program's format, checked: the text is read back and must project to the same pixels
/// within 1e-6 px all over the picture. Errors: camera_export_failed (with what the format cannot hold),
/// camera_invalid.
Result<std::string> export_camera(const Camera& camera, CameraFormat format);

}  // namespace furrow::camera
