#include <cmath>

#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"
#include "gps_time.h"
#include "reader_tools.h"

namespace furrow::telemetry {
namespace {

/// What the '%' lines say about the columns.
struct Layout {
  bool found = false;
  bool gps_time = true;     ///< GPST; else UTC
  bool local_time = false;  ///< JST
  bool dms = false;         ///< latitude and longitude in three numbers each
  bool geodetic = false;    ///< heights over the geoid
  bool cartesian = false;   ///< x, y, z instead of latitude, longitude, height
};

void read_header_line(std::string_view line, Layout& layout) {
  if (line.find("height=") != std::string_view::npos)
    layout.geodetic = line.find("/geodetic") != std::string_view::npos;
  if (line.find("ecef(m)") != std::string_view::npos) layout.cartesian = true;
  if (line.find("latitude(") == std::string_view::npos) return;
  layout.found = true;
  layout.gps_time = line.find("GPST") != std::string_view::npos;
  layout.local_time = line.find("JST") != std::string_view::npos;
  layout.dms = line.find("latitude(d'\")") != std::string_view::npos;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; at < line.size();) {
    const auto begin = line.find_first_not_of(" \t\r", at);
    if (begin == std::string_view::npos) break;
    const auto end = std::min(line.find_first_of(" \t\r", begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    at = end;
  }
  return words;
}

/// "2005/04/02 00:00:00.000" or "1316 518400.000".
std::optional<base::Nanoseconds> time_of(std::string_view first, std::string_view second) {
  if (first.find('/') != std::string_view::npos)
    return base::parse_date_time(std::string(first) + " " + std::string(second));
  const auto week = base::parse_int(first);
  const auto seconds = base::parse_double(second);
  constexpr std::int64_t kLargestWeek = 10000;
  constexpr double kWeek_s = 604800.0;
  if (!week || !seconds || *week < 0 || *week > kLargestWeek || !(*seconds >= 0.0 && *seconds <= kWeek_s))
    return std::nullopt;
  return reader::gps_time(static_cast<int>(*week), *seconds);
}

/// Degrees, minutes and seconds; the sign stands before the degrees, "-0" included.
double from_dms(std::string_view d, std::string_view m, std::string_view s) {
  const double degrees = base::parse_double(d).value_or(kMissing);
  const double rest =
      base::parse_double(m).value_or(kMissing) / 60.0 + base::parse_double(s).value_or(kMissing) / 3600.0;
  return d.starts_with('-') ? degrees - rest : degrees + rest;
}

struct Row {
  Sample sample;
  bool fixed = false;
};

std::optional<Row> read_row(std::string_view line, const Layout& layout) {
  const auto words = words_of(line);
  const std::size_t height = layout.dms ? 8 : 4;
  if (words.size() < height + 2) return std::nullopt;
  const auto time = time_of(words[0], words[1]);
  if (!time) return std::nullopt;
  Row row;
  Sample& s = row.sample;
  s.t_utc_ns = layout.gps_time ? reader::utc_from_gps(*time) : *time;
  s.latitude_deg =
      layout.dms ? from_dms(words[2], words[3], words[4]) : base::parse_double(words[2]).value_or(kMissing);
  s.longitude_deg =
      layout.dms ? from_dms(words[5], words[6], words[7]) : base::parse_double(words[3]).value_or(kMissing);
  (layout.geodetic ? s.height_geoid_m : s.height_ellipsoid_m) =
      base::parse_double(words[height]).value_or(kMissing);
  row.fixed = words[height + 1] == "1";
  return row;
}

}  // namespace

Result<Track> read_rtklib_pos(std::string_view text, const std::string& name) {
  Track track;
  track.source = name;
  track.format = "rtklib_pos";
  Layout layout;
  std::vector<int> lines;
  std::size_t unread = 0, not_fixed = 0;
  int number = 0, first_unread = 0, first_not_fixed = 0;
  for (const std::string_view line : base::split(text, '\n')) {
    ++number;
    if (line.starts_with('%')) read_header_line(line, layout);
    if (line.starts_with('%') || base::trim(line).empty()) continue;
    const auto row = layout.found ? read_row(line, layout) : std::nullopt;
    if (!row) {
      if (unread++ == 0) first_unread = number;
      continue;
    }
    if (!row->fixed && not_fixed++ == 0) first_not_fixed = number;
    track.samples.push_back(row->sample);
    lines.push_back(number);
  }
  if (layout.cartesian)
    return Error{"telemetry_format_unknown", name, "an RTKLIB file with x, y, z",
                 "latitude, longitude and height", "Write it again with out-solformat=llh."};
  if (!layout.found)
    return Error{"telemetry_column_missing", name, "no '%' line that names latitude and longitude",
                 "RTKLIB's header", ""};
  if (layout.local_time) return Error{"telemetry_format_unknown", name, "times in JST", "GPST or UTC", ""};
  if (track.samples.empty())
    return Error{"telemetry_empty", name, "no row with a time and a position", "at least one", ""};
  if (unread > 0) track.warnings.push_back(reader::rows_text(unread, first_unread) + " could not be read");
  if (not_fixed > 0)
    track.warnings.push_back(reader::rows_text(not_fixed, first_not_fixed) +
                             " without a fixed solution (Q is not 1)");
  reader::log_time_from_utc(track);
  reader::finish(track, lines);
  return track;
}

}  // namespace furrow::telemetry
