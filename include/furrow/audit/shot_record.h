#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/csv.h"
#include "furrow/base/time.h"
#include "furrow/stats/estimate.h"

namespace furrow::audit {

/// One line of shots.csv: everything that is known of a shot, side by side. NaN where nothing is known.
struct ShotRecord {
  static constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

  std::string shot_id;
  std::string image;  ///< file name
  std::optional<base::Nanoseconds> t_utc_ns;
  double latitude_deg = kMissing, longitude_deg = kMissing;
  double height_takeoff_m = kMissing;  ///< log, barometric
  double height_vps_m = kMissing;      ///< log, surface below
  double pitch_log_deg = kMissing;     ///< gimbal, negative below the horizon
  Estimate pitch_deg;                  ///< refined
  Estimate above_canopy_thesis_m;  ///< thesis formula with the automatic half width; its sigma stays unknown
  Estimate above_canopy_thesis_hand_m;  ///< the same with a half width that a person measured in the picture
  Estimate above_canopy_depth_thesis_m;  ///< thesis formula with a depth map's middle value; without sigma
  Estimate above_canopy_depth_m;         ///< from all of the depth map
  Estimate above_canopy_spacing_m;       ///< closed form
  /// Refined with all shots of the flight at once; from this shot alone where the flight could not carry it.
  Estimate above_canopy_refined_m;
  bool refined_in_flight = false;  ///< whether the flight carried it
  Estimate above_ground_refined_m;
  Estimate above_canopy_shot_m;  ///< refined from this shot alone
  /// From the rows and the log together (altitude/fuse.h).
  Estimate above_canopy_fused_m, above_ground_fused_m;
  Estimate cross_track_m;      ///< camera left of the followed row
  Estimate heading_error_deg;  ///< camera points left of the row direction
  int rows_used = 0;
  double rows_confidence = kMissing;
  std::string status;                      ///< "ok" or why there is no refined height
  std::string reason;                      ///< a sentence when status is not "ok"
  double truth_above_canopy_m = kMissing;  ///< simulated flights only; joined after all estimates are made
};

/// shots.csv: header and one row per record, fixed decimals, empty cells for what is missing.
base::CsvTable shots_table(const std::vector<ShotRecord>& records);

}  // namespace furrow::audit
