#include "furrow/base/file.h"
#include "furrow/camera/model_files.h"
#include "furrow/figures/figures.h"
#include "furrow/project/jobs.h"
#include "furrow/report/page.h"
#include "project/calibration_outputs.h"
#include "project/pages.h"

namespace furrow::project {

Status write_calibration(const std::filesystem::path& out, const JudgedCalibration& judged) {
  FURROW_DO(
      base::write_file(out / "camera.cameramodel", camera::to_mrcal_cameramodel(judged.calibration.camera)));
  FURROW_DO(base::write_file(out / "camera.yaml", camera::to_opencv_yaml(judged.calibration.camera)));
  FURROW_DO(base::write_file(out / "calibration.json", calib::to_json(judged.calibration)));
  return base::write_file(out / "verdict.json", calib::to_json(judged.verdict));
}

Result<JudgedCalibration> calibrate_from_pictures(const std::vector<std::filesystem::path>& images,
                                                  const std::filesystem::path& board_file,
                                                  const calib::CalibrateOptions& options,
                                                  const JobOptions& job) {
  FURROW_TRY(const target::BoardSpec board, target::read_board(board_file));
  const auto detections = target::detect_boards(images, board, {}, job.threads, job.progress);
  auto calibration = calib::calibrate(detections, board, options);
  if (!calibration.ok()) {
    Error error = calibration.error();
    if (error.code == "too_few_boards") {
      const std::string better =
          target::explain_board(board, target::guess_boards(images, {}, job.threads, job.progress));
      if (!better.empty()) error.hint = better;
    }
    return error;
  }
  calib::Verdict verdict = calib::judge(*calibration, detections, options);
  return JudgedCalibration{std::move(*calibration), std::move(verdict)};
}

Result<CalibrateOutcome> calibrate_job(const std::vector<std::filesystem::path>& images,
                                       const std::filesystem::path& board_file,
                                       const calib::CalibrateOptions& options,
                                       const std::filesystem::path& out, const JobOptions& job) {
  CalibrateOutcome outcome;
  FURROW_TRY(JudgedCalibration judged, calibrate_from_pictures(images, board_file, options, job));
  outcome.findings = audit::assess_calibration(judged.calibration, judged.verdict);
  FURROW_DO(write_calibration(out, judged));
  outcome.calibration = std::move(judged.calibration);
  outcome.files = {"camera.cameramodel", "camera.yaml", "calibration.json", "verdict.json", "report.html"};
  base::report(job.progress, "drawing", 0, 1);
  FURROW_TRY(auto made, calibration_figures(outcome.calibration));
  for (const auto& figure : made) FURROW_DO(figures::write_figure(out / "figures", figure));
  const auto page = calibration_page(
      outcome.calibration, calibration_section(outcome.calibration, outcome.findings, std::move(made)));
  FURROW_DO(base::write_file(out / "report.html", report::to_html(page)));
  base::report(job.progress, "drawing", 1, 1);
  return outcome;
}

}  // namespace furrow::project
