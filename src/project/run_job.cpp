#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "furrow/altitude/flight.h"
#include "furrow/audit/truth.h"
#include "furrow/base/file.h"
#include "furrow/base/folder.h"
#include "furrow/base/parallel.h"
#include "furrow/base/text.h"
#include "furrow/figures/figures.h"
#include "furrow/project/jobs.h"
#include "furrow/report/page.h"
#include "furrow/stats/robust.h"
#include "project/calibration_outputs.h"
#include "project/fusion.h"
#include "project/hand_widths.h"
#include "project/manifest.h"
#include "project/pages.h"
#include "project/run_figures.h"
#include "project/run_provenance.h"
#include "project/shot_chain.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;

/// Shots in the project's order. An unreadable picture stays in, so that the i-th picture keeps its place
/// among the log's marks.
std::vector<telemetry::Shot> read_shots(const Project& project, const JobOptions& job) {
  std::vector<telemetry::Shot> shots(project.images.size());
  std::mutex mutex;
  std::size_t done = 0;
  base::parallel_for(shots.size(), job.threads, [&](std::size_t i) {
    auto shot = telemetry::read_shot(project.images[i]);
    if (shot.ok()) {
      shots[i] = std::move(*shot);
    } else {
      Error error = shot.error();
      error.where = project.images[i].filename().string();  // outputs hold no absolute path
      shots[i].image = project.images[i];
      shots[i].shot_id = project.images[i].stem().string();
      shots[i].warnings.push_back(error.message());
    }
    const std::lock_guard lock(mutex);
    base::report(job.progress, "reading metadata", ++done, shots.size());
  });
  return telemetry::with_unique_ids(std::move(shots));
}

std::vector<ShotResult> process_shots(const std::vector<telemetry::Shot>& shots, const sync::Located& located,
                                      const Camera& camera, const Project& project, const JobOptions& job) {
  std::vector<ShotResult> results(shots.size());
  std::mutex mutex;
  std::size_t done = 0;
  base::parallel_for(shots.size(), job.threads, [&](std::size_t i) {
    results[i] = process_shot(shots[i], located.poses[i], camera, project);
    const std::lock_guard lock(mutex);
    base::report(job.progress, "measuring shots", ++done, shots.size());
  });
  return results;
}

/// Heights by the thesis's formula with the half widths that a person measured.
void add_hand_heights(std::vector<ShotResult>& results, const std::map<std::string, double>& widths,
                      const Project& project) {
  for (ShotResult& result : results) {
    const auto found = widths.find(result.record.shot_id);
    if (found == widths.end() || !result.camera) continue;
    result.record.above_canopy_thesis_hand_m =
        thesis_height(found->second, *result.camera, project.field, result.prior);
  }
}

