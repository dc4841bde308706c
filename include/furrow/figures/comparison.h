#pragma once
#include <string>
#include <vector>

#include "furrow/audit/shot_record.h"
#include "furrow/figures/figures.h"

namespace furrow::figures {

/// Two ways of measuring one thing, value by value. NaN where one is missing.
struct Comparison {
  std::string name;            ///< file stem of the figure, snake_case
  std::string quantity;        ///< "height above ground"
  std::string unit;            ///< "m"
  std::string estimate_name;   ///< "refined"
  std::string reference_name;  ///< "log"
  std::vector<std::string> ids;
  std::vector<double> estimate, reference;
  std::string counted = "shots";  ///< what a pair is
};

/// Refined height above ground against the log's height above take-off.
Comparison heights_against_log(const std::vector<audit::ShotRecord>& records);
/// Refined height above the canopy against the simulation's truth.
Comparison heights_against_truth(const std::vector<audit::ShotRecord>& records);
/// Refined pitch against the gimbal's.
Comparison pitch_against_log(const std::vector<audit::ShotRecord>& records);

/// Difference over mean of the two, with bias and 95 % limits of agreement (Bland and Altman, Lancet 1986).
/// Errors: nothing_to_draw (no pair).
Result<Figure> agreement(const Comparison& comparison, const FigureOptions& options = {});

/// How often which error (estimate - reference) occurred, with the Gaussian of the same mean and standard
/// deviation. Errors: nothing_to_draw (no pair).
Result<Figure> error_histogram(const Comparison& comparison, const FigureOptions& options = {});

/// One panel per leg: refined and thesis height above ground against the log, shot by shot (the thesis's
/// per-height figures). Errors: nothing_to_draw (no leg).
Result<Figure> heights_by_leg(const std::vector<audit::ShotRecord>& records, double row_height_m,
                              const FigureOptions& options = {});

}  // namespace furrow::figures
