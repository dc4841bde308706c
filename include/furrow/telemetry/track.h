#pragma once
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/base/time.h"

namespace furrow::telemetry {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

/// One row of a log, in Furrow's units and signs; NaN where the log says nothing. Sign, unit, zero and clock
/// are settled by the reader.
struct Sample {
  /// Since the start of the log.
  base::Nanoseconds t_log_ns = 0;
  /// Interpolated inside the log's own resolution.
  std::optional<base::Nanoseconds> t_utc_ns;
  /// Wall clock of the aircraft or its controller, in a zone that nobody names.
  std::optional<base::Nanoseconds> t_local_ns;
  double latitude_deg = kMissing;  ///< WGS84
  double longitude_deg = kMissing;
  double height_takeoff_m = kMissing;  ///< barometric, above the take-off point
  double height_vps_m = kMissing;      ///< sonar or vision, surface below the aircraft; NaN when out of range
  /// A map's terrain height plus height_takeoff_m (AirData's "above sea level"): no measurement of its own.
  double height_terrain_msl_m = kMissing;
  double height_ellipsoid_m = kMissing;  ///< only from a source that says so (RTK, PPK)
  double height_geoid_m = kMissing;      ///< GNSS, above the receiver's own coarse geoid ("mean sea level")
  double speed_mps = kMissing;           ///< over ground
  /// Aircraft: heading clockwise from north, nose up +, right wing down +.
  double yaw_deg = kMissing, pitch_deg = kMissing, roll_deg = kMissing;
  double gimbal_heading_deg = kMissing;  ///< clockwise from north
  double gimbal_pitch_deg = kMissing;    ///< negative below the horizon
  double gimbal_roll_deg = kMissing;
  bool is_photo = false;  ///< the log marks a picture taken here: true at one row per picture
  bool is_video = false;  ///< the log says that a video is being recorded
};

/// A whole log.
struct Track {
  std::string source;  ///< file name
  std::string format;  ///< "airdata", "phantomhelp", "dji_srt", ...
  /// Dialect inside the format, where there are several; letters as in docs/telemetry.md.
  std::string variant;
  std::vector<Sample> samples;  ///< by t_log_ns, strictly increasing
  /// One sigma of the constant between t_log_ns and t_utc_ns, from the file's own resolution; NaN without
  /// UTC.
  double utc_sigma_s = kMissing;
  std::vector<std::string> warnings;  ///< what was odd and what was done about it, with line numbers
};

/// Reads a log; the format is found from the content, never from the name (formats.h has the readers
/// themselves). Errors: file_*, telemetry_format_unknown (lists what can be read), telemetry_column_missing,
/// telemetry_unit_unknown, telemetry_empty, csv_*.
Result<Track> read_track(const std::filesystem::path& file);
/// The same for bytes in memory; `name` stands in messages.
Result<Track> parse_track(std::string_view bytes, const std::string& name);

}  // namespace furrow::telemetry
