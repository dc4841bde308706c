#include "furrow/audit/truth.h"

#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "furrow/base/text.h"
#include "furrow/stats/agreement.h"

namespace furrow::audit {
namespace {

using base::format_fixed;

/// A share in percent; "-" for one that is not known.
std::string percent(double share) {
  return std::isfinite(share) ? format_fixed(100.0 * share, 0) : "-";
}

/// A height that the whole flight gave is no answer of the flight where the shot had to be taken alone.
Estimate of_flight(const ShotRecord& record) {
  return record.refined_in_flight ? record.above_canopy_refined_m : Estimate{};
}

}  // namespace

Status join_truth(std::vector<ShotRecord>& records, const base::CsvTable& truth) {
  const auto id = truth.column("shot_id");
  const auto height = truth.column("height_above_canopy_m");
  if (!id || !height) {
    return Error{"truth_column_missing", truth.source, "no shot_id or no height_above_canopy_m",
                 "a simulated flight's truth.csv", ""};
  }
  std::map<std::string, double> heights;
  for (const auto& row : truth.rows)
    heights[row[*id]] = base::parse_double(row[*height]).value_or(std::nan(""));
  std::size_t matched = 0;
  for (ShotRecord& record : records) {
    const auto found = heights.find(record.shot_id);
    if (found == heights.end()) continue;
    record.truth_above_canopy_m = found->second;
    ++matched;
  }
  if (matched == 0 && !records.empty()) {
    return Error{"truth_without_shots", truth.source,
                 "none of its shot_ids is a shot of this flight (first shot: " + records[0].shot_id + ")",
                 "the truth.csv of this flight", ""};
  }
  return Done{};
}

TruthComparison compare(const std::string& method, std::span<const Estimate> heights,
                        std::span<const double> truths) {
  std::vector<double> values;
  std::vector<double> shares;
  for (std::size_t i = 0; i < truths.size(); ++i) {
    values.push_back(heights[i].value);
    shares.push_back(heights[i].value / truths[i]);
  }
  const std::vector<double> ones(shares.size(), 1.0);
  const stats::Agreement result = stats::agreement(values, truths);
  const stats::Coverage coverage = stats::coverage(heights, truths);
  return {method,
          result.pairs,
          result.mean_error,
          result.sd_error,
          result.rmse,
          stats::agreement(shares, ones).rmse,
          coverage.within_1_sigma,
          coverage.within_2_sigma};
}

std::vector<TruthComparison> compare_with_truth(const std::vector<ShotRecord>& records) {
  const auto field = [](Estimate ShotRecord::*member) {
    return [member](const ShotRecord& r) { return r.*member; };
  };
  const std::vector<std::pair<std::string, std::function<Estimate(const ShotRecord&)>>> methods = {
      {"thesis formula", field(&ShotRecord::above_canopy_thesis_m)},
      {"thesis formula, width by hand", field(&ShotRecord::above_canopy_thesis_hand_m)},
      {"thesis formula, depth map", field(&ShotRecord::above_canopy_depth_thesis_m)},
      {"depth map, levels", field(&ShotRecord::above_canopy_depth_m)},
      {"row spacing, closed form", field(&ShotRecord::above_canopy_spacing_m)},
      {"refined, each shot alone", field(&ShotRecord::above_canopy_shot_m)},
      {"refined, whole flight", of_flight},
      {"fused", field(&ShotRecord::above_canopy_fused_m)}};
  std::vector<double> truths;
  truths.reserve(records.size());
  for (const ShotRecord& record : records) truths.push_back(record.truth_above_canopy_m);
  std::vector<TruthComparison> lines;
  for (const auto& [name, height] : methods) {
    std::vector<Estimate> heights;
    heights.reserve(records.size());
    for (const ShotRecord& record : records) heights.push_back(height(record));
    const TruthComparison line = compare(name, heights, truths);
    if (line.shots > 0) lines.push_back(line);
  }
  return lines;
}

base::CsvTable comparison_table(std::span<const TruthComparison> lines) {
  base::CsvTable table;
  table.columns = {"height above canopy", "shots",       "mean error m", "sd m", "RMSE m", "RMSE %",
                   "in 1 sigma %",        "in 2 sigma %"};
  for (const TruthComparison& line : lines) {
    if (line.shots == 0) continue;
    table.rows.push_back({line.method, std::to_string(line.shots), format_fixed(line.mean_error_m, 3),
                          format_fixed(line.sd_error_m, 3), format_fixed(line.rmse_m, 3),
                          format_fixed(100.0 * line.rmse_share, 2), percent(line.within_1_sigma),
                          percent(line.within_2_sigma)});
  }
  return table;
}

}  // namespace furrow::audit