/// The size that most shots with rows have: a flight is refined with one camera.
std::pair<int, int> common_size(const std::vector<ShotResult>& results) {
  std::map<std::pair<int, int>, int> counts;
  for (const ShotResult& result : results) {
    if (result.camera && result.lines.ok()) ++counts[{result.camera->width, result.camera->height}];
  }
  const auto most = std::max_element(counts.begin(), counts.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == counts.end() ? std::pair{0, 0} : most->first;
}

enum class LogSteps { used, left_out };

/// All shots of the common size at once; the others go in without rows, so that places are kept. For the
/// fusion the log's steps are left out: it hears the log itself.
Result<altitude::RefinedFlight> refine_flight(const std::vector<ShotResult>& results, const Project& project,
                                              LogSteps steps, const JobOptions& job) {
  const auto size = common_size(results);
  std::vector<altitude::ShotInput> inputs;
  const Camera* camera = nullptr;
  for (const ShotResult& result : results) {
    const bool fits = result.camera && std::pair{result.camera->width, result.camera->height} == size;
    inputs.push_back({result.record.shot_id, fits ? result.lines : rows::RowLines{}, result.prior,
                      steps == LogSteps::used ? result.record.height_takeoff_m : std::nan("")});
    if (fits) camera = &*result.camera;
  }
  if (camera == nullptr) return Error{"no_usable_shot", project.name, "no shot has rows", "", ""};
  altitude::FlightOptions options;
  options.shot = refine_options(project);
  options.threads = job.threads;
  base::report(job.progress, "refining the flight", 0, 1);
  auto flight = altitude::refine_flight(inputs, *camera, project.field, options);
  base::report(job.progress, "refining the flight", 1, 1);
  return flight;
}

/// What the pictures alone say of each shot: within the flight where it carries the shot, nothing where its
/// other shots deny it.
std::vector<VisionHeight> vision_heights(const std::vector<ShotResult>& results, const Project& project,
                                         const JobOptions& job) {
  const auto flight = refine_flight(results, project, LogSteps::left_out, job);
  std::vector<VisionHeight> heights;
  for (std::size_t i = 0; i < results.size(); ++i) {
    const bool denied = flight.ok() && flight->denies(i);
    heights.push_back(denied ? VisionHeight{} : results[i].vision);
    if (flight.ok() && flight->shots[i].usable) heights.back() = vision_in_flight(flight->shots[i]);
  }
  return heights;
}

/// Every measured table and picture of a run, ready to be written.
struct RunTables {
  ProjectCamera camera;
  std::vector<telemetry::Shot> shots;
  std::optional<telemetry::Track> track;
  sync::Located located;
  std::vector<ShotResult> results;
  Result<altitude::RefinedFlight> flight = Error{"not_run", "flight", "not refined yet", "", ""};
  Result<audit::FlightFusion> fusion = Error{"not_run", "fusion", "not fused yet", "", ""};
};

Result<RunTables> measure_flight(const Project& project, const JobOptions& job) {
  RunTables tables;
  if (project.telemetry) {  // first: a log that cannot be read should not cost a calibration
    FURROW_TRY(tables.track, telemetry::read_track(*project.telemetry));
  }
  std::map<std::string, double> hand_widths;
  if (project.hand_widths) {
    FURROW_TRY(hand_widths, read_hand_widths(*project.hand_widths));
  }
  FURROW_TRY(tables.camera, camera_of(project, job));
  tables.shots = read_shots(project, job);
  FURROW_TRY(tables.located, sync::locate_shots(tables.shots, tables.track));
  tables.results = process_shots(tables.shots, tables.located, tables.camera.camera, project, job);
  add_hand_heights(tables.results, hand_widths, project);
  tables.flight = refine_flight(tables.results, project, LogSteps::used, job);
  std::vector<VisionHeight> depth;
  for (const ShotResult& result : tables.results) depth.push_back(result.depth);
  tables.fusion =
      fuse_flight(tables.located, vision_heights(tables.results, project, job), project.field, depth);
  return tables;
}

/// The record without the height that the flight's other shots deny; what the shot alone says stays beside
/// it.
audit::ShotRecord denied(audit::ShotRecord record, const std::string& status, const std::string& reason) {
  record.above_canopy_refined_m = record.above_ground_refined_m = {};
  record.status = status;
  record.reason = reason;
  return record;
}

/// By the first shot that states a lens.
audit::Finding assess_focal(const RunTables& tables) {
  const Camera& camera = tables.camera.camera;
  double stated_mm = audit::ShotRecord::kMissing;
  for (const auto& shot : tables.shots) {
    if (std::isfinite(stated_mm = shot.focal_length_35mm_mm)) break;
  }
  return audit::assess_focal(camera.fx, camera.width, stated_mm);
}

/// Of the height that shots.csv calls refined.
std::vector<audit::ShotBudget> budgets_of(const RunTables& tables) {
  std::vector<audit::ShotBudget> budgets;
  for (std::size_t i = 0; i < tables.results.size(); ++i) {
    const ShotResult& alone = tables.results[i];
    const bool carried = tables.flight.ok() && tables.flight->shots[i].usable;
    const audit::ShotRecord& record = alone.record;
    if (carried) {
      const altitude::RefinedShot& shot = tables.flight->shots[i];
      budgets.push_back({record.shot_id, shot.height_above_canopy_m, shot.height_budget});
    } else {
      budgets.push_back({record.shot_id, record.above_canopy_shot_m, alone.budget});
    }
  }
  return budgets;
}

/// Over ground that curves, as the fusion found, a picture's plane lies off the canopy straight below
/// (docs/formulation/altitude.md, eq. 11.7): the sigmas of the rows' heights grow by that.
void widen_by_ground(std::vector<audit::ShotRecord>& records, std::vector<audit::ShotBudget>& budgets,
                     const audit::FlightFusion& fusion) {
  if (!(fusion.fused.ground_curvature_per_m > 0.0)) return;
  for (std::size_t i = 0; i < fusion.shots.size(); ++i) {
    const double reach = fusion.samples[i].vision_reach_m;
    const double by_ground = 0.5 * fusion.fused.ground_curvature_per_m * reach * reach;
    audit::ShotRecord& record = records[fusion.shots[i]];
    for (Estimate* height : {&record.above_canopy_refined_m, &record.above_ground_refined_m,
                             &record.above_canopy_shot_m, &record.above_canopy_spacing_m}) {
      height->sigma = std::hypot(height->sigma, by_ground);
    }
    audit::ShotBudget& budget = budgets[fusion.shots[i]];
    budget.above_canopy_m.sigma = std::hypot(budget.above_canopy_m.sigma, by_ground);
    budget.shares.push_back({"ground", by_ground});
  }
}

void add_fused(std::vector<audit::ShotRecord>& records, const Result<audit::FlightFusion>& fusion) {
  if (!fusion.ok()) return;
  for (std::size_t i = 0; i < fusion->shots.size(); ++i) {
    audit::ShotRecord& record = records[fusion->shots[i]];
    record.above_canopy_fused_m = fusion->fused.heights[i].above_canopy_m;
    record.above_ground_fused_m = fusion->fused.heights[i].above_ground_m;
  }
}

Status write_tables(const fs::path& out, const RunTables& tables,
                    const std::vector<audit::ShotRecord>& records,
                    const std::vector<audit::ShotBudget>& budgets) {
  FURROW_DO(base::write_file(out / "shots.csv", base::to_csv(audit::shots_table(records))));
  FURROW_DO(base::write_file(out / "budget.csv", base::to_csv(audit::budget_table(budgets))));
  if (tables.fusion.ok()) {
    FURROW_DO(
        base::write_file(out / "fusion.csv", base::to_csv(audit::fusion_table(records, *tables.fusion))));
  }
  std::vector<RowsOfImage> rows;
  for (const ShotResult& result : tables.results)
    rows.push_back({result.record.image, result.lines, result.elapsed_ms});
  FURROW_DO(base::write_file(out / "rows.json", base::to_json(rows_document(rows)) + "\n"));
  if (tables.camera.calibration)
    FURROW_DO(write_calibration(out / "calibration", *tables.camera.calibration));
  return Done{};
}

/// Median height above the canopy, for the map of the height error; a usual one when no shot has a height.
double flown_height_m(const std::vector<audit::ShotRecord>& records) {
  std::vector<double> heights_m;
  heights_m.reserve(records.size());
  for (const audit::ShotRecord& record : records) heights_m.push_back(record.above_canopy_refined_m.value);
  const double middle_m = stats::median(heights_m);
  return middle_m > 0.0 ? middle_m : CalibrateJobOptions{}.flight_height_m;
}

/// Writes figures and adds their names to the manifest's.
Status write_figures(const fs::path& out, const std::vector<figures::Figure>& made,
                     std::vector<std::string>& files) {
  for (const figures::Figure& figure : made) {
    FURROW_DO(figures::write_figure(out / "figures", figure));
    files.push_back("figures/" + figure.name + ".png");
    files.push_back("figures/" + figure.name + ".svg");
  }
  return Done{};
}

/// Each shot by the flight where that carries it, else alone. One that failed alone keeps its own reason: it
/// names the gimbal, say, where the flight names the fit.
std::vector<audit::ShotRecord> records_of(const RunTables& tables) {
  std::vector<audit::ShotRecord> records;
  for (std::size_t i = 0; i < tables.results.size(); ++i) {
    const audit::ShotRecord& alone = tables.results[i].record;
    const bool carried = tables.flight.ok() && tables.flight->shots[i].usable;
    records.push_back(carried ? with_refined(alone, tables.flight->shots[i]) : alone);
    records.back().refined_in_flight = carried;
    if (tables.flight.ok() && tables.flight->denies(i) && alone.status == "ok")
      records.back() = denied(alone, tables.flight->status[i], tables.flight->reason[i]);
  }
  return records;
}

std::vector<std::string> warnings_of(const RunTables& tables) {
  std::vector<std::string> warnings;
  for (const ShotResult& result : tables.results) {
    if (!result.depth_reason.empty())
      warnings.push_back(result.record.shot_id + ": no height from its depth map: " + result.depth_reason);
  }
  if (const auto failure = altitude::failure_of(tables.flight))
    warnings.push_back("Each shot was refined alone, the flight not as a whole: " + failure->message());
  return warnings;
}

}  // namespace

