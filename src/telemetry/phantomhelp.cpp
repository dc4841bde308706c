#include <cmath>

#include "furrow/base/csv.h"
#include "furrow/base/text.h"
#include "furrow/stats/robust.h"
#include "furrow/telemetry/formats.h"
#include "reader_tools.h"
#include "sonar.h"

namespace furrow::telemetry {
namespace {

using reader::Column;
using reader::Quantity;

/// The vision height is one byte in decimetres: 25.5 m is its ceiling and its "nothing seen".
constexpr double kVisionCeiling_m = 25.4;

struct Columns {
  std::optional<Column> fly_time, date, time, utc, swave, photo, video;
  std::vector<std::pair<std::optional<Column>, double Sample::*>> numbers;
};

Result<Columns> find_columns(const base::CsvTable& table) {
  Columns c;
  FURROW_TRY(c.fly_time,
             reader::find_first_column(table, {"OSD.flyTime [s]", "OSD.flyTime"}, Quantity::plain));
  FURROW_TRY(c.date, reader::find_column(table, "CUSTOM.date", Quantity::plain));
  FURROW_TRY(c.time, reader::find_column(table, "CUSTOM.updateTime", Quantity::plain));
  FURROW_TRY(c.utc, reader::find_column(table, "CUSTOM.dateTime", Quantity::plain));
  FURROW_TRY(c.swave, reader::find_column(table, "OSD.isSwaveWork", Quantity::plain));
  FURROW_TRY(c.photo,
             reader::find_first_column(table, {"CAMERA.isPhoto", "CUSTOM.isPhoto"}, Quantity::plain));
  FURROW_TRY(c.video,
             reader::find_first_column(table, {"CAMERA.isVideo", "CUSTOM.isVideo"}, Quantity::plain));
  struct Wanted {
    std::string_view stem;
    Quantity quantity;
    double Sample::*member;
  };
  static constexpr Wanted kWanted[] = {
      {"OSD.latitude", Quantity::plain, &Sample::latitude_deg},
      {"OSD.longitude", Quantity::plain, &Sample::longitude_deg},
      {"OSD.height", Quantity::length, &Sample::height_takeoff_m},
      {"OSD.vpsHeight", Quantity::length, &Sample::height_vps_m},
      {"OSD.hSpeed", Quantity::speed, &Sample::speed_mps},
      {"OSD.yaw", Quantity::plain, &Sample::yaw_deg},
      {"OSD.pitch", Quantity::plain, &Sample::pitch_deg},
      {"OSD.roll", Quantity::plain, &Sample::roll_deg},
      {"GIMBAL.yaw", Quantity::plain, &Sample::gimbal_heading_deg},
      {"GIMBAL.pitch", Quantity::plain, &Sample::gimbal_pitch_deg},
      {"GIMBAL.roll", Quantity::plain, &Sample::gimbal_roll_deg},
  };
  for (const Wanted& wanted : kWanted) {
    FURROW_TRY(const auto column, reader::find_column(table, wanted.stem, wanted.quantity));
    c.numbers.emplace_back(column, wanted.member);
  }
  return c;
}

/// "12/29/2015" and "7:05:48.123 PM" (or a 24-hour time, or an ISO date) as one clock reading.
std::optional<base::Nanoseconds> parse_local(std::string_view date, std::string_view time) {
  const auto parts = base::split(base::trim(date), '/');
  std::string iso(date);
  if (parts.size() == 3)
    iso = std::string(parts[2]) + "-" + std::string(parts[0]) + "-" + std::string(parts[1]);
  std::string clock = base::to_lower(base::trim(time));
  base::Nanoseconds half_day_ns = 0;
  if (clock.ends_with("am") || clock.ends_with("pm")) {
    constexpr base::Nanoseconds kHalfDay_ns = base::Nanoseconds{12} * 3600 * base::kNanosecondsPerSecond;
    const bool twelve = clock.starts_with("12:");
    if (clock.ends_with("pm") && !twelve) half_day_ns = kHalfDay_ns;
    if (clock.ends_with("am") && twelve) half_day_ns = -kHalfDay_ns;
    clock = base::trim(std::string_view(clock).substr(0, clock.size() - 2));
  }
  const auto t = base::parse_date_time(iso + " " + clock);
  if (!t) return std::nullopt;
  return *t + half_day_ns;
}

struct Offset {
  base::Nanoseconds median_ns = 0;
  double sigma_s = 0.0;
};

/// Middle of `differences_ns` and their robust spread.
std::optional<Offset> median_offset(const std::vector<base::Nanoseconds>& differences_ns) {
  if (differences_ns.empty()) return std::nullopt;
  // Seconds from the first one: a double keeps the nanoseconds.
  std::vector<double> from_first_s;
  from_first_s.reserve(differences_ns.size());
  for (const base::Nanoseconds d : differences_ns)
    from_first_s.push_back(base::ns_to_seconds(d - differences_ns.front()));
  return Offset{differences_ns.front() + base::seconds_to_ns(stats::median(from_first_s)),
                stats::mad_sigma(from_first_s)};
}

}  // namespace

Result<Track> read_phantomhelp(std::string_view text, const std::string& name) {
  FURROW_TRY(const base::CsvTable table, reader::parse_log_csv(text, name));
  FURROW_DO(reader::require_columns(table, {"OSD.flyTime", "OSD.latitude", "OSD.longitude", "OSD.height"},
                                    "PhantomHelp / TXTlogToCSV"));
  FURROW_TRY(const Columns columns, find_columns(table));
  Track track;
  track.source = name;
  track.format = "phantomhelp";
  track.warnings = table.warnings;
  reader::Numbers numbers(table);
  std::vector<base::Nanoseconds> local_less_log_ns, utc_less_log_ns;
  std::vector<int> lines;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const double time_s = numbers.at(row, columns.fly_time);
    if (!(std::abs(time_s) * 1000.0 < reader::kLongestLog_ms)) continue;
    Sample sample;
    sample.t_log_ns = base::seconds_to_ns(time_s);
    for (const auto& [column, member] : columns.numbers) sample.*member = numbers.at(row, column);
    if (columns.swave && !reader::flag_at(table, row, columns.swave)) sample.height_vps_m = kMissing;
    sample.is_photo = reader::flag_at(table, row, columns.photo);
    sample.is_video = reader::flag_at(table, row, columns.video);
    const auto& cells = table.rows[row];
    if (columns.date && columns.time)
      if (const auto t = parse_local(cells[columns.date->index], cells[columns.time->index]))
        local_less_log_ns.push_back(*t - sample.t_log_ns);
    if (columns.utc)
      if (const auto t = base::parse_date_time(cells[columns.utc->index]))
        utc_less_log_ns.push_back(*t - sample.t_log_ns);
    track.samples.push_back(sample);
    lines.push_back(table.lines[row]);
  }
  for (std::string& warning : numbers.warnings()) track.warnings.push_back(std::move(warning));
  if (track.samples.empty())
    return Error{"telemetry_empty", name,
                 std::to_string(table.rows.size()) + " rows, none with a flight time", "at least one row",
                 ""};
  const auto local = median_offset(local_less_log_ns);
  const auto utc = median_offset(utc_less_log_ns);
  for (Sample& sample : track.samples) {
    if (local) sample.t_local_ns = sample.t_log_ns + local->median_ns;
    if (utc) sample.t_utc_ns = sample.t_log_ns + utc->median_ns;
  }
  if (utc) track.utc_sigma_s = utc->sigma_s;
  if (columns.date && columns.time && !local)
    track.warnings.push_back(
        "no row has a readable date and time (a spreadsheet program cuts 'updateTime' to minutes); only the "
        "flight time is used");
  reader::clear_constant_gimbal(track);
  reader::finish(track, lines);
  distrust_held_sonar(track, columns.swave ? SonarRule{.ceiling_m = kVisionCeiling_m} : SonarRule{});
  return track;
}

}  // namespace furrow::telemetry
