#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "furrow/audit/finding.h"
#include "furrow/audit/shot_record.h"
#include "furrow/audit/truth.h"
#include "furrow/base/progress.h"
#include "furrow/base/value.h"
#include "furrow/calib/calibrate.h"
#include "furrow/project/project.h"
#include "furrow/rows/detect.h"

/// The jobs behind the commands: each reads files, calls the modules below and writes a folder of results.
namespace furrow::project {

struct JobOptions {
  int threads = 0;  ///< 0: one per core
  base::Progress progress;
};

/// How a calibration is made and shown.
struct CalibrateJobOptions {
  calib::CalibrateOptions solve;
  bool choose_model = false;      ///< by cross-validation; solve.model is then the answer, not the question
  double flight_height_m = 10.0;  ///< above the crop, for the map of the height error
};

/// What `furrow calibrate` did.
struct CalibrateOutcome {
  calib::Calibration calibration;
  std::vector<audit::Finding> findings;
  std::vector<std::string> files;  ///< written, relative to the output folder
};

/// Which board the pictures show: a file says it; without one the corners are counted in the pictures, and
/// only the square must be told.
struct BoardSource {
  std::filesystem::path file;  ///< empty: count
  double square_m = 0.0;       ///< of a board that is counted; 0: not told
};

/// Boards in pictures (files, folders, patterns: image::picture_files) -> camera.cameramodel, camera.yaml
/// (each where the format knows the lens), calibration.json, verdict.json, report.html, figures/ in `out`.
/// Errors: those of read_board, calibrate and file writing; board_unknown (none was described and none
/// counted), square_unknown (says what was counted).
Result<CalibrateOutcome> calibrate_job(const std::vector<std::filesystem::path>& images,
                                       const BoardSource& board, const CalibrateJobOptions& options,
                                       const std::filesystem::path& out, const JobOptions& job = {});

/// Rows of one picture, for rows.json.
struct RowsOfImage {
  std::string image;
  rows::RowLines lines;
  double elapsed_ms = 0.0;  ///< of the detection alone
};

/// The document of rows.json (docs/cli.md names its members).
base::Value rows_document(const std::vector<RowsOfImage>& images);

struct RowsJobOptions {
  rows::DetectOptions detect;
  bool overlays = true;  ///< write overlays/<image>.png
  /// Folder for the pictures of each step of the thesis method; nothing writes none.
  std::optional<std::filesystem::path> steps;
};

/// Pictures (files, folders, patterns) -> rows.json and overlays in `out`. A picture that cannot be read has
/// a status and the rest goes on.
Result<std::vector<RowsOfImage>> rows_job(const std::vector<std::filesystem::path>& images,
                                          const std::filesystem::path& out,
                                          const RowsJobOptions& options = {}, const JobOptions& job = {});

/// What `furrow run` did.
struct RunOutcome {
  std::vector<audit::ShotRecord> records;
  std::vector<audit::Finding> findings;
  /// Fused heights against the truth of a simulated flight, with all sources and with each one off.
  std::vector<audit::TruthComparison> fusion_truth;
  Estimate rise_told_m;    ///< audit::FlightFusion's; unusable without a fusion that tells one
  std::string rise_words;  ///< audit::rise_words; empty where it adds little to what was taken
  std::filesystem::path report;
  std::vector<std::string> warnings;  ///< what a person should know beside the findings, one sentence each
};

/// A project -> shots.csv, budget.csv, fusion.csv (where there is something to fuse), rows.json, report.html,
/// figures/, manifest.json (and calibration/ when it calibrates) in `out`. A shot that fails has a status in
/// shots.csv and the flight goes on. `truth` is a simulated flight's truth.csv: it is read when all estimates
/// are made and only compared with them.
Result<RunOutcome> run_job(const Project& project, const std::filesystem::path& out,
                           const JobOptions& job = {},
                           const std::optional<std::filesystem::path>& truth = {});

/// Renders the demo's world into `out`/input, runs the chain on pictures and log alone into `out`, and
/// compares.
Result<RunOutcome> demo_job(const std::filesystem::path& out, const JobOptions& job = {});

}  // namespace furrow::project
