#include <cmath>

#include "furrow/base/csv.h"
#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"
#include "reader_tools.h"
#include "sonar.h"

namespace furrow::telemetry {
namespace {

using reader::Column;
using reader::Quantity;

/// AirData writes datetime(utc) in whole seconds.
constexpr base::Nanoseconds kDatetimeResolution_ns = base::kNanosecondsPerSecond;
/// The clocks are said to part when more rows than this share lie off the fitted constant by over half a
/// second.
constexpr double kDisagreeingShare = 0.01;

struct Field {
  std::optional<Column> column;
  double Sample::*member;
};

Result<std::vector<Field>> find_fields(const base::CsvTable& table) {
  struct Wanted {
    std::string_view stem;
    Quantity quantity;
    double Sample::*member;
  };
  static constexpr Wanted kWanted[] = {
      {"latitude", Quantity::plain, &Sample::latitude_deg},
      {"longitude", Quantity::plain, &Sample::longitude_deg},
      {"height_above_takeoff", Quantity::stated_length, &Sample::height_takeoff_m},
      {"height_sonar", Quantity::stated_length, &Sample::height_vps_m},
      {"altitude_above_seaLevel", Quantity::stated_length, &Sample::height_terrain_msl_m},
      {"speed", Quantity::stated_speed, &Sample::speed_mps},
      {"compass_heading", Quantity::plain, &Sample::yaw_deg},
      {"pitch", Quantity::plain, &Sample::pitch_deg},
      {"roll", Quantity::plain, &Sample::roll_deg},
      {"gimbal_heading", Quantity::plain, &Sample::gimbal_heading_deg},
      {"gimbal_pitch", Quantity::plain, &Sample::gimbal_pitch_deg},
      {"gimbal_roll", Quantity::plain, &Sample::gimbal_roll_deg},
  };
  std::vector<Field> fields;
  for (const Wanted& wanted : kWanted) {
    FURROW_TRY(const auto column, reader::find_column(table, wanted.stem, wanted.quantity));
    fields.push_back({column, wanted.member});
  }
  return fields;
}

/// datetime(utc) of every row that has one, beside its time in the log.
using ClockPairs = std::vector<std::pair<base::Nanoseconds, base::Nanoseconds>>;

void set_utc(Track& track, const ClockPairs& pairs) {
  const auto fit = reader::fit_coarse_clock(pairs, kDatetimeResolution_ns);
  if (!fit) {
    track.warnings.push_back("no row has a readable datetime(utc): the log has no UTC");
    return;
  }
  for (Sample& sample : track.samples) sample.t_utc_ns = sample.t_log_ns + fit->offset_ns;
  track.utc_sigma_s = fit->sigma_s;
  if (static_cast<double>(fit->disagree) > kDisagreeingShare * static_cast<double>(pairs.size()))
    track.warnings.push_back("datetime(utc) and time(millisecond) part by over half a second in " +
                             std::to_string(fit->disagree) + " of " + std::to_string(pairs.size()) +
                             " rows; UTC follows the larger group");
}

}  // namespace

Result<Track> read_airdata(std::string_view text, const std::string& name) {
  FURROW_TRY(const base::CsvTable table, reader::parse_log_csv(text, name));
  FURROW_DO(reader::require_columns(
      table, {"time(millisecond)", "datetime(utc)", "latitude", "longitude", "height_above_takeoff"},
      "AirData"));
  FURROW_TRY(const auto fields, find_fields(table));
  FURROW_TRY(const auto time, reader::find_column(table, "time(millisecond)", Quantity::plain));
  FURROW_TRY(const auto datetime, reader::find_column(table, "datetime(utc)", Quantity::plain));
  FURROW_TRY(const auto photo, reader::find_column(table, "isPhoto", Quantity::plain));
  FURROW_TRY(const auto video, reader::find_column(table, "isVideo", Quantity::plain));
  Track track;
  track.source = name;
  track.format = "airdata";
  track.warnings = table.warnings;
  reader::Numbers numbers(table);
  ClockPairs clock;
  std::vector<int> lines;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const double time_ms = numbers.at(row, time);
    if (!(std::abs(time_ms) < reader::kLongestLog_ms)) continue;
    Sample sample;
    sample.t_log_ns = static_cast<base::Nanoseconds>(std::llround(time_ms * 1e6));
    for (const Field& field : fields) sample.*field.member = numbers.at(row, field.column);
    sample.is_photo = reader::flag_at(table, row, photo);
    sample.is_video = reader::flag_at(table, row, video);
    if (const auto t = base::parse_date_time(table.rows[row][datetime->index]))
      clock.emplace_back(sample.t_log_ns, *t);
    track.samples.push_back(sample);
    lines.push_back(table.lines[row]);
  }
  for (std::string& warning : numbers.warnings()) track.warnings.push_back(std::move(warning));
  if (track.samples.empty())
    return Error{"telemetry_empty", name,
                 std::to_string(table.rows.size()) + " rows, none with a time(millisecond)",
                 "at least one row", ""};
  set_utc(track, clock);
  reader::clear_constant_gimbal(track);
  reader::finish(track, lines);
  distrust_held_sonar(track);
  return track;
}

}  // namespace furrow::telemetry
