#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/base/result.h"
#include "furrow/camera/camera.h"
#include "furrow/rows/detect.h"

namespace furrow::project {

/// One-sigmas that stand in where the project file gives a farm number without one, as shares of the number:
/// a planting machine holds its spacing to about 2 %, a canopy's width and height vary more.
inline constexpr double kDefaultSpacingSigmaShare = 0.02;
inline constexpr double kDefaultHalfWidthSigmaShare = 0.15;
inline constexpr double kDefaultRowHeightSigmaShare = 0.05;
inline constexpr double kDefaultFoliageDepthSigmaShare = 0.25;
/// The same for a height above the canopy that something else measured.
inline constexpr double kDefaultHeightSigmaShare = 0.05;

/// Depth maps of the shots, made by a network or a sensor.
struct ProjectDepth {
  std::vector<std::filesystem::path> maps;  ///< each belongs to the shot whose picture has its stem
  bool disparity = true;  ///< a network's sigmoid disparity; false: metres along the optical axis
  double unit_per_count = 1.0 / 65535.0;  ///< of maps in integers
  double scale_sigma = 0.1;               ///< share of itself by which the common scale may be off, one sigma
};

/// project.yaml, read and checked; paths are resolved against its folder.
struct Project {
  std::string name;
  std::filesystem::path file;
  /// Either a model file, or pictures of a board.
  std::filesystem::path camera_model;
  std::vector<std::filesystem::path> board_images;
  std::filesystem::path board_file;
  camera::CameraModel calibrate_model = camera::CameraModel::opencv5;
  bool calibrate_aspect = false;  ///< the board's squares may not be square (a board on a monitor): solve
                                  ///< their aspect, pixels square

  std::vector<std::filesystem::path> images;
  std::optional<std::filesystem::path> telemetry;
  /// Pitch of shots for which neither log nor picture states one, negative below the horizon; NaN: not known.
  double gimbal_pitch_deg = std::numeric_limits<double>::quiet_NaN();
  double gimbal_pitch_sigma_deg = 1.0;  ///< how far the gimbal's pitch may be off, one sigma
  double gimbal_roll_sigma_deg = 1.0;   ///< the same for its roll
  /// Of the angle between the rows' plane and level ground, along and across the rows
  /// (altitude::RefineOptions::terrain_slope_sigma_rad, slope_across_sigma_rad).
  double slope_sigma_deg = 0.5, slope_across_sigma_deg = 3.0;

  rows::Method rows_method = rows::Method::field;
  altitude::FieldKnowledge field;
  std::optional<ProjectDepth> depth;
  /// CSV of half widths in the picture that a person measured, for the thesis's formula.
  std::optional<std::filesystem::path> hand_widths;
};

/// Reads and checks a project file. `${NAME}` in a path is an environment variable; FURROW_DATA defaults to
/// ../shared/data beside the folder that holds `projects/`. Errors: file_*, malformed_yaml, unknown_key
/// (nearest known name and line), missing_key, bad_value, no_match, variable_unset.
Result<Project> read_project(const std::filesystem::path& file);

}  // namespace furrow::project
