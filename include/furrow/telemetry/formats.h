#pragma once
#include <string>
#include <string_view>

#include "furrow/telemetry/track.h"

namespace furrow::telemetry {

/// One reader per format. Each takes the file's bytes and a name for messages, and settles sign, unit, zero
/// and clock as its table says; docs/telemetry.md tells where each line comes from. Errors: as parse_track().

/// AirData CSV export of a DJI (or other) flight record. Units are read from the header, never assumed.
/// | height_takeoff_m     | height_above_takeoff: barometric, zero at take-off | | height_vps_m         |
/// height_sonar where it can be trusted; NaN where it repeats its last value         | | height_terrain_msl_m
/// | altitude_above_seaLevel: terrain database + barometer                             | | speed_mps | speed
/// | | yaw_deg, gimbal_*    | clockwise from north; pitch negative below the horizon; constant 0 means
/// unknown  | | t_log_ns             | time(millisecond), from the start of the log | | t_utc_ns |
/// time(millisecond) + the constant that fits most 1-second datetime(utc) readings   | | is_photo | where
/// isPhoto rises from 0 to 1                                                   |
Result<Track> read_airdata(std::string_view text, const std::string& name);

/// PhantomHelp / TXTlogToCSV export ("DJIFlightRecord" CSV), and dji-log-parser's with the same names.
/// | height_takeoff_m  | OSD.height: barometric, zero at take-off; [ft], [m], or metres without a unit | |
/// height_vps_m      | OSD.vpsHeight while OSD.isSwaveWork; without that column as read_airdata()           |
/// | not read          | OSD.altitude: pressure altitude, wrong by tens of metres | | speed_mps         |
/// OSD.hSpeed                                                                           | | yaw_deg, gimbal_*
/// | OSD.yaw, GIMBAL.*: clockwise from north, negative below the horizon                  | | t_log_ns |
/// OSD.flyTime [s]; rows on the ground before it runs are dropped                       | | t_local_ns |
/// CUSTOM.date + CUSTOM.updateTime in the controller's zone                             | | t_utc_ns |
/// CUSTOM.dateTime, which dji-log-parser writes                                         | | is_photo | where
/// CAMERA.isPhoto (or CUSTOM.isPhoto) rises                                       |
Result<Track> read_phantomhelp(std::string_view text, const std::string& name);

/// DJI video subtitles, dialects A to H and J of docs/telemetry.md; D and the goggles' I hold no position.
/// | height_takeoff_m    | BAROMETER, Hb, H or rel_alt: barometric, zero at take-off, m | | not read |
/// [altitude: x] (no known zero), abs_alt (rel_alt plus a constant), HOME's height,   | | | the third number
/// of GPS(lon,lat,n) (satellites)                                    | | latitude, longitude | (lon, lat) in
/// A and B, (lat, lon) in C, by name in the others; 0, 0 is no fix      | | gimbal_*            | G.PRY
/// (pitch, roll, yaw), gb_*: negative below the horizon                         | | t_log_ns            |
/// start of the cue: time in the video                                                | | t_local_ns | wall
/// clock, aircraft local time                                                    |
Result<Track> read_dji_srt(std::string_view text, const std::string& name);

}  // namespace furrow::telemetry
