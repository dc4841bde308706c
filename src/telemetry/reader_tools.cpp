#include "reader_tools.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "furrow/base/text.h"
#include "furrow/stats/robust.h"
#include "furrow/telemetry/sample_fields.h"

namespace furrow::telemetry::reader {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};
constexpr std::array kLengthUnits = {Unit{"feet", kMetresPerFoot}, Unit{"ft", kMetresPerFoot},
                                     Unit{"meters", 1.0}, Unit{"metres", 1.0}, Unit{"m", 1.0}};
constexpr std::array kSpeedUnits = {Unit{"mph", kMpsPerMph},    Unit{"m/s", 1.0},
                                    Unit{"km/h", kMpsPerKmh},   Unit{"kph", kMpsPerKmh},
                                    Unit{"knots", kMpsPerKnot}, Unit{"kts", kMpsPerKnot}};

/// "feet" of "height(feet)" when the column's name starts with `stem`; "" for the bare stem; nothing for
/// another column.
std::optional<std::string> unit_in(std::string_view column, std::string_view stem) {
  if (!column.starts_with(stem)) return std::nullopt;
  const std::string_view rest = base::trim(column.substr(stem.size()));
  if (rest.empty()) return "";
  const bool bracketed =
      (rest.front() == '(' && rest.back() == ')') || (rest.front() == '[' && rest.back() == ']');
  if (!bracketed || rest.size() < 2) return std::nullopt;
  return base::to_lower(base::trim(rest.substr(1, rest.size() - 2)));
}

template <std::size_t N>
std::optional<double> factor_of(const std::array<Unit, N>& units, std::string_view name) {
  for (const Unit& unit : units)
    if (unit.name == name) return unit.factor;
  return std::nullopt;
}

bool stem_is_there(const base::CsvTable& table, std::string_view stem) {
  return std::any_of(table.columns.begin(), table.columns.end(),
                     [&](const std::string& c) { return unit_in(c, stem).has_value(); });
}

}  // namespace

Result<std::optional<Column>> find_column(const base::CsvTable& table, std::string_view stem,
                                          Quantity quantity) {
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const auto unit = unit_in(table.columns[i], stem);
    if (!unit) continue;
    const bool stated = quantity == Quantity::stated_length || quantity == Quantity::stated_speed;
    if (quantity == Quantity::plain || (unit->empty() && !stated)) return std::optional(Column{i, 1.0});
    const bool length = quantity == Quantity::length || quantity == Quantity::stated_length;
    const auto factor = length ? factor_of(kLengthUnits, *unit) : factor_of(kSpeedUnits, *unit);
    if (!factor) {
      const std::string found = "column '" + table.columns[i] + "' has " +
                                (unit->empty() ? std::string("no unit") : "the unit '" + *unit + "'");
      const char* wanted =
          length ? "feet, ft, meters or m in brackets" : "mph, m/s, km/h or knots in brackets";
      return Error{"telemetry_unit_unknown", table.source, found, wanted, ""};
    }
    return std::optional(Column{i, *factor});
  }
  return std::optional<Column>();
}

Result<std::optional<Column>> find_first_column(const base::CsvTable& table,
                                                std::initializer_list<std::string_view> stems,
                                                Quantity quantity) {
  for (const std::string_view stem : stems) {
    FURROW_TRY(const auto column, find_column(table, stem, quantity));
    if (column) return column;
  }
  return std::optional<Column>();
}

Status require_columns(const base::CsvTable& table, const std::vector<std::string_view>& stems,
                       std::string_view format) {
  std::string missing, hint;
  for (const std::string_view stem : stems) {
    if (stem_is_there(table, stem)) continue;
    missing += (missing.empty() ? "" : ", ") + std::string(stem);
    std::vector<std::string> names;
    for (const std::string& column : table.columns)
      names.push_back(column.substr(0, column.find_first_of("([")));
    if (const auto near = base::nearest_name(stem, names))
      hint += "Is '" + *near + "' meant for '" + std::string(stem) + "'? ";
  }
  if (missing.empty()) return Done{};
  if (!hint.empty()) hint.pop_back();
  return Error{"telemetry_column_missing", table.source,
               std::to_string(table.columns.size()) + " columns without " + missing,
               "the columns of an " + std::string(format) + " log", hint};
}

Result<base::CsvTable> parse_log_csv(std::string_view text, const std::string& name) {
  auto table = base::parse_csv(text, name);
  if (table.ok() || table.error().code != "csv_quote") return table;
  const auto last_quote = text.rfind('"');
  const auto line_end = last_quote == std::string_view::npos ? last_quote : text.rfind('\n', last_quote);
  if (line_end == std::string_view::npos) return table;
  auto shorter = base::parse_csv(text.substr(0, line_end + 1), name);
  if (!shorter.ok()) return table;
  shorter->warnings.push_back(
      "the file ends inside a quoted cell: everything from the line of its opening quote on was dropped");
  return shorter;
}

