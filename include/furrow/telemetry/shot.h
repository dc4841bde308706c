#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/telemetry/track.h"

namespace furrow::telemetry {

/// One exposure: picture, clock reading, name.
struct Shot {
  std::string shot_id;  ///< file stem; made unique with its folder when two are equal
  std::filesystem::path image;
  int width = 0, height = 0;  ///< px; 0 when unreadable
  /// From the picture's own metadata; NaN or nothing where it says nothing. `t_log_ns` is unused.
  Sample metadata;
  /// DateTimeOriginal, in the camera's local time without a zone.
  std::optional<base::Nanoseconds> t_camera_local_ns;
  std::string camera_model;  ///< EXIF Model
  std::vector<std::string> warnings;
};

/// Reads EXIF and XMP (drone-dji) of a picture. Errors: file_missing, picture_unreadable. A picture without
/// metadata is no error.
Result<Shot> read_shot(const std::filesystem::path& image);

}  // namespace furrow::telemetry
