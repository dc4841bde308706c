#include <cmath>

#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"
#include "gps_time.h"
#include "reader_tools.h"

namespace furrow::telemetry {
namespace {

/// The number before ",Lat" in "47.6436873208,Lat".
std::optional<double> labelled(std::string_view cell, std::string_view label) {
  const auto comma = cell.rfind(',');
  if (comma == std::string_view::npos || base::trim(cell.substr(comma + 1)) != label) return std::nullopt;
  return base::parse_double(cell.substr(0, comma));
}

/// `2	296288.242869	[2211]	 3,N	 0,E	75,V	47.64,Lat	16.47,Lon	512.998,Ellh	0.014,
/// 0.013, 0.029	50,Q`
std::optional<std::pair<Sample, bool>> read_line(std::string_view line) {
  const auto cells = base::split(line, '\t');
  constexpr std::size_t kCells = 11;
  if (cells.size() != kCells) return std::nullopt;
  const auto seconds = base::parse_double(cells[1]);
  const std::string_view bracketed = base::trim(cells[2]);
  if (bracketed.size() < 3 || bracketed.front() != '[' || bracketed.back() != ']') return std::nullopt;
  const auto week = base::parse_int(bracketed.substr(1, bracketed.size() - 2));
  const auto latitude = labelled(cells[6], "Lat"), longitude = labelled(cells[7], "Lon"),
             height = labelled(cells[8], "Ellh");
  const auto quality = labelled(cells[10], "Q");
  constexpr double kWeek_s = 604800.0;
  constexpr std::int64_t kLargestWeek = 10000;
  if (!seconds || !(*seconds >= 0.0 && *seconds <= kWeek_s) || !week || *week < 0 || *week > kLargestWeek ||
      !latitude || !longitude || !height)
    return std::nullopt;
  Sample s;
  s.t_utc_ns = reader::utc_from_gps(reader::gps_time(static_cast<int>(*week), *seconds));
  s.latitude_deg = *latitude;
  s.longitude_deg = *longitude;
  s.height_ellipsoid_m = *height;
  s.is_photo = true;
  constexpr double kFixed = 50.0;
  return std::pair(s, quality == kFixed);
}

}  // namespace

Result<Track> read_dji_mrk(std::string_view text, const std::string& name) {
  Track track;
  track.source = name;
  track.format = "dji_mrk";
  std::vector<int> lines;
  std::size_t unread = 0, not_fixed = 0;
  int number = 0, first_unread = 0, first_not_fixed = 0;
  for (const std::string_view line : base::split(text, '\n')) {
    ++number;
    if (base::trim(line).empty()) continue;
    const auto row = read_line(base::trim(line));
    if (!row) {
      if (unread++ == 0) first_unread = number;
      continue;
    }
    if (!row->second && not_fixed++ == 0) first_not_fixed = number;
    track.samples.push_back(row->first);
    lines.push_back(number);
  }
  if (track.samples.empty())
    return Error{"telemetry_empty", name, "no line with week, seconds, Lat, Lon and Ellh", "a DJI .MRK file",
                 ""};
  if (unread > 0) track.warnings.push_back(reader::rows_text(unread, first_unread) + " could not be read");
  if (not_fixed > 0)
    track.warnings.push_back(reader::rows_text(not_fixed, first_not_fixed) + " without a fixed RTK solution");
  track.warnings.emplace_back("the offsets between antenna and sensor in the file are not applied");
  // Every row is a picture of its own: no edges to find.
  reader::log_time_from_utc(track);
  reader::finish_marked(track, lines);
  return track;
}

}  // namespace furrow::telemetry
