#pragma once
#include <string>

#include "furrow/base/value.h"
#include "furrow/camera/camera.h"

namespace furrow::camera {

/// Kalibr's camchain: `cam0` with camera_model pinhole and distortion_model radtan or none.
Result<Camera> from_kalibr(const base::Value& tree, const std::string& name);

/// Whether the first line that is no comment reads "ID MODEL WIDTH HEIGHT ..." with one of COLMAP's model
/// names.
bool looks_like_colmap(const std::string& text);
/// The first camera of a COLMAP cameras.txt.
Result<Camera> from_colmap(const std::string& text, const std::string& name);

}  // namespace furrow::camera
