#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/value.h"
#include "furrow/calib/calibrate.h"
#include "furrow/camera/compare.h"
#include "furrow/camera/describe.h"
#include "furrow/camera/model_files.h"
#include "furrow/project/jobs.h"

/// The jobs behind `furrow camera`.
namespace furrow::project {

/// Size of a sensor, mm.
struct SensorSize {
  double width_mm = 0.0, height_mm = 0.0;
};

/// What `furrow camera show` tells.
struct CameraShown {
  Camera camera;
  camera::Description description;
  /// With the sensor's size: focal length and the fields of view that the thesis computes from it.
  std::optional<double> focal_mm;
  std::optional<camera::FieldOfView> ideal_fov;
};
/// Errors: those of read_camera.
Result<CameraShown> show_camera(const std::filesystem::path& file,
                                const std::optional<SensorSize>& sensor = {});

/// Reads a camera of any format and writes it to `out` in `format`, read back and checked.
Status convert_camera(const std::filesystem::path& file, const std::filesystem::path& out,
                      camera::CameraFormat format, const camera::ExportOptions& options = {});

/// What `furrow camera undistort` did.
struct UndistortOutcome {
  Camera pinhole;             ///< of the pictures written
  double masked_share = 0.0;  ///< of each picture written, that the old one does not show or has no inverse
  std::vector<std::string> written;  ///< file names
  std::vector<std::string>
      failed;  ///< a sentence for each picture that could not be read or has another size
};
/// Pictures (files, folders, patterns) as a pinhole of the same focal length and size sees them, with
/// camera.yaml and mask.png (white where the pictures hold something), into `out`. A picture that fails costs
/// no other. Errors: those of read_camera and of writing; nothing_undistorted when every picture failed.
Result<UndistortOutcome> undistort_pictures(const std::filesystem::path& camera,
                                            const std::vector<std::filesystem::path>& images,
                                            const std::filesystem::path& out, const JobOptions& job = {});

/// Two cameras compared, with a map of the difference as a figure when `out` is given.
struct DiffOutcome {
  Camera a, b;
  camera::CameraDifference difference;
  double focal_percent = 0.0;  ///< b's focal length on the axis over a's, minus 1
};
Result<DiffOutcome> diff_cameras(const std::filesystem::path& a, const std::filesystem::path& b,
                                 const std::optional<std::filesystem::path>& out = {});

/// When an old calibration is still good on new pictures.
struct ValidateLimits {
  /// Largest misfit that the old lens adds to the corners, px per 1280 px of picture width.
  double added_px_per_1280 = 0.3;
  /// Largest change of the focal length, percent; three sigma of it, if that is more.
  double focal_percent = 0.5;
  /// Fewest boards; below, nothing is said about the lens.
  int fewest_boards = 6;
};
struct ValidateOutcome {
  std::vector<calib::View> views;
  int boards = 0, corners = 0;
  double rms_px = 0.0;        ///< the old lens on the new corners, poses fitted
  double refit_rms_px = 0.0;  ///< a lens of the same model solved from them; NaN when none comes off
  double added_px = 0.0;      ///< sqrt(rms^2 - refit_rms^2): "good to so many px"; rms_px without a refit
  double focal_change_percent = 0.0, focal_change_sigma_percent = 0.0;  ///< NaN without a refit
  bool still_good = false;
  std::string sentence;
};
/// `images` may be folders and patterns. Errors: those of read_camera, read_board and picture_files;
/// picture_sizes_differ; too_few_boards.
Result<ValidateOutcome> validate_camera(const std::filesystem::path& camera,
                                        const std::vector<std::filesystem::path>& images,
                                        const std::filesystem::path& board, const ValidateLimits& limits = {},
                                        const JobOptions& job = {});

/// Each outcome as JSON.
base::Value to_value(const CameraShown& shown);
base::Value to_value(const UndistortOutcome& outcome);
base::Value to_value(const DiffOutcome& outcome);
base::Value to_value(const ValidateOutcome& outcome);

}  // namespace furrow::project
