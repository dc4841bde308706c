#pragma once
#include <vector>

#include "furrow/audit/shot_record.h"
#include "furrow/base/csv.h"

namespace furrow::audit {

/// Shots that follow each other at about the same height.
struct HeightLeg {
  std::size_t first = 0, last = 0;  ///< places in the records, both inclusive
  double mean_height_m = 0.0;       ///< of the log, above take-off
};

/// Cuts a flight where the log's height leaves the mean of the running leg by more than `step_m`; shots
/// without a log height stay with the leg they stand in. No leg when no shot has a log height.
std::vector<HeightLeg> height_legs(const std::vector<ShotRecord>& records, double step_m = 0.5);

/// The thesis's tables for any flight: for each leg and in total, by each method, mean height above ground
/// and mean and standard deviation of its error against the log's height, as the thesis counts it, and
/// against the truth of a simulated flight (estimate - reference). `row_height_m` takes canopy heights to the
/// ground; with NaN there is no table. Methods without a value in the flight are left out.
base::CsvTable leg_table(const std::vector<ShotRecord>& records, double row_height_m);

}  // namespace furrow::audit
