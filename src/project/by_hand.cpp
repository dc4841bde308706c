#include "project/by_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "furrow/base/text.h"
#include "furrow/stats/agreement.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Result<std::string> unit_of(const base::CsvTable& table) {
  for (const char* unit : {"m", "cm", "px"}) {
    if (table.column(std::string("deviation_") + unit)) return std::string(unit);
  }
  return Error{"missing_column", table.source + ":1", "no column of deviations",
               "deviation_m, deviation_cm or deviation_px", ""};
}

figures::DeviationByHand& flight_called(std::vector<figures::DeviationByHand>& flights,
                                        const std::string& name, const std::string& unit) {
  const auto known =
      std::find_if(flights.begin(), flights.end(), [&](const auto& one) { return one.flight == name; });
  if (known != flights.end()) return *known;
  return flights.emplace_back(figures::DeviationByHand{name, unit, {}, {}, {}, {}});
}

/// The algorithms' deviations in the file's unit; NaN where they say nothing.
std::pair<double, double> in_unit(const follow::Following& f, const std::string& unit, bool is_metric) {
  const double filtered = f.offset ? f.offset->value : kNaN;
  if (unit == "px") return {f.thesis.deviation_px.value_or(kNaN), is_metric ? kNaN : filtered};
  const double per_m = unit == "cm" ? 100.0 : 1.0;
  return {f.deviation_cm ? *f.deviation_cm * per_m / 100.0 : kNaN, is_metric ? filtered * per_m : kNaN};
}

void add_line(base::CsvTable& table, const std::string& flight, const std::string& method,
              const std::vector<double>& estimates, const std::vector<double>& by_hand) {
  const stats::Agreement agreement = stats::agreement(estimates, by_hand);
  if (agreement.pairs == 0) return;
  const auto number = [](double v) { return std::isfinite(v) ? base::format_fixed(v, 3) : std::string(); };
  table.rows.push_back({flight, method, std::to_string(agreement.pairs), number(agreement.mean_estimate),
                        number(agreement.mean_error), number(agreement.sd_error)});
}

void add_flight(base::CsvTable& table, const figures::DeviationByHand& flight) {
  add_line(table, flight.flight, "thesis", flight.thesis, flight.by_hand);
  add_line(table, flight.flight, "filtered", flight.filtered, flight.by_hand);
}

}  // namespace

Result<ByHand> ByHand::read(const fs::path& file) {
  FURROW_TRY(const base::CsvTable table, base::read_csv(file));
  const auto picture = table.column("picture"), flight = table.column("flight");
  if (!picture)
    return Error{"missing_column", table.source + ":1", "no column 'picture'", "picture, deviation_m", ""};
  FURROW_TRY(const std::string unit, unit_of(table));
  const std::size_t value = *table.column("deviation_" + unit);
  ByHand by_hand;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto& row = table.rows[i];
    const auto deviation = base::parse_double(row[value]);
    if (!deviation)
      return Error{"bad_value", table.source + ":" + std::to_string(table.lines[i]),
                   "deviation_" + unit + " is '" + row[value] + "'", "a number",
                   "Leave the line out where nothing was read."};
    auto& of = flight_called(by_hand.flights_, flight ? row[*flight] : "all pictures", unit);
    by_hand.places_.push_back(
        {row[*picture], {static_cast<std::size_t>(&of - by_hand.flights_.data()), of.pictures.size()}});
    of.pictures.push_back(row[*picture]);
    of.by_hand.push_back(*deviation);
    of.thesis.push_back(kNaN);
    of.filtered.push_back(kNaN);
  }
  if (by_hand.places_.empty())
    return Error{"bad_value", table.source, "no line with a deviation", "at least one", ""};
  std::sort(by_hand.places_.begin(), by_hand.places_.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  return by_hand;
}

void ByHand::add(const FollowedPicture& picture, bool is_metric) {
  for (const std::string& name :
       {picture.name, fs::path(picture.name).stem().string(), std::to_string(picture.index + 1)}) {
    const auto [first, last] =
        std::equal_range(places_.begin(), places_.end(), std::pair{name, Place{}},
                         [](const auto& a, const auto& b) { return a.first < b.first; });
    if (first == last) continue;
    for (auto entry = first; entry != last; ++entry) {
      auto& flight = flights_[entry->second.flight];
      const auto [thesis, filtered] = in_unit(picture.following, flight.unit, is_metric);
      flight.thesis[entry->second.at] = thesis;
      flight.filtered[entry->second.at] = filtered;
      entry->second.is_found = true;
    }
    return;
  }
}

std::size_t ByHand::missing() const {
  return static_cast<std::size_t>(std::count_if(places_.begin(), places_.end(),
                                                [](const auto& place) { return !place.second.is_found; }));
}

base::CsvTable by_hand_table(const std::vector<figures::DeviationByHand>& flights) {
  const std::string unit = flights.empty() ? "" : "_" + flights.front().unit;
  base::CsvTable table;
  table.columns = {"flight", "method", "pictures", "mean_deviation" + unit, "mean_error" + unit, "sd" + unit};
  figures::DeviationByHand total{"total", unit, {}, {}, {}, {}};
  for (const auto& flight : flights) {
    add_flight(table, flight);
    total.by_hand.insert(total.by_hand.end(), flight.by_hand.begin(), flight.by_hand.end());
    total.thesis.insert(total.thesis.end(), flight.thesis.begin(), flight.thesis.end());
    total.filtered.insert(total.filtered.end(), flight.filtered.begin(), flight.filtered.end());
  }
  if (flights.size() > 1) add_flight(table, total);
  return table;
}

}  // namespace furrow::project
