#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/base/time.h"

namespace furrow::telemetry {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// One row of a log, in Furrow's units and signs; NaN where the log says nothing. Sign, unit, zero and clock
/// are settled by the reader.
struct Sample {
  base::Nanoseconds t_log_ns = 0;             ///< since the start of the log
  std::optional<base::Nanoseconds> t_utc_ns;  ///< interpolated inside the log's own resolution
  double latitude_deg = kMissing;             ///< WGS84
  double longitude_deg = kMissing;
  double height_takeoff_m = kMissing;  ///< barometric, above the take-off point
  double height_vps_m = kMissing;      ///< sonar or vision, surface below the aircraft; NaN when out of range
  double height_terrain_msl_m =
      kMissing;  ///< a map's terrain height plus height_takeoff_m (AirData's "above sea level")
  double height_ellipsoid_m = kMissing;  ///< only from a source that says so (RTK)
  double speed_mps = kMissing;           ///< over ground
  double yaw_deg = kMissing, pitch_deg = kMissing,
         roll_deg = kMissing;            ///< aircraft: heading clockwise from north, nose up +, right down +
  double gimbal_heading_deg = kMissing;  ///< clockwise from north
  double gimbal_pitch_deg = kMissing;    ///< negative below the horizon
  double gimbal_roll_deg = kMissing;
  bool is_photo = false;  ///< the log marks a picture taken here
  bool is_video = false;
};

/// A whole log.
struct Track {
  std::string source;                 ///< file name
  std::string format;                 ///< "airdata", ...
  std::vector<Sample> samples;        ///< by t_log_ns, strictly increasing
  std::vector<std::string> warnings;  ///< what was odd and what was done about it, with line numbers
};

/// Reads a log; the format is found from the content. Errors: file_*, telemetry_format_unknown (lists what
/// can be read), telemetry_column_missing, telemetry_empty.
Result<Track> read_track(const std::filesystem::path& file);

}  // namespace furrow::telemetry
