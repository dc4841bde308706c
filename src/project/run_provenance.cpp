#include "project/run_provenance.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "project/manifest.h"

namespace furrow::project {

namespace fs = std::filesystem;

std::vector<std::string> camera_words(const Camera& camera, const std::vector<ShotResult>& results) {
  std::vector<std::string> words;
  if (!camera.provenance.empty()) words.push_back("Source: " + camera.provenance + ".");
  std::vector<std::string> seen;
  for (const ShotResult& result : results) {
    if (!result.camera || result.camera->provenance == camera.provenance) continue;
    if (std::find(seen.begin(), seen.end(), result.camera->provenance) != seen.end()) continue;
    seen.push_back(result.camera->provenance);
    words.push_back("For the shots: " + result.camera->provenance + ".");
  }
  return words;
}

std::vector<std::string> log_words(const Project& project, const std::optional<telemetry::Track>& track,
                                   const sync::Located& located, const std::vector<telemetry::Shot>& shots) {
  std::vector<std::string> words;
  if (track) {
    words.push_back(project.telemetry->filename().string() + ": " + track->format + ", " +
                    std::to_string(track->samples.size()) + " rows.");
    words.insert(words.end(), track->warnings.begin(), track->warnings.end());
  } else {
    words.push_back("No log is given; what the pictures' own metadata say is used.");
  }
  words.push_back("Shots were placed by: " + located.method + ".");
  words.insert(words.end(), located.warnings.begin(), located.warnings.end());
  for (const auto& shot : shots) {
    for (const auto& warning : shot.warnings) words.push_back(shot.shot_id + ": " + warning);
  }
  return words;
}

base::Value options_value(const Project& project) {
  const auto length = [](const Estimate& e) {
    base::Value value;
    value.set("value", e.value);
    value.set("sigma", e.sigma);
    return value;
  };
  base::Value value;
  value.set("name", project.name);
  value.set("rows_method", project.rows_method == rows::Method::thesis ? "thesis" : "field");
  value.set("spacing_m", length(project.field.row_spacing_m));
  value.set("half_width_m", length(project.field.half_width_m));
  value.set("height_m", length(project.field.row_height_m));
  value.set("foliage_depth_m", length(project.field.foliage_depth_m));
  value.set("outline_rise_m", length(project.field.outline_rise_m));
  value.set("slope_sigma_deg", project.slope_sigma_deg);
  value.set("slope_across_sigma_deg", project.slope_across_sigma_deg);
  if (std::isfinite(project.gimbal_pitch_deg)) value.set("gimbal_pitch_deg", project.gimbal_pitch_deg);
  value.set("gimbal_pitch_sigma_deg", project.gimbal_pitch_sigma_deg);
  value.set("gimbal_roll_sigma_deg", project.gimbal_roll_sigma_deg);
  return value;
}

base::Value inputs_value(const Project& project) {
  std::vector<fs::path> files = {project.file};
  if (!project.camera_model.empty()) files.push_back(project.camera_model);
  if (!project.board_file.empty()) files.push_back(project.board_file);
  files.insert(files.end(), project.board_images.begin(), project.board_images.end());
  if (project.telemetry) files.push_back(*project.telemetry);
  if (project.hand_widths) files.push_back(*project.hand_widths);
  files.insert(files.end(), project.images.begin(), project.images.end());
  return hash_inputs(files);
}

}  // namespace furrow::project
