#include "furrow/project/project.h"

#include <cmath>
#include <cstdlib>
#include <limits>

#include "furrow/base/fields.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/image/video.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;
using base::Fields;
using base::Value;

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// A list of pictures that names none is a slip, not a flight without pictures.
void read_patterns(Fields& fields, const std::string& key, std::vector<std::string>& patterns) {
  fields.required(key, patterns);
  fields.require(!patterns.empty(), key, "an empty list", "a pattern, or a list of them");
}

/// Environment variables in a path, with FURROW_DATA's default.
Result<std::string> expand(std::string text, const fs::path& folder) {
  static const std::string kData = "${FURROW_DATA}";
  if (std::getenv("FURROW_DATA") == nullptr) {
    const std::string data = (folder / "../../../shared/data").lexically_normal().string();
    for (auto at = text.find(kData); at != std::string::npos; at = text.find(kData))
      text.replace(at, kData.size(), data);
  }
  return base::expand_environment(text);
}

Result<fs::path> resolve(const std::string& text, const fs::path& folder) {
  FURROW_TRY(const std::string expanded, expand(text, folder));
  return (folder / expanded).lexically_normal();
}

Result<std::vector<fs::path>> resolve_images(const std::vector<std::string>& patterns,
                                             const fs::path& folder) {
  std::vector<fs::path> named;
  for (const std::string& pattern : patterns) {
    FURROW_TRY(fs::path one, resolve(pattern, folder));
    named.push_back(std::move(one));
  }
  return image::picture_files(named);
}

Status read_calibrate(const Value& value, const std::string& file, const fs::path& folder, Project& project) {
  Fields fields(value, file, "camera.calibrate");
  std::vector<std::string> images;
  std::string target;
  std::string model;
  std::string squares = "square";
  read_patterns(fields, "images", images);
  fields.required("target", target);
  fields.optional("model", model);
  fields.optional("squares", squares);
  fields.require(squares == "square" || squares == "unknown_aspect", "squares", "'" + squares + "'",
                 "square or unknown_aspect");
  if (!model.empty()) {
    const auto known = camera::model_from_name(model);
    fields.require(known.has_value(), "model", "'" + model + "'", camera::model_names());
    if (known) project.calibrate_model = *known;
  }
  FURROW_DO(fields.finish());
  project.calibrate_aspect = squares == "unknown_aspect";
  FURROW_TRY(project.board_images, resolve_images(images, folder));
  FURROW_TRY(project.board_file, resolve(target, folder));
  return Done{};
}

Status read_camera_section(const Value& value, const std::string& file, const fs::path& folder,
                           Project& project) {
  Fields fields(value, file, "camera");
  std::string model;
  fields.optional("model", model);
  const Value* calibrate = fields.member("calibrate");
  FURROW_DO(fields.finish());
  if (model.empty() == (calibrate == nullptr)) {
    return Error{"bad_value", file + ":" + std::to_string(value.line),
                 model.empty() ? "camera has neither 'model' nor 'calibrate'"
                               : "camera has both 'model' and 'calibrate'",
                 "one of them: a model file, or pictures of a board", ""};
  }
  if (calibrate != nullptr) return read_calibrate(*calibrate, file, folder, project);
  FURROW_TRY(project.camera_model, resolve(model, folder));
  return Done{};
}

Status read_telemetry(const Value& value, const std::string& file, const fs::path& folder, Project& project) {
  Fields fields(value, file, "telemetry");
  std::string log;
  fields.optional("file", log);
  fields.optional("gimbal_pitch_deg", project.gimbal_pitch_deg);
  fields.require(!(project.gimbal_pitch_deg < -90.0 || project.gimbal_pitch_deg > 0.0), "gimbal_pitch_deg",
                 base::format_double(project.gimbal_pitch_deg),
                 "an angle from -90 (straight down) to 0 (the horizon)");
  fields.optional("gimbal_pitch_sigma_deg", project.gimbal_pitch_sigma_deg);
  fields.optional("gimbal_roll_sigma_deg", project.gimbal_roll_sigma_deg);
  for (const auto& [key, sigma] : {std::pair{"gimbal_pitch_sigma_deg", project.gimbal_pitch_sigma_deg},
                                   std::pair{"gimbal_roll_sigma_deg", project.gimbal_roll_sigma_deg}}) {
    fields.require(sigma > 0.0, key, base::format_double(sigma), "an angle above 0");
  }
  FURROW_DO(fields.finish());
  if (log.empty()) return Done{};
  FURROW_TRY(project.telemetry, resolve(log, folder));
  return Done{};
}

/// No crop stands in rows farther apart, or higher: a larger number is one of another unit. Nor do plants of
/// two rows fit into less than a millimetre.
constexpr double kLongest_m = 100.0, kShortest_m = 0.001;

/// `key` and `stem_sigma_m` as an Estimate; the sigma defaults to a share of the value.
Estimate read_length(Fields& fields, const std::string& stem, double default_share) {
  double value = kNotGiven;
  double sigma = kNotGiven;
  fields.optional(stem + "_m", value);
  fields.optional(stem + "_sigma_m", sigma);
  if (std::isnan(value)) {
    fields.require(std::isnan(sigma), stem + "_sigma_m", "given without " + stem + "_m", "both or none");
    return {};
  }
  fields.require(value >= kShortest_m && value <= kLongest_m, stem + "_m", base::format_double(value),
                 "metres, from 0.001 to 100");
  fields.require(std::isnan(sigma) || sigma >= 0.0, stem + "_sigma_m", base::format_double(sigma),
                 "a length of 0 or more");
  return {value, std::isnan(sigma) ? default_share * value : sigma, 1};
}

