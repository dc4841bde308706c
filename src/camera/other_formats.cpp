#include "camera/other_formats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

#include "furrow/base/text.h"
#include "furrow/camera/model_files.h"

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
constexpr std::array<ColmapModel, 6> kColmapModels{{{"SIMPLE_PINHOLE", "fuv", CameraModel::pinhole},
                                                    {"PINHOLE", "xyuv", CameraModel::pinhole},
                                                    {"SIMPLE_RADIAL", "fuv1", CameraModel::opencv4},
                                                    {"RADIAL", "fuv12", CameraModel::opencv4},
                                                    {"OPENCV", "xyuv1234", CameraModel::opencv4},
                                                    {"FULL_OPENCV", "xyuv12345678", CameraModel::opencv8}}};

Error invalid(const std::string& where, const std::string& found, const std::string& wanted) {
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
    return invalid(name + ":" + std::to_string(found != nullptr ? found->line : tree.line), "no such list",
                   wanted);
  }
  std::vector<double> out;
  for (const Value& item : *found->array()) {
    const auto number = item.number();
    if (!number || !std::isfinite(*number))
      return invalid(name + ":" + std::to_string(item.line), item.kind_name(), wanted);
    out.push_back(*number);
  }
  return out;
}

std::string joined(const std::vector<double>& values, const char* between) {
  std::string out;
  for (const double v : values) out += (out.empty() ? "" : between) + base::format_double(v);
  return out;
}

Error cannot_hold(const std::string& format, const std::string& what) {
  return {"camera_export_failed", format, what, "a lens this format can hold",
          "calibrate with a smaller model"};
}

std::string to_ros(const Camera& camera) {
  std::vector<double> d = camera.distortion;
  d.resize(d.size() > 5 ? 8 : 5, 0.0);
  std::ostringstream out;
  const auto matrix = [&](const char* key, int rows, int cols, const std::vector<double>& values) {
    out << key << ":\n  rows: " << rows << "\n  cols: " << cols << "\n  data: [" << joined(values, ", ")
        << "]\n";
  };
  out << "image_width: " << camera.width << "\nimage_height: " << camera.height << "\ncamera_name: camera\n";
  matrix("camera_matrix", 3, 3, {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1});
  out << "distortion_model: " << (d.size() > 5 ? "rational_polynomial" : "plumb_bob") << "\n";
  matrix("distortion_coefficients", 1, static_cast<int>(d.size()), d);
  matrix("rectification_matrix", 3, 3, {1, 0, 0, 0, 1, 0, 0, 0, 1});
  matrix("projection_matrix", 3, 4, {camera.fx, 0, camera.cx, 0, 0, camera.fy, camera.cy, 0, 0, 0, 1, 0});
  return out.str();
}

std::string to_kalibr(const Camera& camera) {
  std::vector<double> d = camera.distortion;
  d.resize(4, 0.0);
  std::ostringstream out;
  out << "cam0:\n  camera_model: pinhole\n  intrinsics: ["
      << joined({camera.fx, camera.fy, camera.cx, camera.cy}, ", ")
      << "]\n  distortion_model: radtan\n  distortion_coeffs: [" << joined(d, ", ") << "]\n  resolution: ["
      << camera.width << ", " << camera.height << "]\n";
  return out.str();
}

std::string to_colmap(const Camera& camera) {
  std::vector<double> p{camera.fx, camera.fy, camera.cx + kColmapShiftPx, camera.cy + kColmapShiftPx};
  const std::size_t n = camera.distortion.size();
  std::vector<double> d = camera.distortion;
  d.resize(n == 0 ? 0 : (n > 4 ? 8 : 4), 0.0);
  p.insert(p.end(), d.begin(), d.end());
  const char* model = n == 0 ? "PINHOLE" : (n > 4 ? "FULL_OPENCV" : "OPENCV");
  return "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n1 " + std::string(model) + " " +
         std::to_string(camera.width) + " " + std::to_string(camera.height) + " " + joined(p, " ") + "\n";
}