double Numbers::at(std::size_t row, const std::optional<Column>& column) {
  if (!column) return kMissing;
  const std::string& cell = table_.rows[row][column->index];
  if (cell.empty()) return kMissing;
  if (const auto value = base::parse_double(cell)) return *value * column->factor;
  Bad& bad = bad_[column->index];
  if (bad.count++ == 0) {
    bad.first_line = table_.lines[row];
    bad.text = cell.substr(0, 40);
  }
  return kMissing;
}

std::vector<std::string> Numbers::warnings() const {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < bad_.size(); ++i)
    if (bad_[i].count > 0)
      lines.push_back("column '" + table_.columns[i] + "': no number in " +
                      rows_text(static_cast<std::size_t>(bad_[i].count), bad_[i].first_line) + ", there '" +
                      bad_[i].text + "'; taken as unknown");
  return lines;
}

bool flag_at(const base::CsvTable& table, std::size_t row, const std::optional<Column>& column) {
  if (!column) return false;
  const std::string cell = base::to_lower(table.rows[row][column->index]);
  return cell == "1" || cell == "true" || cell == "yes" || cell == "1.0";
}

std::optional<ClockFit> fit_coarse_clock(
    const std::vector<std::pair<base::Nanoseconds, base::Nanoseconds>>& fine_and_coarse,
    base::Nanoseconds resolution_ns) {
  if (fine_and_coarse.empty()) return std::nullopt;
  struct Edge {
    base::Nanoseconds at;
    int step;
  };
  std::vector<Edge> edges;
  edges.reserve(2 * fine_and_coarse.size());
  for (const auto& [fine, coarse] : fine_and_coarse) {
    edges.push_back({coarse - fine, +1});
    edges.push_back({coarse - fine + resolution_ns, -1});
  }
  // An interval ends before another begins at the same place: [a, b) and [b, c) share nothing.
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.at != b.at ? a.at < b.at : a.step < b.step; });
  int depth = 0, deepest = 0;
  std::size_t best = 0;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    depth += edges[i].step;
    if (depth > deepest && edges[i + 1].at > edges[i].at) {
      deepest = depth;
      best = i;
    }
  }
  const base::Nanoseconds width_ns = edges[best + 1].at - edges[best].at;
  ClockFit fit;
  fit.offset_ns = edges[best].at + width_ns / 2;
  fit.sigma_s = base::ns_to_seconds(width_ns) / std::sqrt(12.0);
  for (const auto& [fine, coarse] : fine_and_coarse) {
    const base::Nanoseconds from_middle_ns = fine + fit.offset_ns - coarse - resolution_ns / 2;
    if (std::abs(from_middle_ns) > resolution_ns) ++fit.disagree;
  }
  return fit;
}

namespace {

/// A step of time longer than this has lost rows.
base::Nanoseconds longest_step_ns(const std::vector<Sample>& samples) {
  constexpr double kUsualSteps = 3.0, kLeast_s = 0.5;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < samples.size(); ++i)
    steps_s.push_back(base::ns_to_seconds(samples[i].t_log_ns - samples[i - 1].t_log_ns));
  if (steps_s.empty()) return 0;
  return base::seconds_to_ns(std::max(kLeast_s, kUsualSteps * stats::median(steps_s)));
}

}  // namespace

void keep_photo_edges(std::vector<Sample>& samples, const std::vector<int>& lines,
                      std::vector<std::string>& warnings) {
  const base::Nanoseconds longest_ns = longest_step_ns(samples);
  const auto hole_before = [&](std::size_t i) {
    return i > 0 && samples[i].t_log_ns - samples[i - 1].t_log_ns > longest_ns;
  };
  constexpr base::Nanoseconds kLongMark_ns = base::kNanosecondsPerSecond;
  std::size_t start = 0, long_marks = 0;
  int first_line = 0;
  bool before = false;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const bool now = samples[i].is_photo;
    if (hole_before(i)) before = false;
    if (now && !before) start = i;
    const bool ends = now && (i + 1 == samples.size() || !samples[i + 1].is_photo || hole_before(i + 1));
    if (ends && samples[i].t_log_ns - samples[start].t_log_ns > kLongMark_ns && long_marks++ == 0)
      first_line = lines[start];
    if (now && before) samples[i].is_photo = false;
    before = now;
  }
  if (long_marks > 0)
    warnings.push_back("the photo mark stays on for more than 1 s " + std::to_string(long_marks) +
                       " times (first: line " + std::to_string(first_line) +
                       "); each counts as one picture, taken when it rises");
}

