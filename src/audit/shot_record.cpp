#include "furrow/audit/shot_record.h"

#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "furrow/base/text.h"

namespace furrow::audit {
namespace {

using Cell = std::function<std::string(const ShotRecord&)>;

std::string number(double value, int decimals) {
  return std::isfinite(value) ? base::format_fixed(value, decimals) : std::string();
}

/// A column of fixed decimals; centimetre-level quantities get a tenth of a millimetre so that differences
/// can still be formed.
Cell fixed(double ShotRecord::*field, int decimals) {
  return [field, decimals](const ShotRecord& r) { return number(r.*field, decimals); };
}
Cell value_of(Estimate ShotRecord::*field, int decimals) {
  return [field, decimals](const ShotRecord& r) { return number((r.*field).value, decimals); };
}
Cell sigma_of(Estimate ShotRecord::*field, int decimals) {
  return [field, decimals](const ShotRecord& r) { return number((r.*field).sigma, decimals); };
}

std::vector<std::pair<std::string, Cell>> columns() {
  using R = ShotRecord;
  return {
      {"shot_id", [](const R& r) { return r.shot_id; }},
      {"image", [](const R& r) { return r.image; }},
      {"t_utc", [](const R& r) { return r.t_utc_ns ? base::format_utc(*r.t_utc_ns) : std::string(); }},
      {"latitude_deg", fixed(&R::latitude_deg, 8)},
      {"longitude_deg", fixed(&R::longitude_deg, 8)},
      {"height_takeoff_m", fixed(&R::height_takeoff_m, 3)},
      {"height_vps_m", fixed(&R::height_vps_m, 3)},
      {"pitch_log_deg", fixed(&R::pitch_log_deg, 2)},
      {"pitch_deg", value_of(&R::pitch_deg, 4)},
      {"pitch_sigma_deg", sigma_of(&R::pitch_deg, 4)},
      {"above_canopy_thesis_m", value_of(&R::above_canopy_thesis_m, 4)},
      {"above_canopy_thesis_hand_m", value_of(&R::above_canopy_thesis_hand_m, 4)},
      {"above_canopy_depth_thesis_m", value_of(&R::above_canopy_depth_thesis_m, 4)},
      {"above_canopy_depth_m", value_of(&R::above_canopy_depth_m, 4)},
      {"above_canopy_depth_sigma_m", sigma_of(&R::above_canopy_depth_m, 4)},
      {"above_canopy_spacing_m", value_of(&R::above_canopy_spacing_m, 4)},
      {"above_canopy_spacing_sigma_m", sigma_of(&R::above_canopy_spacing_m, 4)},
      {"above_canopy_refined_m", value_of(&R::above_canopy_refined_m, 4)},
      {"above_canopy_refined_sigma_m", sigma_of(&R::above_canopy_refined_m, 4)},
      {"above_ground_refined_m", value_of(&R::above_ground_refined_m, 4)},
      {"above_ground_refined_sigma_m", sigma_of(&R::above_ground_refined_m, 4)},
      {"above_canopy_shot_m", value_of(&R::above_canopy_shot_m, 4)},
      {"above_canopy_shot_sigma_m", sigma_of(&R::above_canopy_shot_m, 4)},
      {"above_canopy_fused_m", value_of(&R::above_canopy_fused_m, 4)},
      {"above_canopy_fused_sigma_m", sigma_of(&R::above_canopy_fused_m, 4)},
      {"above_ground_fused_m", value_of(&R::above_ground_fused_m, 4)},
      {"above_ground_fused_sigma_m", sigma_of(&R::above_ground_fused_m, 4)},
      {"cross_track_m", value_of(&R::cross_track_m, 4)},
      {"cross_track_sigma_m", sigma_of(&R::cross_track_m, 4)},
      {"heading_error_deg", value_of(&R::heading_error_deg, 4)},
      {"heading_error_sigma_deg", sigma_of(&R::heading_error_deg, 4)},
      {"rows_used", [](const R& r) { return std::to_string(r.rows_used); }},
      {"rows_confidence", fixed(&R::rows_confidence, 3)},
      {"truth_above_canopy_m", fixed(&R::truth_above_canopy_m, 4)},
      {"status", [](const R& r) { return r.status; }},
      {"reason", [](const R& r) { return r.reason; }},
  };
}

}  // namespace

base::CsvTable shots_table(const std::vector<ShotRecord>& records) {
  const auto all = columns();
  base::CsvTable table;
  table.source = "shots.csv";
  for (const auto& [name, cell] : all) table.columns.push_back(name);
  for (const ShotRecord& record : records) {
    auto& row = table.rows.emplace_back();
    for (const auto& [name, cell] : all) row.push_back(cell(record));
  }
  return table;
}

}  // namespace furrow::audit
