#pragma once
#include <filesystem>
#include <vector>

#include "furrow/calib/calibrate.h"
#include "furrow/project/jobs.h"

namespace furrow::project {

/// Board file and pictures -> camera.
Result<calib::Calibration> calibrate_from_pictures(const std::vector<std::filesystem::path>& images,
                                                   const std::filesystem::path& board_file,
                                                   const calib::CalibrateOptions& options,
                                                   const JobOptions& job);

/// camera.cameramodel, camera.yaml and calibration.json into `out`.
Status write_calibration(const std::filesystem::path& out, const calib::Calibration& calibration);

}  // namespace furrow::project
