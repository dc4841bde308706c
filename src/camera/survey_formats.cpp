// Camera files of surveying programs, and what DJI writes into its pictures.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <sstream>

#include "camera/other_formats.h"
#include "furrow/base/text.h"
#include "furrow/image/image.h"

namespace furrow::camera {
namespace {

/// Programs that count the corner of the top-left pixel as (0, 0); ours is its centre.
constexpr double kCornerShiftPx = 0.5;
constexpr double kLargestSide = 1e6;

Error invalid_file(const std::string& where, const std::string& found, const std::string& wanted) {
  return {"camera_file_invalid", where, found, wanted, ""};
}

Result<Camera> checked(Camera camera, const std::string& name) {
  const Status status = validate(camera);
  if (status.ok()) return camera;
  return invalid_file(name, status.error().found, status.error().wanted);
}

int side_of(double px) {
  return std::isfinite(px) ? static_cast<int>(std::clamp(px, 0.0, kLargestSide)) : 0;
}

/// Coefficient `i` in OpenCV's order, 0 where the model has none.
double coefficient(const Camera& camera, std::size_t i) {
  return i < camera.distortion.size() ? camera.distortion[i] : 0.0;
}

/// The shortest of OpenCV's models that holds k1 k2 p1 p2 k3.
void set_brown(Camera& camera, const std::array<double, 5>& k) {
  const bool any = std::any_of(k.begin(), k.end(), [](double v) { return v != 0.0; });
  camera.model = !any ? CameraModel::pinhole : CameraModel::opencv5;
  camera.distortion.assign(k.begin(), any ? k.end() : k.begin());
}

/// One thing that would move pixels and that Furrow's models lack.
Error unsupported(const std::string& name, const std::string& what) {
  return {"camera_model_unsupported", name, what, "a lens without it", ""};
}

/// Numbers of one line: signs, digits, points and exponents, whatever stands between them.
std::vector<double> numbers_in(std::string_view text) {
  std::vector<double> out;
  const auto is_part = [](char c) {
    return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+' || c == 'e' || c == 'E';
  };
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    while (end < text.size() && is_part(text[end])) ++end;
    if (const auto value = base::parse_double(text.substr(i, end - i)); value && end > i)
      out.push_back(*value);
    i = std::max(end, i + 1);
  }
  return out;
}

/// Lines "KEY rest", the first of each key; `separators` end a key.
std::map<std::string, std::pair<int, std::string>> keyed_lines(const std::string& text,
                                                               const char* separators) {
  std::map<std::string, std::pair<int, std::string>> out;
  int line = 0;
  for (const std::string_view row : base::split(text, '\n')) {
    ++line;
    const std::string_view trimmed = base::trim(row);
    const std::size_t end = trimmed.find_first_of(separators);
    if (end == std::string_view::npos || end == 0) continue;
    out.try_emplace(std::string(base::trim(trimmed.substr(0, end))), line,
                    std::string(trimmed.substr(end + 1)));
  }
  return out;
}

/// As many numbers as wanted from the line of a key.
Result<std::vector<double>> numbers_of(const std::map<std::string, std::pair<int, std::string>>& lines,
                                       const std::string& key, std::size_t least, std::size_t most,
                                       const std::string& name) {
  const auto found = lines.find(key);
  const std::string wanted =
      "`" + key + "` with " + std::to_string(least) + (most > least ? " or more" : "") + " numbers";
  if (found == lines.end()) return invalid_file(name, "no `" + key + "`", wanted);
  std::vector<double> out = numbers_in(found->second.second);
  if (out.size() < least || out.size() > most)
    return invalid_file(name + ":" + std::to_string(found->second.first),
                        std::to_string(out.size()) + " numbers", wanted);
  return out;
}

}  // namespace