void order_by_time(Track& track, const std::vector<int>& lines) {
  std::vector<Sample> kept;
  kept.reserve(track.samples.size());
  std::size_t dropped = 0;
  int first_line = 0;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    const Sample& sample = track.samples[i];
    if (kept.empty() || sample.t_log_ns > kept.back().t_log_ns) {
      kept.push_back(sample);
      continue;
    }
    kept.back().is_photo = kept.back().is_photo || sample.is_photo;
    if (dropped++ == 0) first_line = lines[i];
  }
  if (dropped > 0)
    track.warnings.push_back(rows_text(dropped, first_line) + " not later than the row before: dropped");
  track.samples = std::move(kept);
}

void clear_impossible_positions(Track& track, const std::vector<int>& lines) {
  std::size_t no_fix = 0, off_earth = 0;
  int first_no_fix = 0, first_off_earth = 0;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    Sample& s = track.samples[i];
    const bool zero = s.latitude_deg == 0.0 && s.longitude_deg == 0.0;
    const bool off = std::abs(s.latitude_deg) > 90.0 || std::abs(s.longitude_deg) > 360.0;
    if (zero && no_fix++ == 0) first_no_fix = lines[i];
    if (off && off_earth++ == 0) first_off_earth = lines[i];
    // Half a position is none.
    if (zero || off || !std::isfinite(s.latitude_deg) || !std::isfinite(s.longitude_deg))
      s.latitude_deg = s.longitude_deg = kMissing;
  }
  if (no_fix > 0)
    track.warnings.push_back("position 0, 0 in " + rows_text(no_fix, first_no_fix) + ": taken as no fix");
  if (off_earth > 0)
    track.warnings.push_back("position off the Earth in " + rows_text(off_earth, first_off_earth) +
                             ": taken as unknown");
}

bool clear_impossible_heights(Sample& sample) {
  constexpr double kHighest_m = 20e3;  // above any zero; no rotor has flown as high
  bool cleared = false;
  for (const auto height : {&Sample::height_takeoff_m, &Sample::height_vps_m, &Sample::height_terrain_msl_m,
                            &Sample::height_ellipsoid_m, &Sample::height_geoid_m}) {
    if (!(std::abs(sample.*height) > kHighest_m)) continue;
    sample.*height = kMissing;
    cleared = true;
  }
  return cleared;
}

void clear_impossible_heights(Track& track, const std::vector<int>& lines) {
  std::size_t count = 0;
  int first_line = 0;
  for (std::size_t i = 0; i < track.samples.size(); ++i) {
    if (clear_impossible_heights(track.samples[i]) && count++ == 0) first_line = lines[i];
  }
  if (count > 0)
    track.warnings.push_back("a height beyond 20 km in " + rows_text(count, first_line) +
                             ": taken as unknown");
}

void clear_constant_gimbal(Track& track) {
  bool any = false;
  for (const Sample& s : track.samples) {
    if (std::isnan(s.gimbal_pitch_deg)) continue;
    if (s.gimbal_pitch_deg != 0.0) return;
    any = true;
  }
  if (!any) return;
  for (Sample& s : track.samples) s.gimbal_pitch_deg = s.gimbal_roll_deg = kMissing;
  track.warnings.push_back(
      "gimbal pitch is 0 in every row: taken as unknown (logs of aircraft without a gimbal read so)");
}

double wrap_deg(double angle_deg, double low_deg) {
  if (!std::isfinite(angle_deg)) return kMissing;
  const double turned = std::fmod(angle_deg - low_deg, 360.0);
  const double wrapped = (turned < 0.0 ? turned + 360.0 : turned) + low_deg;
  return wrapped >= low_deg + 360.0 ? low_deg : wrapped;
}

void normalise(Track& track) {
  for (Sample& s : track.samples) {
    for (const auto field : kLinearFields)
      if (!std::isfinite(s.*field)) s.*field = kMissing;
    for (const auto field : kHeadingFields) s.*field = wrap_deg(s.*field, 0.0);
    for (const auto field : kSignedAngleFields) s.*field = wrap_deg(s.*field, -180.0);
  }
}

void log_time_from_utc(Track& track) {
  std::optional<base::Nanoseconds> first;
  for (const Sample& s : track.samples) first = std::min(first.value_or(*s.t_utc_ns), *s.t_utc_ns);
  for (Sample& s : track.samples) s.t_log_ns = *s.t_utc_ns - *first;
  track.utc_sigma_s = 0.0;
}

void finish(Track& track, const std::vector<int>& lines) {
  keep_photo_edges(track.samples, lines, track.warnings);
  finish_marked(track, lines);
}

void finish_marked(Track& track, const std::vector<int>& lines) {
  clear_impossible_positions(track, lines);
  clear_impossible_heights(track, lines);
  normalise(track);
  order_by_time(track, lines);
}

std::string rows_text(std::size_t count, int first_line) {
  return std::to_string(count) + (count == 1 ? " row" : " rows") + " (first: line " +
         std::to_string(first_line) + ")";
}

}  // namespace furrow::telemetry::reader
