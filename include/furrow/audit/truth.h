#pragma once
#include <span>
#include <string>
#include <vector>

#include "furrow/audit/shot_record.h"
#include "furrow/base/csv.h"
#include "furrow/base/result.h"

namespace furrow::audit {

/// Puts a simulated flight's true heights (columns shot_id and height_above_canopy_m of its truth.csv) beside
/// finished estimates; shots that it does not name keep none. Errors: truth_column_missing,
/// truth_without_shots (none of its shots is in the flight).
Status join_truth(std::vector<ShotRecord>& records, const base::CsvTable& truth);

/// How one way of measuring the height agrees with the truth of a simulated flight.
struct TruthComparison {
  std::string method;
  int shots = 0;
  double mean_error_m = 0.0, sd_error_m = 0.0, rmse_m = 0.0;
  double rmse_share = 0.0;  ///< RMS of error / true height above the canopy
  /// Share of truths within one and two sigma; NaN where the method gives no sigma.
  double within_1_sigma = 0.0, within_2_sigma = 0.0;
};

/// One method's heights above the canopy against the truths, shot by shot; those of which one is unknown are
/// left out.
TruthComparison compare(const std::string& method, std::span<const Estimate> heights,
                        std::span<const double> truths);

/// One line for each way that a record measures its height ("thesis formula", "thesis formula, width by
/// hand", "row spacing, closed form", "refined, each shot alone", "refined, whole flight", "fused"); empty
/// when no record has a truth.
std::vector<TruthComparison> compare_with_truth(const std::vector<ShotRecord>& records);

/// The comparison for a person: one row for each method that has shots.
base::CsvTable comparison_table(std::span<const TruthComparison> lines);

}  // namespace furrow::audit
