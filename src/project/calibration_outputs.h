#pragma once
#include <filesystem>
#include <optional>
#include <vector>

#include "furrow/calib/calibrate.h"
#include "furrow/calib/telling_views.h"
#include "furrow/calib/verdict.h"
#include "furrow/project/jobs.h"

namespace furrow::project {

/// A camera and how far it can be trusted.
struct JudgedCalibration {
  calib::Calibration calibration;
  calib::Verdict verdict;
  calib::TellingViews telling;                 ///< to be drawn over their pictures
  std::vector<std::filesystem::path> pictures;  ///< the file of each of calibration.views
};

/// Board and pictures -> camera. With too few boards found, the error says which board the pictures show
/// instead.
Result<JudgedCalibration> calibrate_from_pictures(const std::vector<std::filesystem::path>& images,
                                                  const BoardSource& source,
                                                  const CalibrateJobOptions& options,
                                                  const JobOptions& job);

/// Names of what write_calibration() writes: camera.cameramodel (mrcal knows no fisheye), camera.yaml (OpenCV
/// no wide lens but the fisheye), calibration.json, verdict.json.
std::vector<std::string> calibration_files(const calib::Calibration& calibration);

/// These files into `out`.
Status write_calibration(const std::filesystem::path& out, const JudgedCalibration& judged);

/// The camera of a project and, when it was calibrated for it, the calibration.
struct ProjectCamera {
  Camera camera;
  std::optional<JudgedCalibration> calibration;
};

/// Reads the project's camera file, or calibrates from its pictures of a board. Errors: those of both.
Result<ProjectCamera> camera_of(const Project& project, const JobOptions& job);

}  // namespace furrow::project
