#include "furrow/camera/model_files.h"

#include <cmath>
#include <sstream>

#include "camera/literal.h"
#include "camera/other_formats.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/base/value.h"

namespace furrow::camera {
namespace {

using base::Value;

/// A camera model is text of a few kB; mrcal's optimisation inputs reach some MB.
constexpr std::size_t kLargestFileBytes = std::size_t{256} << 20;

Error invalid(const std::string& name, int line, const std::string& found, const std::string& wanted) {
  return {"camera_file_invalid", line > 0 ? name + ":" + std::to_string(line) : name, found, wanted, ""};
}

/// The member under the first of the names that is there.
const Value* first_of(const Value& tree, const std::vector<std::string>& names) {
  for (const std::string& key : names) {
    if (const Value* found = tree.find(key)) return found;
  }
  return nullptr;
}

/// Appends the numbers of a list, nested lists laid out one after the other, up to the first item that is no
/// finite number; that item, or null.
const Value* append_numbers(const Value& value, std::vector<double>& out) {
  if (value.array() == nullptr) {
    const auto number = value.number();
    if (!number || !std::isfinite(*number)) return &value;
    out.push_back(*number);
    return nullptr;
  }
  for (const Value& item : *value.array()) {
    if (const Value* wrong = append_numbers(item, out)) return wrong;
  }
  return nullptr;
}

/// A list of numbers: plain, nested, or OpenCV's and ROS's {rows, cols, data}.
Result<std::vector<double>> numbers(const Value& value, const std::string& key, const std::string& name) {
  const Value* data = value.object() != nullptr ? value.find("data") : &value;
  if (data == nullptr || data->array() == nullptr)
    return invalid(name, value.line, "`" + key + "` is " + value.kind_name(), "a list of numbers");
  std::vector<double> out;
  if (const Value* wrong = append_numbers(*data, out)) {
    const std::string found = wrong->string() != nullptr ? "'" + *wrong->string() + "'"
                              : wrong->number()          ? base::format_double(*wrong->number())
                                                         : wrong->kind_name();
    return invalid(name, wrong->line, "`" + key + "` holds " + found, "finite numbers");
  }
  return out;
}

Result<Camera> checked(Camera camera, const std::string& name) {
  const Status status = validate(camera);
  if (status.ok()) return camera;
  return Error{"camera_file_invalid", name, status.error().found, status.error().wanted, ""};
}

/// Shortest model with room for that many coefficients, in OpenCV's order; OpenCV itself pads with zeros.
std::optional<CameraModel> model_for_count(std::size_t count) {
  switch (count) {
    case 0:
      return CameraModel::pinhole;
    case 4:
      return CameraModel::opencv4;
    case 5:
      return CameraModel::opencv5;
    case 8:
      return CameraModel::opencv8;
    case 12:
      return CameraModel::opencv12;
    default:
      return std::nullopt;
  }
}

/// The number after "NAME=" in mrcal's configured model names, up to `most`.
std::optional<int> configured(const std::string& text, const std::string& key, int most) {
  const std::size_t at = text.find("_" + key + "=");
  if (at == std::string::npos) return std::nullopt;
  const std::size_t start = at + key.size() + 2;
  const auto value = base::parse_int(std::string_view(text).substr(start, text.find('_', start) - start));
  return value && *value >= 0 && *value <= most ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

/// Sets model and grid from mrcal's name; false when the name is none of ours.
bool read_lensmodel(const std::string& full, Camera& camera) {
  const std::string prefix = "LENSMODEL_", splined = prefix + "SPLINED_STEREOGRAPHIC_";
  if (full.starts_with(splined)) {
    constexpr int kMostKnots = 1000, kMostDegrees = 359;
    const auto order = configured(full, "order", 3), columns = configured(full, "Nx", kMostKnots),
               rows = configured(full, "Ny", kMostKnots), fov = configured(full, "fov_x_deg", kMostDegrees);
    if (!order || !columns || !rows || !fov) return false;
    camera.model = CameraModel::splined_stereographic;
    camera.spline = {*order, *columns, *rows, *fov};
    return true;
  }
  const auto model =
      full.starts_with(prefix) ? model_from_name(base::to_lower(full.substr(prefix.size()))) : std::nullopt;
  if (!model || *model == CameraModel::fisheye || *model == CameraModel::splined_stereographic) return false;
  camera.model = *model;
  return true;
}

Result<Camera> from_mrcal(const Value& tree, const std::string& name) {
  const Value* lens = tree.find("lensmodel");
  const Value* values = tree.find("intrinsics");
  const Value* size = first_of(tree, {"imagersize", "imager_size", "dimensions"});
  if (lens == nullptr || lens->string() == nullptr)
    return invalid(name, tree.line, "no `lensmodel`", "its name in quotes");
  if (values == nullptr) return invalid(name, tree.line, "no `intrinsics`", "a list of numbers");
  if (size == nullptr) return invalid(name, tree.line, "no `imagersize`", "[width, height]");
  const std::string full = *lens->string();
  Camera camera;
  if (!read_lensmodel(full, camera)) {
    return Error{"camera_model_unsupported", name + ":" + std::to_string(lens->line), "lens model " + full,
                 "LENSMODEL_PINHOLE, OPENCV4, 5, 8, 12, STEREOGRAPHIC, LATLON or SPLINED_STEREOGRAPHIC",
                 "fit one of these with mrcal-convert-lensmodel"};
  }
  FURROW_TRY(const std::vector<double> p, numbers(*values, "intrinsics", name));
  FURROW_TRY(const std::vector<double> wh, numbers(*size, "imagersize", name));
  const std::size_t wanted = 4 + static_cast<std::size_t>(distortion_count(camera.model, camera.spline));
  if (p.size() != wanted) {
    return invalid(name, values->line, std::to_string(p.size()) + " intrinsics",
                   std::to_string(wanted) + " for " + full);
  }
  constexpr double kLargestSide = 1e6;
  if (wh.size() != 2 || !(wh[0] >= 1 && wh[0] < kLargestSide && wh[1] >= 1 && wh[1] < kLargestSide)) {
    return invalid(name, size->line, "an impossible `imagersize`", "[width, height] in px");
  }
  camera.width = static_cast<int>(wh[0]);
  camera.height = static_cast<int>(wh[1]);
  camera.distortion.resize(p.size() - 4);
  camera = with_intrinsics(camera,
                           Eigen::Map<const Eigen::VectorXd>(p.data(), static_cast<Eigen::Index>(p.size())));
  camera.provenance = "read from a mrcal cameramodel";
  return checked(camera, name);
}

/// Sets width and height from two members.
Status read_size(const Value& tree, const std::string& name, Camera& camera) {
  const Value* width = first_of(tree, {"image_width", "width"});
  const Value* height = first_of(tree, {"image_height", "height"});
  if (const Value* both = first_of(tree, {"image_size", "resolution"}); both != nullptr && width == nullptr) {
    FURROW_TRY(const std::vector<double> wh, numbers(*both, "image_size", name));
    if (wh.size() != 2)
      return invalid(name, both->line, "`image_size` of " + std::to_string(wh.size()), "[width, height]");
    camera.width = static_cast<int>(std::clamp(wh[0], 0.0, 1e6));
    camera.height = static_cast<int>(std::clamp(wh[1], 0.0, 1e6));
    return Done{};
  }
  if (width == nullptr || height == nullptr || !width->integer() || !height->integer()) {
    return invalid(name, tree.line, "no `image_width` and `image_height`", "the size of the pictures in px");
  }
  camera.width = static_cast<int>(std::clamp<std::int64_t>(*width->integer(), 0, 1000000));
  camera.height = static_cast<int>(std::clamp<std::int64_t>(*height->integer(), 0, 1000000));
  return Done{};
}

/// Coefficients in OpenCV's order. Trailing zeros that only pad (OpenCV writes 14) are cut to the shortest
/// model that holds the rest.
Status set_distortion(std::vector<double> k, const Value* line_of, const std::string& name, Camera& camera) {
  const int line = line_of != nullptr ? line_of->line : 0;
  while (!model_for_count(k.size()) && !k.empty() && k.back() == 0.0) k.pop_back();
  while (!model_for_count(k.size()) && k.size() < 12) k.push_back(0.0);
  const auto model = model_for_count(k.size());
  if (!model) {
    return Error{"camera_model_unsupported", line > 0 ? name + ":" + std::to_string(line) : name,
                 std::to_string(k.size()) + " distortion coefficients (a tilted sensor has 14)", "up to 12",
                 ""};
  }
  camera.model = *model;
  camera.distortion = std::move(k);
  return Done{};
}

Status read_covariance(const Value& tree, const std::string& name, Camera& camera) {
  const Value* found = first_of(tree, {"covariance", "intrinsics_covariance"});
  if (found == nullptr || found->is_null()) return Done{};
  FURROW_TRY(const std::vector<double> c, numbers(*found, "covariance", name));
  const auto n = static_cast<Eigen::Index>(4 + camera.distortion.size());
  if (static_cast<Eigen::Index>(c.size()) != n * n) {
    return invalid(name, found->line, "a covariance of " + std::to_string(c.size()) + " numbers",
                   std::to_string(n * n) + " (" + std::to_string(n) + " by " + std::to_string(n) + ")");
  }
  camera.covariance = Eigen::Map<const Eigen::MatrixXd>(c.data(), n, n);
  return Done{};
}

Result<Camera> from_opencv(const Value& tree, const std::string& name) {
  const Value* matrix = first_of(tree, {"camera_matrix", "K", "Camera_Matrix", "cameraMatrix"});
  const Value* lens =
      first_of(tree, {"distortion_coefficients", "D", "Distortion_Coefficients", "distCoeffs"});
  check(matrix != nullptr, "from_opencv: the caller has seen the camera matrix");
  bool fisheye = false;
  if (const Value* model = tree.find("distortion_model"); model != nullptr && model->string() != nullptr) {
    const std::string kind = base::to_lower(*model->string());
    fisheye = kind == "equidistant" || kind == "fisheye" || kind == "kannala_brandt";
  }
  FURROW_TRY(const std::vector<double> k, numbers(*matrix, "camera_matrix", name));
  if (k.size() != 9) {
    return invalid(name, matrix->line, "a camera matrix of " + std::to_string(k.size()) + " numbers",
                   "9, row by row");
  }
  const bool shaped = k[3] == 0.0 && k[6] == 0.0 && k[7] == 0.0 && k[8] == 1.0;
  if (!shaped) return invalid(name, matrix->line, "no camera matrix", "[fx 0 cx; 0 fy cy; 0 0 1]");
  if (k[1] != 0.0) {
    return Error{"camera_model_unsupported", name + ":" + std::to_string(matrix->line),
                 "a camera matrix with skew", "no skew", ""};
  }
  Camera camera;
  camera.fx = k[0];
  camera.cx = k[2];
  camera.fy = k[4];
  camera.cy = k[5];
  FURROW_DO(read_size(tree, name, camera));
  std::vector<double> distortion;
  if (lens != nullptr && !lens->is_null()) {
    FURROW_TRY(distortion, numbers(*lens, "distortion_coefficients", name));
  }
  if (fisheye) {
    if (distortion.size() != 4)
      return invalid(name, lens != nullptr ? lens->line : 0,
                     std::to_string(distortion.size()) + " coefficients", "4 for a fisheye");
    camera.model = CameraModel::fisheye;
    camera.distortion = std::move(distortion);
  } else {
    FURROW_DO(set_distortion(std::move(distortion), lens, name, camera));
  }
  FURROW_DO(read_covariance(tree, name, camera));
  camera.provenance = "read from an OpenCV camera file";
  if (const Value* made = tree.find("provenance"); made != nullptr && made->string() != nullptr)
    camera.provenance = *made->string();
  return checked(camera, name);
}

Result<Camera> from_calibration(const Value& tree, const std::string& name) {
  Camera camera;
  const Value* model = tree.find("model");
  const auto known = model->string() != nullptr ? model_from_name(*model->string()) : std::nullopt;
  if (!known) {
    return Error{"camera_model_unsupported", name + ":" + std::to_string(model->line),
                 "model " + (model->string() != nullptr ? *model->string() : model->kind_name()),
                 "one of " + model_names(), ""};
  }
  camera.model = *known;
  if (const Value* grid = tree.find("spline");
      grid != nullptr && camera.model == CameraModel::splined_stereographic) {
    FURROW_TRY(const std::vector<double> g, numbers(*grid, "spline", name));
    const auto whole = [](double v) { return static_cast<int>(std::clamp(v, 0.0, 1000.0)); };
    if (g.size() != 4)
      return invalid(name, grid->line, "a `spline` of " + std::to_string(g.size()),
                     "[order, columns, rows, fov_x_deg]");
    camera.spline = {whole(g[0]), whole(g[1]), whole(g[2]), whole(g[3])};
  }
  const std::pair<const char*, double Camera::*> core[] = {
      {"fx", &Camera::fx}, {"fy", &Camera::fy}, {"cx", &Camera::cx}, {"cy", &Camera::cy}};
  for (const auto& [key, field] : core) {
    const Value* value = tree.find(key);
    if (value == nullptr || !value->number())
      return invalid(name, tree.line, std::string("no number `") + key + "`", "px");
    camera.*field = *value->number();
  }
  FURROW_DO(read_size(tree, name, camera));
  if (const Value* lens = tree.find("distortion"); lens != nullptr && !lens->is_null()) {
    FURROW_TRY(camera.distortion, numbers(*lens, "distortion", name));
  }
  FURROW_TRY(camera, checked(camera, name));
  FURROW_DO(read_covariance(tree, name, camera));
  camera.provenance = "read from a calibration.json";
  if (const Value* made = tree.find("provenance"); made != nullptr && made->string() != nullptr)
    camera.provenance = *made->string();
  return checked(camera, name);
}

Error unknown_format(const std::string& name, const std::string& found) {
  return {"camera_format_unknown", name, found,
          "a mrcal .cameramodel, an OpenCV or ROS YAML with `camera_matrix`, a Kalibr camchain, a COLMAP "
          "cameras.txt, a "
          "Metashape XML, a Pix4D .cam, MATLAB's text, or a calibration.json with `model` and `fx`",
          ""};
}

Result<Camera> from_tree(const Value& tree, const std::string& name) {
  if (tree.find("lensmodel") != nullptr) return from_mrcal(tree, name);
  if (first_of(tree, {"camera_matrix", "K", "Camera_Matrix", "cameraMatrix"}) != nullptr)
    return from_opencv(tree, name);
  if (tree.find("model") != nullptr && tree.find("fx") != nullptr) return from_calibration(tree, name);
  if (tree.find("cam0") != nullptr) return from_kalibr(tree, name);
  return unknown_format(name, tree.object() != nullptr ? "none of the keys of a camera" : tree.kind_name());
}

/// First character that is neither a blank nor in a '#' comment; 0 when there is none.
char first_mark(std::string_view text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '#') {
      while (i < text.size() && text[i] != '\n') ++i;
    } else if (base::trim(text.substr(i, 1)) != "") {
      return text[i];
    }
  }
  return '\0';
}

void append_list(std::ostringstream& out, const double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out << (i > 0 ? ", " : "") << base::format_double(values[i]);
}

/// OpenCV's reader takes a list for numbers only when each has a point or an exponent where type d is asked.
std::string opencv_matrix(const std::string& key, Eigen::Index rows, Eigen::Index cols,
                          const std::vector<double>& values) {
  std::ostringstream out;
  out << key << ": !!opencv-matrix\n   rows: " << rows << "\n   cols: " << cols << "\n   dt: d\n   data: [ ";
  append_list(out, values.data(), values.size());
  out << " ]\n";
  return out.str();
}

/// A YAML text in double quotes on one line.
std::string quoted_text(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += (c == '\n' || c == '\r') ? ' ' : c;
  }
  return out + "\"";
}

}  // namespace

