#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Reads a camera model, finding the format from the content: mrcal `.cameramodel`, OpenCV YAML
/// (`camera_matrix` and `distortion_coefficients`, also as `K`/`D`; ROS camera_info has the same keys;
/// `distortion_model: equidistant` is the fisheye), Kalibr camchain, COLMAP cameras.txt, Metashape XML, Pix4D
/// .cam, MATLAB's text, a DJI picture that states its DewarpData, or Furrow's `calibration.json`. Errors:
/// file_*, camera_format_unknown, camera_file_invalid (names the line or key), camera_model_unsupported.
Result<Camera> read_camera(const std::filesystem::path& file);

/// The same from a file's text; `name` stands in messages.
Result<Camera> parse_camera(const std::string& text, const std::string& name);

/// mrcal's name of the lens model: "LENSMODEL_OPENCV8", or with a splined model's grid. Not for a fisheye.
std::string mrcal_lensmodel(const Camera& camera);

/// mrcal's format at full double precision (extrinsics identity). `optimization_inputs` is what
/// calib::mrcal_optimization_inputs() makes, or empty. The camera must not be a fisheye, which mrcal lacks.
std::string to_mrcal_cameramodel(const Camera& camera, const std::string& optimization_inputs = "");
/// OpenCV FileStorage YAML: image_width, image_height, camera_matrix, distortion_model,
/// distortion_coefficients. Pinhole, OpenCV's models and the fisheye only.
std::string to_opencv_yaml(const Camera& camera);

/// Files of other programs.
enum class CameraFormat {
  mrcal,   ///< .cameramodel; all but the fisheye
  opencv,  ///< FileStorage YAML
  ros,     ///< camera_info YAML: plumb_bob, rational_polynomial or equidistant
  kalibr,  ///< camchain YAML: pinhole with radtan (no k3) or equidistant
  colmap,  ///< cameras.txt: PINHOLE, OPENCV, FULL_OPENCV, OPENCV_FISHEYE; its pixel (0.5, 0.5) is our (0, 0)
  metashape,  ///< XML: frame (k1 k2 k3 p1 p2) or fisheye; half a pixel off as well
  pix4d,      ///< .cam: k1 k2 k3 t1 t2 and one focal length, in millimetres
  matlab,     ///< text as MATLAB prints it: k1 k2 k3 p1 p2; its pixel (1, 1) is our (0, 0)
};
std::optional<CameraFormat> format_from_name(const std::string& name);
/// All names, for messages.
std::string format_names();

struct ExportOptions {
  /// Width of the sensor for formats in millimetres (Pix4D); pixels do not depend on it. The default is a
  /// full-frame sensor's.
  double sensor_width_mm = 36.0;
};

/// The camera in another program's format, checked: the text is read back and must project to the same pixels
/// within 1e-6 px all over the picture. Errors: camera_export_failed (with what the format cannot hold),
/// camera_invalid.
Result<std::string> export_camera(const Camera& camera, CameraFormat format,
                                  const ExportOptions& options = {});

}  // namespace furrow::camera
