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

/// DJI flight record (.txt), versions 1 to 12. From 13 on the records are encrypted with keys that only DJI's
/// service gives out: the error says how to export them. Versions 7 to 12 are scrambled by a known key; no
/// file of those was there to test with, so a result that makes no sense is refused. | height_takeoff_m  |
/// OSD height, 0.1 m: barometric, zero at take-off                                      | | height_vps_m |
/// OSD vision height while its "works" bit is set, below the byte's 25.5 m ceiling      | | not read | HOME
/// altitude: pressure altitude                                                     | | yaw, pitch, roll  |
/// OSD, 0.1 deg; gimbal_* from GIMBAL, 0.1 deg, negative below the horizon              | | t_log_ns | OSD
/// fly time, 0.1 s, from the start of the motors; its wrap at 6553.6 s undone       | | t_utc_ns          |
/// t_log_ns + median of (CUSTOM time - fly time); CUSTOM is UTC milliseconds            | | is_photo | where
/// CUSTOM's camera flag rises                                                     |
Result<Track> read_dji_txt(std::string_view bytes, const std::string& name);

/// RTKLIB position file (.pos), degrees or degrees, minutes, seconds; GPST or UTC; calendar or week and
/// seconds. | height_ellipsoid_m, height_geoid_m | height, by the header's "ellipsoidal" or "geodetic" | |
/// t_utc_ns, t_log_ns                 | time, GPST less its leap seconds; from the first row                |
Result<Track> read_rtklib_pos(std::string_view text, const std::string& name);

/// NMEA 0183: GGA for the position, RMC and ZDA for the date. Lines with a wrong checksum are left out.
/// | height_geoid_m     | GGA field 9, over the receiver's geoid | | height_ellipsoid_m | fields 9 + 11 of an
/// RTK fixed or float solution (quality 4, 5)                      | | speed_mps          | RMC, knots | |
/// t_utc_ns, t_log_ns | UTC; from the first row. Without RMC or ZDA there is no date and no UTC             |
Result<Track> read_nmea(std::string_view text, const std::string& name);

/// GPX 1.0 and 1.1 tracks.
/// | height_geoid_m     | ele, which GPX leaves undefined and most programs fill from the receiver's geoid |
/// | speed_mps          | speed, m/s | | t_utc_ns, t_log_ns | time; points that share a second are spread
/// evenly to the next one                   |
Result<Track> read_gpx(std::string_view text, const std::string& name);

/// DJI .MRK: one line per picture of an RTK drone.
/// | height_ellipsoid_m | Ellh | | t_utc_ns, t_log_ns | GPS week and seconds less leap seconds; from the
/// first row                           | | is_photo           | every row | The offset from antenna to sensor
/// stands in the file and is not applied: DJI does not say to which of the two the position belongs.
Result<Track> read_dji_mrk(std::string_view text, const std::string& name);

}  // namespace furrow::telemetry