Result<RunOutcome> run_job(const Project& project, const fs::path& out, const JobOptions& job,
                           const std::optional<fs::path>& truth) {
  FURROW_DO(base::can_hold_results(out));
  std::optional<base::CsvTable> true_heights;  // named before the work, joined after it
  if (truth) {
    FURROW_TRY(true_heights, base::read_csv(*truth));
  }
  FURROW_TRY(RunTables tables, measure_flight(project, job));
  RunOutcome outcome;
  outcome.records = records_of(tables);
  outcome.warnings = warnings_of(tables);
  std::vector<audit::ShotBudget> budgets = budgets_of(tables);
  if (tables.fusion.ok()) widen_by_ground(outcome.records, budgets, *tables.fusion);
  add_fused(outcome.records, tables.fusion);
  outcome.findings = audit::assess_shots(outcome.records, project.field.row_height_m.value);
  outcome.findings.push_back(assess_focal(tables));
  if (true_heights) FURROW_DO(audit::join_truth(outcome.records, *true_heights));
  if (tables.fusion.ok()) {
    outcome.fusion_truth = audit::compare_fusion(outcome.records, *tables.fusion);
    outcome.rise_told_m = tables.fusion->rise_told_m;
    outcome.rise_words = audit::rise_words(*tables.fusion);
  }
  FURROW_DO(write_tables(out, tables, outcome.records, budgets));

  base::report(job.progress, "drawing", 0, 1);
  std::vector<std::string> files = {"shots.csv", "budget.csv", "report.html"};
  if (tables.fusion.ok()) files.push_back("fusion.csv");
  RunContent content{project,
                     outcome.records,
                     outcome.findings,
                     tables.camera.camera,
                     tables.flight,
                     budgets,
                     tables.fusion,
                     camera_words(tables.camera.camera, tables.results),
                     log_words(project, tables.track, tables.located, tables.shots),
                     {},
                     {},
                     {},
                     {},
                     {},
                     {}};
  FURROW_DO(draw_heights(content));
  FURROW_TRY(content.overlays, overlays(tables.shots, tables.results, tables.flight));
  if (tables.camera.calibration) {
    const calib::Calibration& calibration = tables.camera.calibration->calibration;
    FURROW_TRY(auto made,
               calibration_figures(*tables.camera.calibration, flown_height_m(outcome.records), job.threads));
    const auto findings = audit::assess_calibration(calibration, tables.camera.calibration->verdict);
    content.calibration.push_back(
        calibration_section(calibration, tables.camera.calibration->verdict, findings, std::move(made)));
    outcome.findings.insert(outcome.findings.end(), findings.begin(), findings.end());
    for (const std::string& file : calibration_files(calibration)) files.push_back("calibration/" + file);
    FURROW_DO(write_figures(out, content.calibration[0].figures, files));
  }
  for (const auto* made : {&content.flight_figures, &content.leg_figures, &content.budget_figures,
                           &content.fusion_figures, &content.overlays}) {
    FURROW_DO(write_figures(out, *made, files));
  }
  outcome.report = out / "report.html";
  FURROW_DO(base::write_file(outcome.report, report::to_html(run_page(std::move(content)))));
  FURROW_DO(write_manifest(out, "run", options_value(project), inputs_value(project), files));
  base::report(job.progress, "drawing", 1, 1);
  return outcome;
}

}  // namespace furrow::project
