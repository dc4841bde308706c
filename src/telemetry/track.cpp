#include "furrow/telemetry/track.h"

#include <algorithm>
#include <array>

#include "furrow/base/bytes.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"

namespace furrow::telemetry {
namespace {

constexpr std::string_view kReadable =
    "AirData CSV, PhantomHelp/TXTlogToCSV CSV, DJI video SRT, DJI flight record .txt up to version 12, "
    "RTKLIB .pos, NMEA, GPX or DJI .MRK";
/// How much of a file is looked at to tell its format: more than the widest header (191 columns, 4 kB).
constexpr std::size_t kHeadBytes = 16384;

std::string_view without_byte_order_mark(std::string_view bytes) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (bytes.starts_with(kMark)) bytes.remove_prefix(kMark.size());
  return bytes;
}

/// How many of `names` occur in the header, whatever the case.
template <std::size_t N>
std::size_t count_in(std::string_view header, const std::array<std::string_view, N>& names) {
  return static_cast<std::size_t>(std::count_if(names.begin(), names.end(), [&](std::string_view name) {
    return header.find(name) != std::string_view::npos;
  }));
}

std::string csv_header(std::string_view head) {
  if (head.starts_with("sep=")) head.remove_prefix(std::min(head.find('\n'), head.size() - 1) + 1);
  return base::to_lower(head.substr(0, head.find('\n')));
}

/// Three of a format's own names identify it even when one that is needed is missing or misspelt: the reader
/// then says which.
constexpr std::size_t kTellingNames = 3;

bool looks_like_airdata(const std::string& header) {
  static constexpr std::array<std::string_view, 8> kNames = {
      "time(millisecond)",       "datetime(utc)",   "height_above_takeoff", "height_sonar",
      "altitude_above_sealevel", "compass_heading", "gimbal_pitch",         "flycstate"};
  return count_in(header, kNames) >= kTellingNames;
}

bool looks_like_phantomhelp(const std::string& header) {
  static constexpr std::array<std::string_view, 8> kNames = {
      "osd.flytime", "osd.latitude", "osd.longitude", "osd.height",
      "osd.yaw",     "gimbal.pitch", "home.latitude", "custom.updatetime"};
  return count_in(header, kNames) >= kTellingNames;
}

/// A flight record starts with a small little-endian offset (so with zeros in bytes 5 to 7) and a version.
bool looks_like_flight_record(std::string_view bytes) {
  constexpr std::size_t kPrefix = 12;
  constexpr int kLargestVersion = 64;
  return bytes.size() > kPrefix && bytes[5] == 0 && bytes[6] == 0 && bytes[7] == 0 && bytes[10] > 0 &&
         bytes[10] <= kLargestVersion;
}

/// A name for a format that is recognised and not read.
std::optional<std::string> recognised(std::string_view head) {
  if (head.starts_with("ULog\x01\x12\x35")) return "a PX4 ULog";
  // Eight bytes of a station's clock, big-endian microseconds, before each message of MAVLink 1 or 2.
  if (head.size() > 9 && head[0] == 0 && (head[8] == '\xFE' || head[8] == '\xFD'))
    return "a MAVLink log (.tlog)";
  if (head.starts_with("\xA3\x95")) return "an ArduPilot DataFlash log";
  if (head.starts_with("\xFF\xD8\xFF")) return "a JPEG picture";
  if (head.starts_with("PK\x03\x04")) return "a zip archive (KMZ, or a spreadsheet)";
  if (head.size() > 8 && head.substr(4, 4) == "ftyp") return "a video";
  if (head.find("<kml") != std::string_view::npos) return "a KML document";
  if (head.find("Clock:offsetTime") != std::string_view::npos) return "a DatCon CSV";
  return std::nullopt;
}

std::string describe(std::string_view head) {
  if (std::any_of(head.begin(), head.end(), base::is_control)) return "bytes that are no text";
  const std::string_view line = base::trim(head.substr(0, head.find('\n')));
  constexpr std::size_t kShown = 80;
  return "a first line '" + std::string(line.substr(0, kShown)) + (line.size() > kShown ? "...'" : "'");
}

}  // namespace

Result<Track> parse_track(std::string_view bytes, const std::string& name) {
  const std::string_view text = without_byte_order_mark(bytes);
  if (base::trim(text).empty()) return Error{"telemetry_empty", name, "an empty file", "a flight log", ""};
  const std::string_view head = text.substr(0, kHeadBytes);
  if (const auto known = recognised(head))
    return Error{"telemetry_format_unknown", name, *known, std::string(kReadable), ""};
  if (looks_like_flight_record(bytes)) return read_dji_txt(bytes, name);
  if (head.find("<gpx") != std::string_view::npos) return read_gpx(text, name);
  if (head.find("-->") != std::string_view::npos) return read_dji_srt(text, name);
  if (head.starts_with("$G")) return read_nmea(text, name);
  if (head.starts_with('%')) return read_rtklib_pos(text, name);
  if (head.find(",Ellh") != std::string_view::npos) return read_dji_mrk(text, name);
  const std::string header = csv_header(head);
  if (looks_like_airdata(header)) return read_airdata(text, name);
  if (looks_like_phantomhelp(header)) return read_phantomhelp(text, name);
  return Error{"telemetry_format_unknown", name, describe(head), std::string(kReadable), ""};
}

Result<Track> read_track(const std::filesystem::path& file) {
  FURROW_TRY(const std::string bytes, base::read_file(file));
  return parse_track(bytes, file.filename().string());
}

}  // namespace furrow::telemetry
