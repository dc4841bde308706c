#include "furrow/base/file.h"
#include "furrow/camera/model_files.h"
#include "furrow/figures/figures.h"
#include "furrow/project/jobs.h"
#include "furrow/report/page.h"
#include "project/calibration_outputs.h"
#include "project/pages.h"

namespace furrow::project {

Status write_calibration(const std::filesystem::path& out, const calib::Calibration& calibration) {
  FURROW_DO(base::write_file(out / "camera.cameramodel", camera::to_mrcal_cameramodel(calibration.camera)));
  FURROW_DO(base::write_file(out / "camera.yaml", camera::to_opencv_yaml(calibration.camera)));
  return base::write_file(out / "calibration.json", calib::to_json(calibration));
}

Result<calib::Calibration> calibrate_from_pictures(const std::vector<std::filesystem::path>& images,
                                                   const std::filesystem::path& board_file,
                                                   const calib::CalibrateOptions& options,
                                                   const JobOptions& job) {
  FURROW_TRY(const target::BoardSpec board, target::read_board(board_file));
  const auto detections = target::detect_boards(images, board, {}, job.threads, job.progress);
  return calib::calibrate(detections, board, options);
}

Result<CalibrateOutcome> calibrate_job(const std::vector<std::filesystem::path>& images,
                                       const std::filesystem::path& board_file,
                                       const calib::CalibrateOptions& options,
                                       const std::filesystem::path& out, const JobOptions& job) {
  CalibrateOutcome outcome;
  FURROW_TRY(outcome.calibration, calibrate_from_pictures(images, board_file, options, job));
  outcome.findings = audit::assess_calibration(outcome.calibration);
  FURROW_DO(write_calibration(out, outcome.calibration));
  outcome.files = {"camera.cameramodel", "camera.yaml", "calibration.json", "report.html"};
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