Result<Camera> from_metashape(const std::string& text, const std::string& name) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
  if (!parsed)
    return invalid_file(name, std::string("XML that cannot be read: ") + parsed.description(),
                        "a Metashape calibration");
  const pugi::xml_node node =
      document.find_node([](const pugi::xml_node& n) { return std::string_view(n.name()) == "calibration"; });
  if (!node) return invalid_file(name, "no <calibration>", "a Metashape calibration");
  bool readable = true;
  const auto number = [&](const char* key) {
    const std::string_view word = base::trim(node.child(key).text().get());
    if (word.empty()) return 0.0;
    const auto value = base::parse_double(word);
    readable = readable && value.has_value();
    return value.value_or(0.0);
  };
  const std::string projection = node.child("projection").text().get();
  if (projection != "frame" && projection != "fisheye" && !projection.empty())
    return unsupported(name, "projection " + projection);
  Camera camera;
  camera.width = side_of(number("width"));
  camera.height = side_of(number("height"));
  // Older files say fx and fy, later ones f and the affinity b1.
  const double f = number("f"), fy = number("fy");
  camera.fy = f != 0.0 ? f : fy;
  camera.fx = f != 0.0 ? f + number("b1") : number("fx");
  const bool from_middle = f != 0.0;
  camera.cx = number("cx") + (from_middle ? 0.5 * camera.width : 0.0) - kCornerShiftPx;
  camera.cy = number("cy") + (from_middle ? 0.5 * camera.height : 0.0) - kCornerShiftPx;
  for (const char* key : {"b2", "skew", "p3", "p4"}) {
    if (number(key) != 0.0) return unsupported(name, std::string("<") + key + "> other than 0");
  }
  if (projection == "fisheye") {
    if (number("p1") != 0.0 || number("p2") != 0.0) return unsupported(name, "a fisheye with <p1> or <p2>");
    camera.model = CameraModel::fisheye;
    camera.distortion = {number("k1"), number("k2"), number("k3"), number("k4")};
  } else {
    if (number("k4") != 0.0) return unsupported(name, "<k4> other than 0 on a frame camera");
    set_brown(camera, {number("k1"), number("k2"), number("p2"), number("p1"), number("k3")});
  }
  if (!readable) return invalid_file(name, "an element that is no number", "numbers in f, cx, cy, k1, ...");
  camera.provenance = "read from a Metashape calibration";
  return checked(camera, name);
}

std::string to_metashape(const Camera& camera) {
  const bool fisheye = camera.model == CameraModel::fisheye;
  std::ostringstream out;
  const auto element = [&](const char* key, double value) {
    out << "  <" << key << ">" << base::format_double(value) << "</" << key << ">\n";
  };
  out << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<calibration>\n  <projection>"
      << (fisheye ? "fisheye" : "frame") << "</projection>\n  <width>" << camera.width
      << "</width>\n  <height>" << camera.height << "</height>\n";
  element("f", camera.fy);
  element("cx", camera.cx + kCornerShiftPx - 0.5 * camera.width);
  element("cy", camera.cy + kCornerShiftPx - 0.5 * camera.height);
  element("b1", camera.fx - camera.fy);
  element("k1", coefficient(camera, 0));
  element("k2", coefficient(camera, 1));
  element("k3", coefficient(camera, fisheye ? 2 : 4));
  if (fisheye) {
    element("k4", coefficient(camera, 3));
  } else {
    element("p1", coefficient(camera, 3));
    element("p2", coefficient(camera, 2));
  }
  out << "</calibration>\n";
  return out.str();
}

bool looks_like_pix4d(const std::string& text) {
  return text.find("Pix4D camera calibration file") != std::string::npos;
}

