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
  /// EXIF FocalLengthIn35mmFilm: the nominal lens, not a calibration; NaN when absent or 0.
  double focal_length_35mm_mm = kMissing;
  std::vector<std::string> warnings;
};

/// Reads EXIF and XMP (drone-dji, Pix4D's Camera) of a picture. Errors: file_missing, picture_unreadable. A
/// picture without metadata is no error. Safe to call from several threads; writes nothing, neither to the
/// disk
/// (.aux.xml) nor to stderr.
/// | latitude, longitude | drone-dji GpsLatitude, GpsLongitude (or GpsLongtitude), else EXIF GPS | |
/// height_takeoff_m    | drone-dji RelativeAltitude: barometric, zero at take-off | | height_ellipsoid_m  |
/// drone-dji AbsoluteAltitude with RtkFlag 50 only: else it is pressure altitude       | | gimbal_* |
/// drone-dji Gimbal*Degree, -90 down; else Camera:Pitch - 90 (Pix4D counts from nadir) | | yaw, pitch, roll
/// | drone-dji Flight*Degree                                                             | | t_utc_ns |
/// drone-dji UTCAtExposure, else EXIF GPSDateStamp + GPSTimeStamp                      | | t_camera_local_ns
/// | EXIF DateTimeOriginal, whole seconds                                                |
Result<Shot> read_shot(const std::filesystem::path& image);

/// The same shots with the folder's name in front of every shot_id that occurs twice ("left/DJI_0001"), and,
/// should that not be enough, a number behind.
std::vector<Shot> with_unique_ids(std::vector<Shot> shots);

}  // namespace furrow::telemetry