/// The rise may be 0 or below, so its sigma has no share to default to.
Estimate read_outline_rise(Fields& fields) {
  double value = kNotGiven;
  double sigma = kNotGiven;
  fields.optional("outline_rise_m", value);
  fields.optional("outline_rise_sigma_m", sigma);
  fields.require(std::isnan(value) == std::isnan(sigma), "outline_rise_m",
                 "one of outline_rise_m and outline_rise_sigma_m", "both or none");
  fields.require(std::isnan(sigma) || sigma >= 0.0, "outline_rise_sigma_m", base::format_double(sigma),
                 "a length of 0 or more");
  return std::isnan(value) ? Estimate{} : Estimate{value, sigma, 1};
}

Status read_rows(const Value& value, const std::string& file, const fs::path& folder, Project& project) {
  Fields fields(value, file, "rows");
  project.field.row_spacing_m = read_length(fields, "spacing", kDefaultSpacingSigmaShare);
  project.field.half_width_m = read_length(fields, "half_width", kDefaultHalfWidthSigmaShare);
  project.field.row_height_m = read_length(fields, "height", kDefaultRowHeightSigmaShare);
  project.field.foliage_depth_m = read_length(fields, "foliage_depth", kDefaultFoliageDepthSigmaShare);
  project.field.outline_rise_m = read_outline_rise(fields);
  if (const Status apart = altitude::rows_apart(project.field); !apart.ok())
    fields.fail("half_width_m", apart.error().found, apart.error().wanted);
  const auto slope = [&](const char* name, double& sigma_deg) {
    fields.optional(name, sigma_deg);
    fields.require(sigma_deg > 0.0, name, base::format_double(sigma_deg), "an angle above 0");
  };
  slope("slope_sigma_deg", project.slope_sigma_deg);
  slope("slope_across_sigma_deg", project.slope_across_sigma_deg);
  std::string method = "field";
  fields.optional("method", method);
  fields.require(method == "field" || method == "thesis", "method", "'" + method + "'", "field or thesis");
  project.rows_method = method == "thesis" ? rows::Method::thesis : rows::Method::field;
  std::string hand_widths;
  fields.optional("hand_widths", hand_widths);
  FURROW_DO(fields.finish());
  if (hand_widths.empty()) return Done{};
  FURROW_TRY(project.hand_widths, resolve(hand_widths, folder));
  return Done{};
}

Status read_depth(const Value& value, const std::string& file, const fs::path& folder, Project& project) {
  Fields fields(value, file, "depth");
  ProjectDepth depth;
  std::vector<std::string> maps;
  std::string values = "disparity";
  double unit_per_count = kNotGiven;
  read_patterns(fields, "maps", maps);
  fields.optional("values", values);
  fields.optional("unit_per_count", unit_per_count);
  fields.optional("scale_sigma", depth.scale_sigma);
  fields.require(values == "disparity" || values == "metres", "values", "'" + values + "'",
                 "disparity or metres");
  fields.require(std::isnan(unit_per_count) || unit_per_count > 0.0, "unit_per_count",
                 base::format_double(unit_per_count), "a number above 0");
  fields.require(depth.scale_sigma > 0.0, "scale_sigma", base::format_double(depth.scale_sigma),
                 "a share above 0");
  FURROW_DO(fields.finish());
  depth.disparity = values == "disparity";
  // Disparities fill the 16 bits; metres come in KITTI's steps.
  constexpr double kFull = 65535.0, kKitti = 256.0;
  depth.unit_per_count =
      !std::isnan(unit_per_count) ? unit_per_count : 1.0 / (depth.disparity ? kFull : kKitti);
  FURROW_TRY(depth.maps, resolve_images(maps, folder));
  project.depth = std::move(depth);
  return Done{};
}

}  // namespace

Result<Project> read_project(const fs::path& file) {
  FURROW_TRY(const Value root, base::read_yaml(file));
  const std::string name = file.filename().string();
  const fs::path folder = fs::absolute(file).parent_path();
  Project project;
  project.file = file;
  Fields fields(root, name, "");
  fields.required("name", project.name);
  const Value* camera = fields.member("camera");
  const Value* shots = fields.member("shots");
  const Value* telemetry = fields.member("telemetry");
  const Value* rows = fields.member("rows");
  const Value* depth = fields.member("depth");
  FURROW_DO(fields.finish());
  for (const auto& [key, found] : {std::pair{"camera", camera}, std::pair{"shots", shots}}) {
    if (found == nullptr) return Error{"missing_key", name, std::string("'") + key + "' is missing", "", ""};
  }
  FURROW_DO(read_camera_section(*camera, name, folder, project));
  std::vector<std::string> patterns;
  Fields shot_fields(*shots, name, "shots");
  read_patterns(shot_fields, "images", patterns);
  FURROW_DO(shot_fields.finish());
  FURROW_TRY(project.images, resolve_images(patterns, folder));
  if (telemetry != nullptr) FURROW_DO(read_telemetry(*telemetry, name, folder, project));
  if (rows != nullptr) FURROW_DO(read_rows(*rows, name, folder, project));
  if (depth != nullptr) FURROW_DO(read_depth(*depth, name, folder, project));
  return project;
}

}  // namespace furrow::project
