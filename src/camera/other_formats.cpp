#include "camera/other_formats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "furrow/base/text.h"

namespace furrow::camera {
namespace {

using base::Value;

/// COLMAP counts the corner of the top-left pixel as (0, 0), we its centre.
constexpr double kColmapShiftPx = 0.5;

/// Where each parameter of a COLMAP model goes: f means fx and fy.
struct ColmapModel {
  const char* name;
  const char* parameters;  ///< one letter a parameter: f, x (fx), y (fy), u (cx), v (cy), then 1.. for
                           ///< coefficients in OpenCV's order
  CameraModel model;
};
constexpr std::array<ColmapModel, 9> kColmapModels{{{"SIMPLE_PINHOLE", "fuv", CameraModel::pinhole},
                                                    {"PINHOLE", "xyuv", CameraModel::pinhole},
                                                    {"SIMPLE_RADIAL", "fuv1", CameraModel::opencv4},
                                                    {"RADIAL", "fuv12", CameraModel::opencv4},
                                                    {"OPENCV", "xyuv1234", CameraModel::opencv4},
                                                    {"FULL_OPENCV", "xyuv12345678", CameraModel::opencv8},
                                                    {"OPENCV_FISHEYE", "xyuv1234", CameraModel::fisheye},
                                                    {"SIMPLE_RADIAL_FISHEYE", "fuv1", CameraModel::fisheye},
                                                    {"RADIAL_FISHEYE", "fuv12", CameraModel::fisheye}}};

Error invalid_at(const std::string& where, const std::string& found, const std::string& wanted) {
  return {"camera_file_invalid", where, found, wanted, ""};
}

/// Words of the first line that is neither empty nor a comment, with its number.
std::vector<std::string> first_words(const std::string& text, int& line) {
  line = 0;
  for (const std::string_view row : base::split(text, '\n')) {
    ++line;
    const std::string_view trimmed = base::trim(row);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    std::istringstream stream{std::string(trimmed)};
    std::vector<std::string> words;
    // The longest model has 16 words; more is no camera.
    constexpr std::size_t kMostWords = 32;
    for (std::string word; words.size() < kMostWords && stream >> word;) words.push_back(word);
    return words;
  }
  return {};
}

const ColmapModel* colmap_model(const std::string& name) {
  for (const ColmapModel& model : kColmapModels) {
    if (name == model.name) return &model;
  }
  return nullptr;
}

Result<std::vector<double>> list_of(const Value& tree, const char* key, std::size_t count,
                                    const std::string& name) {
  const Value* found = tree.find(key);
  const std::string wanted = "`" + std::string(key) + "` with " + std::to_string(count) + " numbers";
  if (found == nullptr || found->array() == nullptr || found->array()->size() != count) {
    return invalid_at(name + ":" + std::to_string(found != nullptr ? found->line : tree.line), "no such list",
                      wanted);
  }
  std::vector<double> out;
  for (const Value& item : *found->array()) {
    const auto number = item.number();
    if (!number || !std::isfinite(*number))
      return invalid_at(name + ":" + std::to_string(item.line), item.kind_name(), wanted);
    out.push_back(*number);
  }
  return out;
}

std::string joined(const std::vector<double>& values, const char* between) {
  std::string out;
  for (const double v : values) out += (out.empty() ? "" : between) + base::format_double(v);
  return out;
}

/// OpenCV's coefficients, or a fisheye's four, filled with zeros to `count`.
std::vector<double> padded(const Camera& camera, std::size_t count) {
  std::vector<double> d = camera.distortion;
  d.resize(count, 0.0);
  return d;
}

}  // namespace

std::string to_ros(const Camera& camera) {
  const bool fisheye = camera.model == CameraModel::fisheye, rational = camera.distortion.size() > 5;
  const std::vector<double> d = padded(camera, fisheye ? 4 : (rational ? 8 : 5));
  std::ostringstream out;
  const auto matrix = [&](const char* key, int rows, int cols, const std::vector<double>& values) {
    out << key << ":\n  rows: " << rows << "\n  cols: " << cols << "\n  data: [" << joined(values, ", ")
        << "]\n";
  };
  out << "image_width: " << camera.width << "\nimage_height: " << camera.height << "\ncamera_name: camera\n";
  matrix("camera_matrix", 3, 3, {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1});
  out << "distortion_model: " << (fisheye ? "equidistant" : (rational ? "rational_polynomial" : "plumb_bob"))
      << "\n";
  matrix("distortion_coefficients", 1, static_cast<int>(d.size()), d);
  matrix("rectification_matrix", 3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  matrix("projection_matrix", 3, 4, {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0});
  return out.str();
}

std::string to_kalibr(const Camera& camera) {
  const bool fisheye = camera.model == CameraModel::fisheye;
  const std::vector<double> d = padded(camera, 4);
  std::ostringstream out;
  out << "cam0:\n  camera_model: pinhole\n  intrinsics: ["
      << joined({camera.fx, camera.fy, camera.cx, camera.cy}, ", ")
      << "]\n  distortion_model: " << (fisheye ? "equidistant" : "radtan") << "\n  distortion_coeffs: ["
      << joined(d, ", ") << "]\n  resolution: [" << camera.width << ", " << camera.height << "]\n";
  return out.str();
}

std::string to_colmap(const Camera& camera) {
  std::vector<double> p{camera.fx, camera.fy, camera.cx + kColmapShiftPx, camera.cy + kColmapShiftPx};
  const std::size_t n = camera.distortion.size();
  const std::vector<double> d = padded(camera, n == 0 ? 0 : (n > 4 ? 8 : 4));
  p.insert(p.end(), d.begin(), d.end());
  const bool fisheye = camera.model == CameraModel::fisheye;
  const char* model = n == 0 ? "PINHOLE" : (fisheye ? "OPENCV_FISHEYE" : (n > 4 ? "FULL_OPENCV" : "OPENCV"));
  return "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 " + std::string(model) + " " +
         std::to_string(camera.width) + " " + std::to_string(camera.height) + " " + joined(p, " ") + "\n";
}

Result<Camera> from_kalibr(const Value& tree, const std::string& name) {
  const Value& cam = *tree.find("cam0");
  const auto word = [&](const char* key) {
    const Value* found = cam.find(key);
    return found != nullptr && found->string() != nullptr ? *found->string() : std::string();
  };
  const std::string lens = word("distortion_model");
  if (word("camera_model") != "pinhole" || (lens != "radtan" && lens != "none" && lens != "equidistant")) {
    return Error{"camera_model_unsupported", name + ":" + std::to_string(cam.line),
                 word("camera_model") + " with " + lens, "pinhole with radtan, equidistant or none", ""};
  }
  FURROW_TRY(const std::vector<double> f, list_of(cam, "intrinsics", 4, name));
  FURROW_TRY(const std::vector<double> wh, list_of(cam, "resolution", 2, name));
  Camera camera;
  camera.model = lens == "none" ? CameraModel::pinhole
                                : (lens == "radtan" ? CameraModel::opencv4 : CameraModel::fisheye);
  if (lens != "none") {
    FURROW_TRY(camera.distortion, list_of(cam, "distortion_coeffs", 4, name));
  }
  constexpr double kLargestSide = 1e6;
  camera.width = static_cast<int>(std::clamp(wh[0], 0.0, kLargestSide));
  camera.height = static_cast<int>(std::clamp(wh[1], 0.0, kLargestSide));
  camera.fx = f[0];
  camera.fy = f[1];
  camera.cx = f[2];
  camera.cy = f[3];
  camera.provenance = "read from a Kalibr camchain";
  FURROW_DO(validate(camera));
  return camera;
}

bool looks_like_colmap(const std::string& text) {
  int line = 0;
  const std::vector<std::string> words = first_words(text, line);
  return words.size() >= 4 && base::parse_int(words[0]) && colmap_model(words[1]) != nullptr;
}

Result<Camera> from_colmap(const std::string& text, const std::string& name) {
  int line = 0;
  const std::vector<std::string> words = first_words(text, line);
  const std::string where = name + ":" + std::to_string(line);
  const ColmapModel* model = words.size() >= 4 ? colmap_model(words[1]) : nullptr;
  if (model == nullptr) return invalid_at(where, "no camera", "ID MODEL WIDTH HEIGHT PARAMS...");
  const std::string parameters = model->parameters;
  if (words.size() != 4 + parameters.size()) {
    return invalid_at(where, std::to_string(words.size() - 4) + " parameters",
                      std::to_string(parameters.size()) + " for " + model->name);
  }
  Camera camera;
  camera.model = model->model;
  camera.distortion.assign(static_cast<std::size_t>(distortion_count(camera.model)), 0.0);
  constexpr std::int64_t kLargestSide = 1000000;
  camera.width =
      static_cast<int>(std::clamp<std::int64_t>(base::parse_int(words[2]).value_or(0), 0, kLargestSide));
  camera.height =
      static_cast<int>(std::clamp<std::int64_t>(base::parse_int(words[3]).value_or(0), 0, kLargestSide));
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto value = base::parse_double(words[4 + i]);
    if (!value) return invalid_at(where, "'" + words[4 + i] + "'", "a number");
    const char place = parameters[i];
    if (place == 'f' || place == 'x') camera.fx = *value;
    if (place == 'f' || place == 'y') camera.fy = *value;
    if (place == 'u') camera.cx = *value - kColmapShiftPx;
    if (place == 'v') camera.cy = *value - kColmapShiftPx;
    if (place >= '1' && place <= '8') camera.distortion[static_cast<std::size_t>(place - '1')] = *value;
  }
  camera.provenance = "read from a COLMAP cameras.txt";
  FURROW_DO(validate(camera));
  return camera;
}

}  // namespace furrow::camera
