#pragma once
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "furrow/base/csv.h"
#include "furrow/telemetry/track.h"

/// What several readers need: columns with units, clocks of different resolution, marks, order in time.
namespace furrow::telemetry::reader {

inline constexpr double kMetresPerFoot = 0.3048;        // exact, international foot
inline constexpr double kMpsPerMph = 0.44704;           // exact
inline constexpr double kMpsPerKmh = 1.0 / 3.6;         // exact
inline constexpr double kMpsPerKnot = 1852.0 / 3600.0;  // exact

/// A log of more than a year is a damaged number, and would not fit nanoseconds much longer.
inline constexpr double kLongestLog_ms = 366.0 * 86400.0 * 1000.0;

/// What a column measures. The stated_ ones must carry their unit in the header; the others are SI without
/// one.
enum class Quantity { stated_length, stated_speed, length, speed, plain };

/// A column of a table and what turns its cells into metres, metres per second, or what they are.
struct Column {
  std::size_t index = 0;
  double factor = 1.0;
};

/// Finds `stem` followed by its unit in brackets, "height(feet)" or "OSD.height [ft]", or by nothing. Errors:
/// telemetry_unit_unknown.
Result<std::optional<Column>> find_column(const base::CsvTable& table, std::string_view stem,
                                          Quantity quantity);

/// The first of several stems that is there.
Result<std::optional<Column>> find_first_column(const base::CsvTable& table,
                                                std::initializer_list<std::string_view> stems,
                                                Quantity quantity);

/// All of `stems` must be there. Errors: telemetry_column_missing with every missing name and the nearest
/// that is there.
Status require_columns(const base::CsvTable& table, const std::vector<std::string_view>& stems,
                       std::string_view format);

/// parse_csv(), but a quote left open by a cut file only costs the last row.
Result<base::CsvTable> parse_log_csv(std::string_view text, const std::string& name);

/// Reads cells as numbers and remembers those that were text.
class Numbers {
 public:
  explicit Numbers(const base::CsvTable& table) : table_(table), bad_(table.columns.size()) {}
  /// NaN for an absent column, an empty cell or text.
  double at(std::size_t row, const std::optional<Column>& column);
  /// One line per column that held text.
  std::vector<std::string> warnings() const;

 private:
  struct Bad {
    int count = 0;
    int first_line = 0;
    std::string text;
  };
  const base::CsvTable& table_;
  std::vector<Bad> bad_;
};

/// A flag cell: 1/0, true/false, yes/no in any case.
bool flag_at(const base::CsvTable& table, std::size_t row, const std::optional<Column>& column);

/// The constant that turns one clock into another that is read to `resolution_ns` only: each pair says
/// coarse <= fine + offset < coarse + resolution, and the offset that agrees with most pairs is the middle of
/// their common interval.
struct ClockFit {
  base::Nanoseconds offset_ns = 0;
  double sigma_s = 0.0;      ///< width of the common interval / sqrt(12)
  std::size_t disagree = 0;  ///< pairs outside it by more than half a resolution: the coarse clock jumped
};
std::optional<ClockFit> fit_coarse_clock(
    const std::vector<std::pair<base::Nanoseconds, base::Nanoseconds>>& fine_and_coarse,
    base::Nanoseconds resolution_ns);

/// Keeps is_photo only where it rises; says so when a mark lasts longer than a second. Between two marked
/// rows with a hole (rows missing for half a second and three usual steps) it is taken to have fallen and
/// risen.
void keep_photo_edges(std::vector<Sample>& samples, const std::vector<int>& lines,
                      std::vector<std::string>& warnings);

/// Drops samples that are not later than the one kept before them; a dropped row's photo mark moves to the
/// row kept.
void order_by_time(Track& track, const std::vector<int>& lines);

/// (0, 0) and places off the Earth become "no fix".
void clear_impossible_positions(Track& track, const std::vector<int>& lines);

/// Heights beyond what can be flown become unknown: damaged numbers. True if there was one.
bool clear_impossible_heights(Sample& sample);
/// The same of a log's rows, with a warning.
void clear_impossible_heights(Track& track, const std::vector<int>& lines);

/// A gimbal pitch of 0 in every row means that nothing measured it. For flight records: they have the column
/// whether there is a gimbal or not. Not for subtitles, which name the angles only when there are some.
void clear_constant_gimbal(Track& track);

/// Brings angles into their ranges (sample_fields.h) and drops infinities.
void normalise(Track& track);

/// Photo edges, positions, heights, angles and order in time, as every reader needs them. `lines` holds the
/// file's line of each sample.
void finish(Track& track, const std::vector<int>& lines);
/// The same for a log whose every row is a picture.
void finish_marked(Track& track, const std::vector<int>& lines);

/// t_log_ns of every sample from its t_utc_ns, zero at the earliest. All samples must have UTC.
void log_time_from_utc(Track& track);

/// `angle_deg` in [low, low + 360).
double wrap_deg(double angle_deg, double low_deg);

/// "3 rows (first: line 17)".
std::string rows_text(std::size_t count, int first_line);

}  // namespace furrow::telemetry::reader
