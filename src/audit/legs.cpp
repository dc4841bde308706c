#include "furrow/audit/legs.h"

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "furrow/base/text.h"
#include "furrow/stats/agreement.h"

namespace furrow::audit {
namespace {

/// A way to a height above ground.
struct Method {
  std::string name;
  std::function<double(const ShotRecord&)> above_ground_m;
};

std::vector<Method> methods_over(double row_height_m) {
  const auto lifted = [row_height_m](Estimate ShotRecord::*height) {
    return [=](const ShotRecord& r) { return (r.*height).value + row_height_m; };
  };
  return {{"thesis, automatic half width", lifted(&ShotRecord::above_canopy_thesis_m)},
          {"thesis, half width by hand", lifted(&ShotRecord::above_canopy_thesis_hand_m)},
          {"thesis, depth map's middle", lifted(&ShotRecord::above_canopy_depth_thesis_m)},
          {"depth map, levels", lifted(&ShotRecord::above_canopy_depth_m)},
          {"row spacing, closed form", lifted(&ShotRecord::above_canopy_spacing_m)},
          {"refined, each shot alone", lifted(&ShotRecord::above_canopy_shot_m)},
          {"refined, whole flight", lifted(&ShotRecord::above_canopy_refined_m)},
          {"fused with the log", lifted(&ShotRecord::above_canopy_fused_m)}};
}

/// Estimates, log and truth of some shots.
struct Heights {
  std::vector<double> estimate, log, truth;
};

Heights heights_of(const std::vector<ShotRecord>& records, const HeightLeg& leg, const Method& method,
                   double row_height_m) {
  Heights heights;
  for (std::size_t i = leg.first; i <= leg.last; ++i) {
    heights.estimate.push_back(method.above_ground_m(records[i]));
    heights.log.push_back(records[i].height_takeoff_m);
    heights.truth.push_back(records[i].truth_above_canopy_m + row_height_m);
  }
  return heights;
}

std::string metres(double value) {
  return std::isfinite(value) ? base::format_fixed(value, 3) : std::string();
}

/// Nothing when the method has no value there.
std::vector<std::string> row_of(const std::string& leg_name, const Method& method, const Heights& heights,
                                bool with_truth) {
  const stats::Agreement log = stats::agreement(heights.estimate, heights.log);
  if (log.pairs == 0) return {};
  std::vector<std::string> row = {
      leg_name,
      method.name,
      std::to_string(log.pairs) + " of " + std::to_string(heights.estimate.size()),
      metres(log.mean_estimate),
      metres(log.mean_error),
      metres(log.sd_error)};
  if (!with_truth) return row;
  const stats::Agreement truth = stats::agreement(heights.estimate, heights.truth);
  row.push_back(metres(truth.mean_error));
  row.push_back(metres(truth.sd_error));
  return row;
}

}  // namespace

std::vector<HeightLeg> height_legs(const std::vector<ShotRecord>& records, double step_m) {
  std::vector<HeightLeg> legs;
  double sum = 0.0;
  int known = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const double height = records[i].height_takeoff_m;
    const bool has = std::isfinite(height);
    if (legs.empty() || (has && known > 0 && std::abs(height - sum / known) > step_m)) {
      legs.push_back({i, i, std::numeric_limits<double>::quiet_NaN()});
      sum = 0.0;
      known = 0;
    }
    legs.back().last = i;
    if (!has) continue;
    sum += height;
    ++known;
    legs.back().mean_height_m = sum / known;
  }
  std::erase_if(legs, [](const HeightLeg& leg) { return !std::isfinite(leg.mean_height_m); });
  return legs;
}

base::CsvTable leg_table(const std::vector<ShotRecord>& records, double row_height_m) {
  base::CsvTable table;
  table.source = "legs.csv";
  table.columns = {"leg", "method", "shots", "mean m", "log error m", "log sd m"};
  bool with_truth = false;
  for (const ShotRecord& record : records) with_truth |= std::isfinite(record.truth_above_canopy_m);
  if (with_truth) table.columns.insert(table.columns.end(), {"truth error m", "truth sd m"});
  if (!std::isfinite(row_height_m)) return table;
  auto legs = height_legs(records);
  const bool several = legs.size() > 1;
  if (several) legs.push_back({0, records.size() - 1, std::numeric_limits<double>::quiet_NaN()});
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const bool total = several && i + 1 == legs.size();
    const std::string name =
        total ? "total" : "log at " + base::format_fixed(legs[i].mean_height_m, 1) + " m";
    for (const Method& method : methods_over(row_height_m)) {
      auto row = row_of(name, method, heights_of(records, legs[i], method, row_height_m), with_truth);
      if (!row.empty()) table.rows.push_back(std::move(row));
    }
  }
  return table;
}

}  // namespace furrow::audit