Result<Camera> from_pix4d(const std::string& text, const std::string& name) {
  const std::string sensor_mark = "sensor width of", size_mark = "#Image size px";
  const std::size_t sensor_at = text.find(sensor_mark), size_at = text.find(size_mark);
  if (sensor_at == std::string::npos)
    return invalid_file(name, "no line \"#Focal Length mm assuming a sensor width of WxHmm\"",
                        "the sensor's size");
  if (size_at == std::string::npos) {
    return Error{"camera_file_invalid", name,
                 "a Pix4D .cam, which does not say how many pixels the sensor has",
                 "a line \"#Image size px WxH\"", "add that line with the size of the pictures"};
  }
  const auto line_from = [&](std::size_t at) {
    return std::string_view(text).substr(at, text.find('\n', at) - at);
  };
  const std::vector<double> sensor_mm = numbers_in(line_from(sensor_at + sensor_mark.size()));
  const std::vector<double> size_px = numbers_in(line_from(size_at + size_mark.size()));
  if (sensor_mm.size() != 2 || size_px.size() != 2 || !(sensor_mm[0] > 0.0))
    return invalid_file(name, "a sensor or picture without width and height", "two numbers each");
  std::map<std::string, double> values;
  const auto lines = keyed_lines(text, " ");
  for (const char* key : {"F", "Px", "Py", "K1", "K2", "K3", "T1", "T2"}) {
    FURROW_TRY(const std::vector<double> one, numbers_of(lines, key, 1, 1, name));
    values[key] = one[0];
  }
  Camera camera;
  camera.width = side_of(size_px[0]);
  camera.height = side_of(size_px[1]);
  const double px_per_mm = size_px[0] / sensor_mm[0];
  camera.fx = camera.fy = values["F"] * px_per_mm;
  camera.cx = values["Px"] * px_per_mm - kCornerShiftPx;
  camera.cy = values["Py"] * px_per_mm - kCornerShiftPx;
  set_brown(camera, {values["K1"], values["K2"], values["T1"], values["T2"], values["K3"]});
  camera.provenance = "read from a Pix4D .cam";
  return checked(camera, name);
}

std::string to_pix4d(const Camera& camera, double sensor_width_mm) {
  const double mm_per_px = sensor_width_mm / camera.width;
  std::ostringstream out;
  const auto line = [&](const char* key, double value) {
    out << key << " " << base::format_double(value) << "\n";
  };
  out << "Pix4D camera calibration file 0\n#Focal Length mm assuming a sensor width of "
      << base::format_double(sensor_width_mm) << "x" << base::format_double(mm_per_px * camera.height)
      << "mm\n";
  line("F", camera.fx * mm_per_px);
  out << "#Principal Point mm\n";
  line("Px", (camera.cx + kCornerShiftPx) * mm_per_px);
  line("Py", (camera.cy + kCornerShiftPx) * mm_per_px);
  out << "#Symmetrical Lens Distortion Coeffs\n";
  line("K1", coefficient(camera, 0));
  line("K2", coefficient(camera, 1));
  line("K3", coefficient(camera, 4));
  out << "#Tangential Lens Distortion Coeffs\n";
  line("T1", coefficient(camera, 2));
  line("T2", coefficient(camera, 3));
  out << "#Image size px " << camera.width << "x" << camera.height << "\n";
  return out.str();
}

bool looks_like_matlab(const std::string& text) {
  return text.find("FocalLength") != std::string::npos && text.find("PrincipalPoint") != std::string::npos;
}

Result<Camera> from_matlab(const std::string& text, const std::string& name) {
  const auto lines = keyed_lines(text, ":=");
  FURROW_TRY(const std::vector<double> focal, numbers_of(lines, "FocalLength", 2, 2, name));
  FURROW_TRY(const std::vector<double> middle, numbers_of(lines, "PrincipalPoint", 2, 2, name));
  FURROW_TRY(const std::vector<double> size, numbers_of(lines, "ImageSize", 2, 2, name));
  std::vector<double> radial{0.0, 0.0, 0.0}, tangential{0.0, 0.0}, skew{0.0};
  if (lines.contains("RadialDistortion")) {
    FURROW_TRY(radial, numbers_of(lines, "RadialDistortion", 2, 3, name));
  }
  if (lines.contains("TangentialDistortion")) {
    FURROW_TRY(tangential, numbers_of(lines, "TangentialDistortion", 2, 2, name));
  }
  if (lines.contains("Skew")) {
    FURROW_TRY(skew, numbers_of(lines, "Skew", 1, 1, name));
  }
  if (skew[0] != 0.0) return unsupported(name, "a Skew other than 0");
  radial.resize(3, 0.0);
  Camera camera;
  camera.width = side_of(size[1]);  // MATLAB gives rows first
  camera.height = side_of(size[0]);
  camera.fx = focal[0];
  camera.fy = focal[1];
  camera.cx = middle[0] - 1.0;
  camera.cy = middle[1] - 1.0;
  set_brown(camera, {radial[0], radial[1], tangential[0], tangential[1], radial[2]});
  camera.provenance = "read from MATLAB's text";
  return checked(camera, name);
}

