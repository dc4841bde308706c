#pragma once
#include <string>
#include <vector>

#include "furrow/altitude/flight.h"
#include "furrow/audit/budget.h"
#include "furrow/audit/fusion.h"
#include "furrow/calib/calibrate.h"
#include "furrow/calib/verdict.h"
#include "furrow/project/jobs.h"
#include "furrow/report/page.h"
#include "project/calibration_outputs.h"

namespace furrow::project {

/// "1.30 \u00b1 0.04"; a sigma that is not known is left out.
std::string with_sigma(double value, double sigma, int decimals);

/// Figures of a calibration: error bars per view, corners over the telling pictures, board poses, residuals over
/// the picture and as a histogram, coverage, distortion, uncertainty over the picture as px and as height error
/// at that height, and how two halves of the pictures differ. What a calibration has no numbers for, and
/// pictures that can no longer be read, are left out.
Result<std::vector<figures::Figure>> calibration_figures(const JudgedCalibration& judged,
                                                         double flight_height_m, int threads = 0);

/// "Calibration" as a section: findings, parameters with sigma, views and what each adds, which pictures to
/// take next, figures.
report::Section calibration_section(const calib::Calibration& calibration, const calib::Verdict& verdict,
                                    const std::vector<audit::Finding>& findings,
                                    std::vector<figures::Figure> figures);

/// The page of `furrow calibrate`.
report::Page calibration_page(const calib::Calibration& calibration, const calib::Verdict& verdict,
                              report::Section section);

/// All that the page of `furrow run` shows.
struct RunContent {
  const Project& project;
  const std::vector<audit::ShotRecord>& records;
  const std::vector<audit::Finding>& findings;
  const Camera& camera;
  const Result<altitude::RefinedFlight>& flight;
  const std::vector<audit::ShotBudget>& budgets;
  const Result<audit::FlightFusion>& fusion;
  std::vector<std::string> camera_words;     ///< what was calibrated at which size, how it was carried
  std::vector<std::string> log_words;        ///< which log, how the shots were found in it, warnings
  std::vector<report::Section> calibration;  ///< none or one
  std::vector<figures::Figure> flight_figures, leg_figures, budget_figures, fusion_figures, overlays;
};
report::Page run_page(RunContent content);

}  // namespace furrow::project
