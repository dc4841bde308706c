#include "furrow/base/file.h"
#include "furrow/base/folder.h"
#include "furrow/calib/choose_model.h"
#include "furrow/calib/mrcal_inputs.h"
#include "furrow/camera/model_files.h"
#include "furrow/figures/figures.h"
#include "furrow/image/video.h"
#include "furrow/project/jobs.h"
#include "furrow/report/page.h"
#include "project/calibration_outputs.h"
#include "project/pages.h"

namespace furrow::project {

namespace {

/// The board that a file describes, or the checkerboard that most of the pictures show.
Result<target::BoardSpec> board_from(const BoardSource& source,
                                     const std::vector<std::filesystem::path>& images,
                                     const JobOptions& job) {
  if (!source.file.empty()) return target::read_board(source.file);
  const auto guesses = target::guess_boards(images, {}, job.threads, job.progress);
  const std::string pictures = std::to_string(images.size()) + " pictures";
  if (guesses.empty()) {
    return Error{"board_unknown", "calibrate", "no whole checkerboard shows in the " + pictures,
                 "pictures of a checkerboard, or --target BOARD.yaml",
                 "ChArUco boards and AprilGrids need their file (calib_targets/ has some)"};
  }
  const target::BoardGuess& best = guesses.front();
  const std::string counts = std::to_string(best.corners_x) + "x" + std::to_string(best.corners_y);
  if (!(source.square_m > 0.0)) {
    return Error{"square_unknown", "calibrate",
                 "a checkerboard of " + counts + " inner corners shows in " + std::to_string(best.pictures) +
                     " of " + pictures + ", but not how large its squares are",
                 "the side of a square, measured on the print", "say --square-mm 25, or --target BOARD.yaml"};
  }
  target::BoardSpec board{"counted-" + counts, best.corners_x, best.corners_y, source.square_m, 1.0};
  FURROW_DO(target::validate(board));
  return board;
}

bool is_for(const calib::Calibration& calibration, camera::CameraFormat format) {
  return camera::export_camera(calibration.camera, format).ok();
}

}  // namespace

std::vector<std::string> calibration_files(const calib::Calibration& calibration) {
  std::vector<std::string> out;
  if (is_for(calibration, camera::CameraFormat::mrcal)) out.emplace_back("camera.cameramodel");
  if (is_for(calibration, camera::CameraFormat::opencv)) out.emplace_back("camera.yaml");
  out.insert(out.end(), {"calibration.json", "verdict.json"});
  return out;
}

Status write_calibration(const std::filesystem::path& out, const JudgedCalibration& judged) {
  const calib::Calibration& calibration = judged.calibration;
  if (is_for(calibration, camera::CameraFormat::mrcal)) {
    FURROW_DO(base::write_file(
        out / "camera.cameramodel",
        camera::to_mrcal_cameramodel(calibration.camera, calib::mrcal_optimization_inputs(calibration))));
  }
  if (is_for(calibration, camera::CameraFormat::opencv))
    FURROW_DO(base::write_file(out / "camera.yaml", camera::to_opencv_yaml(calibration.camera)));
  FURROW_DO(base::write_file(out / "calibration.json", calib::to_json(judged.calibration)));
  return base::write_file(out / "verdict.json", calib::to_json(judged.verdict));
}

Result<JudgedCalibration> calibrate_from_pictures(const std::vector<std::filesystem::path>& named,
                                                  const BoardSource& source,
                                                  const CalibrateJobOptions& options, const JobOptions& job) {
  FURROW_TRY(const auto images, image::picture_files(named));
  FURROW_TRY(const target::BoardSpec board, board_from(source, images, job));
  const auto detections = target::detect_boards(images, board, {}, job.threads, job.progress);
  calib::CalibrateOptions solve = options.solve;
  std::string choice_words;
  if (options.choose_model) {
    FURROW_TRY(const calib::ModelChoice choice, calib::choose_model(detections, board, solve));
    solve.model = choice.model;
    choice_words = choice.sentence;
  }
  auto calibration = calib::calibrate(detections, board, solve);
  if (!calibration.ok()) {
    Error error = calibration.error();
    if (error.code == "too_few_boards") {
      const std::string better = target::what_fits_instead(images, board, {}, job.threads, job.progress);
      if (!better.empty()) error.hint = better;
    }
    return error;
  }
  calibration.value().model_choice = choice_words;
  calib::Verdict verdict = calib::judge(*calibration, detections, solve);
  calib::TellingViews telling = calib::telling_views(*calibration, detections);
  return JudgedCalibration{std::move(*calibration), std::move(verdict), std::move(telling), images};
}

Result<CalibrateOutcome> calibrate_job(const std::vector<std::filesystem::path>& images,
                                       const BoardSource& board, const CalibrateJobOptions& options,
                                       const std::filesystem::path& out, const JobOptions& job) {
  FURROW_DO(base::can_hold_results(out));
  CalibrateOutcome outcome;
  FURROW_TRY(JudgedCalibration judged, calibrate_from_pictures(images, board, options, job));
  outcome.findings = audit::assess_calibration(judged.calibration, judged.verdict);
  FURROW_DO(write_calibration(out, judged));
  outcome.files = calibration_files(judged.calibration);
  outcome.files.emplace_back("report.html");
  base::report(job.progress, "drawing", 0, 1);
  FURROW_TRY(auto made, calibration_figures(judged, options.flight_height_m, job.threads));
  outcome.calibration = std::move(judged.calibration);
  for (const auto& figure : made) FURROW_DO(figures::write_figure(out / "figures", figure));
  const auto page = calibration_page(
      outcome.calibration, judged.verdict,
      calibration_section(outcome.calibration, judged.verdict, outcome.findings, std::move(made)));
  FURROW_DO(base::write_file(out / "report.html", report::to_html(page)));
  base::report(job.progress, "drawing", 1, 1);
  return outcome;
}

Result<ProjectCamera> camera_of(const Project& project, const JobOptions& job) {
  ProjectCamera result;
  if (project.board_images.empty()) {
    FURROW_TRY(result.camera, camera::read_camera(project.camera_model));
    return result;
  }
  CalibrateJobOptions options;
  options.solve.model = project.calibrate_model;
  options.solve.solve_aspect = project.calibrate_aspect;
  FURROW_TRY(result.calibration,
             calibrate_from_pictures(project.board_images, {project.board_file}, options, job));
  // What the halves of the views deny is not handed on as certain.
  result.camera = calib::widened_camera(result.calibration->calibration, result.calibration->verdict);
  return result;
}

}  // namespace furrow::project
