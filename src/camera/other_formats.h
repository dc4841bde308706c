#pragma once
#include <string>

#include "furrow/base/value.h"
#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Kalibr's camchain: `cam0` with camera_model pinhole and distortion_model radtan, equidistant or none.
Result<Camera> from_kalibr(const base::Value& tree, const std::string& name);

/// Whether the first line that is no comment reads "ID MODEL WIDTH HEIGHT ..." with one of COLMAP's model
/// names.
bool looks_like_colmap(const std::string& text);
/// The first camera of a COLMAP cameras.txt.
Result<Camera> from_colmap(const std::string& text, const std::string& name);

std::string to_ros(const Camera& camera);
std::string to_kalibr(const Camera& camera);
std::string to_colmap(const Camera& camera);

/// A `<calibration>` of Metashape (PhotoScan) XML: projection frame or fisheye. Its (0.5, 0.5) is our (0, 0),
/// its principal point is counted from the picture's middle, its p1 and p2 are OpenCV's p2 and p1.
Result<Camera> from_metashape(const std::string& text, const std::string& name);
std::string to_metashape(const Camera& camera);

/// Pix4D's internal camera parameters (.cam): millimetres from the corner of the sensor, one focal length.
/// The file does not say how many pixels the sensor has; ours adds a comment that does.
bool looks_like_pix4d(const std::string& text);
Result<Camera> from_pix4d(const std::string& text, const std::string& name);
std::string to_pix4d(const Camera& camera, double sensor_width_mm);

/// What MATLAB prints of cameraIntrinsics or cameraParameters; its (1, 1) is our (0, 0).
bool looks_like_matlab(const std::string& text);
Result<Camera> from_matlab(const std::string& text, const std::string& name);
std::string to_matlab(const Camera& camera);

/// The camera that a DJI picture states in its XMP (`DewarpData` or `DewarpDataK6`, origin the picture's
/// middle).
Result<Camera> from_dji_picture(const std::string& bytes, const std::string& name);

}  // namespace furrow::camera
