#pragma once
#include <filesystem>
#include <string>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Reads a camera model, finding the format from the content: mrcal `.cameramodel`, OpenCV YAML
/// (`camera_matrix` and `distortion_coefficients`, also as `K`/`D`), or Furrow's `calibration.json`. Errors:
/// file_*, camera_format_unknown, camera_file_invalid (names the line or key), camera_model_unsupported.
Result<Camera> read_camera(const std::filesystem::path& file);

/// The same from a file's text; `name` stands in messages.
Result<Camera> parse_camera(const std::string& text, const std::string& name);

/// mrcal's format at full double precision (extrinsics identity).
std::string to_mrcal_cameramodel(const Camera& camera);
/// OpenCV FileStorage YAML: image_width, image_height, camera_matrix, distortion_model,
/// distortion_coefficients.
std::string to_opencv_yaml(const Camera& camera);

}  // namespace furrow::camera