std::string to_matlab(const Camera& camera) {
  std::ostringstream out;
  const auto line = [&](const char* key, const std::vector<double>& values) {
    out << key << ": [";
    for (std::size_t i = 0; i < values.size(); ++i)
      out << (i > 0 ? " " : "") << base::format_double(values[i]);
    out << "]\n";
  };
  out << "% cameraIntrinsics; pixel (1, 1) is the centre of the top-left pixel\n";
  line("FocalLength", {camera.fx, camera.fy});
  line("PrincipalPoint", {camera.cx + 1.0, camera.cy + 1.0});
  line("ImageSize", {static_cast<double>(camera.height), static_cast<double>(camera.width)});
  line("RadialDistortion", {coefficient(camera, 0), coefficient(camera, 1), coefficient(camera, 4)});
  line("TangentialDistortion", {coefficient(camera, 2), coefficient(camera, 3)});
  out << "Skew: 0\n";
  return out.str();
}

Result<Camera> from_dji_picture(const std::string& bytes, const std::string& name) {
  // The XMP packet is plain text inside the file; K6 first, which the shorter name is a part of.
  std::string stated;
  for (const char* key : {"DewarpDataK6", "DewarpData"}) {
    std::size_t at = bytes.find(std::string(key) + "=\"");
    char close = '"';
    if (at == std::string::npos) {
      at = bytes.find(std::string(key) + ">");
      close = '<';
    }
    if (at == std::string::npos) continue;
    const std::size_t start = bytes.find_first_of("\">", at) + 1, end = bytes.find(close, start);
    constexpr std::size_t kLongest = 1000;
    if (end == std::string::npos || end - start > kLongest) continue;
    stated = bytes.substr(start, end - start);
    break;
  }
  if (stated.empty()) {
    return Error{"camera_format_unknown", name, "a picture without DJI's DewarpData",
                 "a camera file, or a picture of a DJI camera that states its own calibration", ""};
  }
  // "date;fx,fy,cx,cy,k1,k2,p1,p2,k3" and, in K6, ",k4,k5,k6".
  const std::vector<double> v = numbers_in(
      std::string_view(stated).substr(stated.find(';') == std::string::npos ? 0 : stated.find(';') + 1));
  if (v.size() != 9 && v.size() != 12)
    return invalid_file(name, "DewarpData of " + std::to_string(v.size()) + " numbers",
                        "9, or 12 in DewarpDataK6");
  FURROW_TRY(const Image picture, image::decode_image(bytes, name));
  Camera camera;
  camera.width = picture.width;
  camera.height = picture.height;
  camera.fx = v[0];
  camera.fy = v[1];
  // DJI's guide for the Mavic 3M puts the origin at (width / 2, height / 2) of OpenCV's pixels.
  camera.cx = 0.5 * picture.width + v[2];
  camera.cy = 0.5 * picture.height + v[3];
  camera.model = v.size() == 9 ? CameraModel::opencv5 : CameraModel::opencv8;
  camera.distortion.assign(v.begin() + 4, v.end());
  camera.provenance = "DewarpData of " + name.substr(name.find_last_of('/') + 1);
  return checked(camera, name);
}

}  // namespace furrow::camera