Result<Camera> parse_camera(const std::string& text, const std::string& name) {
  if (text.starts_with("\xFF\xD8")) return from_dji_picture(text, name);
  const char mark = first_mark(text);
  if (mark == '\0') return unknown_format(name, "an empty file");
  if (mark == '{') {
    // JSON and mrcal's Python literal both open with a brace; only JSON passes as JSON.
    if (const auto json = base::parse_json(text, name); json.ok()) return from_tree(*json, name);
    FURROW_TRY(const Value tree, parse_literal(text, name));
    return from_tree(tree, name);
  }
  if (mark == '<') return from_metashape(text, name);
  if (looks_like_pix4d(text)) return from_pix4d(text, name);
  if (looks_like_colmap(text)) return from_colmap(text, name);
  if (looks_like_matlab(text)) return from_matlab(text, name);
  FURROW_TRY(const Value tree, base::parse_yaml(text, name));
  return from_tree(tree, name);
}

Result<Camera> read_camera(const std::filesystem::path& file) {
  FURROW_TRY(const std::string text, base::read_file(file, kLargestFileBytes));
  return parse_camera(text, file.string());
}

std::string mrcal_lensmodel(const Camera& camera) {
  check(camera.model != CameraModel::fisheye, "mrcal has no Kannala-Brandt fisheye");
  std::string upper = model_name(camera.model);
  for (char& c : upper) c = (c >= 'a' && c <= 'z') ? static_cast<char>(c - 'a' + 'A') : c;
  if (camera.model == CameraModel::splined_stereographic) {
    upper += "_order=" + std::to_string(camera.spline.order) +
             "_Nx=" + std::to_string(camera.spline.columns) + "_Ny=" + std::to_string(camera.spline.rows) +
             "_fov_x_deg=" + std::to_string(camera.spline.fov_x_deg);
  }
  return "LENSMODEL_" + upper;
}