/// Largest distance between the two cameras' pixels over a grid on the picture, px; infinite when one of them
/// has none.
double largest_difference_px(const Camera& a, const Camera& b) {
  double worst = 0.0;
  constexpr int kPlaces = 12;
  for (int j = 0; j <= kPlaces; ++j) {
    for (int i = 0; i <= kPlaces; ++i) {
      const auto xy = unproject(a, {(a.width - 1.0) * i / kPlaces, (a.height - 1.0) * j / kPlaces});
      if (!xy) continue;
      const Eigen::Vector3d ray(xy->x(), xy->y(), 1.0);
      const auto in_a = project(a, ray), in_b = project(b, ray);
      if (!in_a || !in_b) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, (*in_a - *in_b).norm());
    }
  }
  return worst;
}

/// What the format cannot hold of this camera; empty when it holds all.
std::string what_is_lost(const Camera& camera, CameraFormat format) {
  const auto any_beyond = [&](std::size_t count) {
    for (std::size_t i = count; i < camera.distortion.size(); ++i) {
      if (camera.distortion[i] != 0.0) return true;
    }
    return false;
  };
  if (format == CameraFormat::kalibr && any_beyond(4))
    return "radtan has k1 k2 p1 p2 only; this lens has more";
  if ((format == CameraFormat::colmap || format == CameraFormat::ros) && any_beyond(8))
    return "no thin prism coefficients there";
  return "";
}

}  // namespace

Result<Camera> from_kalibr(const Value& tree, const std::string& name) {
  const Value& cam = *tree.find("cam0");
  const auto word = [&](const char* key) {
    const Value* found = cam.find(key);
    return found != nullptr && found->string() != nullptr ? *found->string() : std::string();
  };
  const std::string lens = word("distortion_model");
  if (word("camera_model") != "pinhole" || (lens != "radtan" && lens != "none")) {
    return Error{"camera_model_unsupported", name + ":" + std::to_string(cam.line),
                 word("camera_model") + " with " + lens, "pinhole with radtan or none", ""};
  }
  FURROW_TRY(const std::vector<double> f, list_of(cam, "intrinsics", 4, name));
  FURROW_TRY(const std::vector<double> wh, list_of(cam, "resolution", 2, name));
  Camera camera;
  camera.model = lens == "none" ? CameraModel::pinhole : CameraModel::opencv4;
  if (lens == "radtan") {
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
  if (model == nullptr) return invalid(where, "no camera", "ID MODEL WIDTH HEIGHT PARAMS...");
  const std::string parameters = model->parameters;
  if (words.size() != 4 + parameters.size()) {
    return invalid(where, std::to_string(words.size() - 4) + " parameters",
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
    if (!value) return invalid(where, "'" + words[4 + i] + "'", "a number");
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

std::optional<CameraFormat> format_from_name(const std::string& name) {
  const std::array<std::pair<const char*, CameraFormat>, 5> names{{{"mrcal", CameraFormat::mrcal},
                                                                   {"opencv", CameraFormat::opencv},
                                                                   {"ros", CameraFormat::ros},
                                                                   {"kalibr", CameraFormat::kalibr},
                                                                   {"colmap", CameraFormat::colmap}}};
  for (const auto& [known, format] : names) {
    if (name == known) return format;
  }
  return std::nullopt;
}

Result<std::string> export_camera(const Camera& camera, CameraFormat format) {
  FURROW_DO(validate(camera));
  if (const std::string lost = what_is_lost(camera, format); !lost.empty())
    return cannot_hold("camera", lost);
  std::string text;
  switch (format) {
    case CameraFormat::mrcal:
      text = to_mrcal_cameramodel(camera);
      break;
    case CameraFormat::opencv:
      text = to_opencv_yaml(camera);
      break;
    case CameraFormat::ros:
      text = to_ros(camera);
      break;
    case CameraFormat::kalibr:
      text = to_kalibr(camera);
      break;
    case CameraFormat::colmap:
      text = to_colmap(camera);
      break;
  }
  FURROW_TRY(const Camera back, parse_camera(text, "export"));
  constexpr double kLargestDifferencePx = 1e-6;
  const double difference_px = largest_difference_px(camera, back);
  if (!(difference_px <= kLargestDifferencePx)) {
    return cannot_hold("camera",
                       "pixels move by " + base::format_double(difference_px) + " px when it is read back");
  }
  return text;
}

}  // namespace furrow::camera
