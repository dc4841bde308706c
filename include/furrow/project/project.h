#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/base/progress.h"
#include "furrow/base/result.h"
#include "furrow/camera/camera.h"
#include "furrow/rows/detect.h"

namespace furrow::project {

/// project.yaml, read and checked; paths are resolved against its folder.
struct Project {
  std::string name;
  std::filesystem::path file;
  /// Either a model file, or pictures of a board.
  std::filesystem::path camera_model;
  std::vector<std::filesystem::path> board_images;
  std::filesystem::path board_file;
  camera::CameraModel calibrate_model = camera::CameraModel::opencv5;
  std::vector<std::filesystem::path> images;
  std::optional<std::filesystem::path> telemetry;
  rows::Method rows_method = rows::Method::field;
  altitude::FieldKnowledge field;
  double gimbal_pitch_sigma_deg = 1.0;  ///< how far the log's gimbal pitch may be off
  double gimbal_roll_sigma_deg = 1.0;
};

/// Errors: file_*, malformed_yaml, unknown_key (nearest known name and line), project_invalid, no_match,
/// variable_unset.
Result<Project> read_project(const std::filesystem::path& file);

}  // namespace furrow::project