std::string to_mrcal_cameramodel(const Camera& camera, const std::string& optimization_inputs) {
  const Eigen::VectorXd p = intrinsics(camera);
  std::ostringstream out;
  out << "{\n    'lensmodel':  '" << mrcal_lensmodel(camera) << "',\n\n"
      << "    # intrinsics are fx,fy,cx,cy,distortion0,distortion1,....\n    'intrinsics': [ ";
  append_list(out, p.data(), static_cast<std::size_t>(p.size()));
  out << ",],\n\n    # extrinsics are rt_fromref\n    'extrinsics': [ 0, 0, 0, 0, 0, 0,],\n\n"
      << "    'imagersize': [ " << camera.width << ", " << camera.height << ",],\n";
  if (!optimization_inputs.empty()) {
    out << "    'icam_intrinsics': 0,\n\n"
        << "    # what was solved, for mrcal's own tools: numpy's npz in base 85\n"
        << "    'optimization_inputs': b'" << optimization_inputs << "',\n";
  }
  out << "}\n";
  return out.str();
}

std::string to_opencv_yaml(const Camera& camera) {
  std::ostringstream out;
  out << "%YAML:1.0\n---\n";
  if (!camera.provenance.empty()) out << "provenance: " << quoted_text(camera.provenance) << "\n";
  out << "image_width: " << camera.width << "\nimage_height: " << camera.height << "\n";
  out << opencv_matrix("camera_matrix", 3, 3, {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1});
  const bool fisheye = camera.model == CameraModel::fisheye, rational = camera.distortion.size() > 5;
  out << "distortion_model: "
      << (fisheye    ? "equidistant"
          : rational ? "rational_polynomial"
                     : "plumb_bob")
      << "\n";
  // An empty matrix is not readable everywhere; zeros say the same.
  std::vector<double> k = camera.distortion;
  if (k.empty()) k.assign(static_cast<std::size_t>(distortion_count(CameraModel::opencv5)), 0.0);
  out << opencv_matrix("distortion_coefficients", static_cast<Eigen::Index>(k.size()), 1, k);
  if (camera.covariance.size() > 0) {
    const std::vector<double> c(camera.covariance.data(),
                                camera.covariance.data() + camera.covariance.size());
    out << opencv_matrix("intrinsics_covariance", camera.covariance.rows(), camera.covariance.cols(), c);
  }
  return out.str();
}

}  // namespace furrow::camera
