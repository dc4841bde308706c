#include "furrow/sim/scene.h"

#include <cmath>
#include <limits>

#include "furrow/base/fields.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/base/time.h"
#include "furrow/base/value.h"
#include "furrow/sim/simulate.h"
#include "sim/board.h"

namespace furrow::sim {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

// Each section is listed once, with its ranges; reading, checking and writing visit the same list.

template <class Visitor>
void visit(Visitor& v, Field& f) {
  v.choice("crop", f.crop, {{"vine", Crop::vine}, {"corn", Crop::corn}});
  v.number("azimuth_deg", f.azimuth_deg, -360, 360);
  v.number("spacing_m", f.spacing_m, 0.05, 100);
  v.number("row_height_m", f.row_height_m, 0.02, 20);
  v.number("half_width_m", f.half_width_m, 0.01, 20);
  v.number("base_half_width_m", f.base_half_width_m, 0.005, 20);
  v.number("foliage_bottom_m", f.foliage_bottom_m, 0, 20);
  v.number("leaf_m", f.leaf_m, 0.01, 1);
  v.number("leaf_layers", f.leaf_layers, 0.1, 10);
  v.number("surface_roughness_m", f.surface_roughness_m, 0, 0.5);
  v.number("width_roughness_m", f.width_roughness_m, 0, 0.5);
  v.number("height_roughness_m", f.height_roughness_m, 0, 0.5);
  v.number("density_variation", f.density_variation, 0, 1);
  v.number("plant_spacing_m", f.plant_spacing_m, 0.02, 50);
  v.number("gap_probability", f.gap_probability, 0, 1);
  v.number("post_spacing_m", f.post_spacing_m, 0, 1000);
  v.number("post_height_m", f.post_height_m, 0, 20);
  v.integer("rows_each_side", f.rows_each_side, 0, 500);
  v.number("before_m", f.before_m, 0, 2000);
  v.number("after_m", f.after_m, 0, 2000);
  v.number("curvature_per_m", f.curvature_per_m, -0.005, 0.005);
  v.number("slope_along", f.slope_along, -0.5, 0.5);
  v.number("slope_across", f.slope_across, -0.5, 0.5);
  v.number("undulation_m", f.undulation_m, 0, 10);
  v.number("undulation_wavelength_m", f.undulation_wavelength_m, 2, 10000);
  v.number("grass_cover", f.grass_cover, 0, 1);
  v.colour("soil_rgb", f.soil_rgb);
  v.colour("leaf_rgb", f.leaf_rgb);
}

template <class Visitor>
void visit(Visitor& v, Camera& c) {
  v.choice("model", c.model,
           {{"pinhole", camera::CameraModel::pinhole},
            {"opencv4", camera::CameraModel::opencv4},
            {"opencv5", camera::CameraModel::opencv5},
            {"opencv8", camera::CameraModel::opencv8},
            {"opencv12", camera::CameraModel::opencv12}});
  v.integer("width", c.width, 16, 20000);
  v.integer("height", c.height, 16, 20000);
  v.number("fx", c.fx, 1, 1e6);
  v.number("fy", c.fy, 1, 1e6);
  v.number("cx", c.cx, -1e6, 1e6);
  v.number("cy", c.cy, -1e6, 1e6);
  v.numbers("distortion", c.distortion);
}

template <class Visitor>
void visit(Visitor& v, Sun& s) {
  v.number("elevation_deg", s.elevation_deg, 5, 90);
  v.number("azimuth_deg", s.azimuth_deg, -360, 360);
  v.number("diffuse", s.diffuse, 0, 10);
}

template <class Visitor>
void visit(Visitor& v, Boards& b) {
  v.integer("count", b.count, 0, 1000);
  v.choice("type", b.type,
           {{"checkerboard", target::BoardKind::checkerboard},
            {"charuco", target::BoardKind::charuco},
            {"aprilgrid", target::BoardKind::aprilgrid}});
  v.integer("corners_x", b.corners_x, 3, 50);
  v.integer("corners_y", b.corners_y, 3, 50);
  v.number("square_m", b.square_m, 0.001, 0.999);
  v.number("marker_m", b.marker_m, 0.0005, 0.999);
  v.number("gap_m", b.gap_m, 0.0005, 0.999);
  v.number("outside", b.outside, 0, 0.4);
  v.number("max_tilt_deg", b.max_tilt_deg, 0, 60);
  v.number("light_gradient", b.light_gradient, 0, 0.8);
}

template <class Visitor>
void visit(Visitor& v, Leg& leg) {
  v.number("height_above_ground_m", leg.height_above_ground_m, 0.1, 500);
  v.number("end_height_above_ground_m", leg.end_height_above_ground_m, 0.1, 500);
  v.number("pitch_deg", leg.pitch_deg, -90, 30);
  v.number("end_pitch_deg", leg.end_pitch_deg, -90, 30);
  v.number("cross_track_m", leg.cross_track_m, -100, 100);
  v.number("yaw_deg", leg.yaw_deg, -180, 180);
  v.integer("shots", leg.shots, 1, 100000);
}

template <class Visitor>
void visit(Visitor& v, Wander& w) {
  v.number("cross_track_m", w.cross_track_m, 0, 10);
  v.number("height_m", w.height_m, 0, 10);
  v.number("yaw_deg", w.yaw_deg, 0, 45);
  v.number("pitch_deg", w.pitch_deg, 0, 45);
  v.number("roll_deg", w.roll_deg, 0, 45);
}

template <class Visitor>
void visit(Visitor& v, Flight& f) {
  v.number("latitude_deg", f.latitude_deg, -85, 85);
  v.number("longitude_deg", f.longitude_deg, -180, 180);
  v.number("height_ellipsoid_m", f.height_ellipsoid_m, -500, 9000);
  v.time("start_utc", f.start_utc);
  v.number("speed_mps", f.speed_mps, 0.01, 50);
  v.number("shot_interval_s", f.shot_interval_s, 0.2, 3600);
  v.boolean("follow_terrain", f.follow_terrain);
  v.section("wander", f.wander);
  v.list("legs", f.legs);
}

template <class Visitor>
void visit(Visitor& v, LogErrors& e) {
  v.number("gimbal_pitch_bias_deg", e.gimbal_pitch_bias_deg, -45, 45);
  v.number("gimbal_roll_bias_deg", e.gimbal_roll_bias_deg, -45, 45);
  v.number("gimbal_noise_deg", e.gimbal_noise_deg, 0, 45);
  v.number("heading_bias_deg", e.heading_bias_deg, -180, 180);
  v.number("heading_noise_deg", e.heading_noise_deg, 0, 90);
  v.number("baro_drift_m", e.baro_drift_m, -100, 100);
  v.number("baro_gust_m", e.baro_gust_m, 0, 100);
  v.number("vps_noise_m", e.vps_noise_m, 0, 10);
  v.number("vps_canopy_share", e.vps_canopy_share, 0, 1);
  v.number("vps_range_m", e.vps_range_m, 0, 100);
  v.number("gnss_bias_m", e.gnss_bias_m, 0, 1000);
  v.number("gnss_noise_m", e.gnss_noise_m, 0, 1000);
  v.number("latency_s", e.latency_s, 0, 10);
  v.number("dropout_probability", e.dropout_probability, 0, 0.9);
  v.integer("extra_photos", e.extra_photos, 0, 1000);
}

template <class Visitor>
void visit(Visitor& v, Pictures& p) {
  v.number("exposure", p.exposure, 0.01, 100);
  v.number("blur_px", p.blur_px, 0, 20);
  v.number("noise", p.noise, 0, 0.5);
  v.number("exposure_time_s", p.exposure_time_s, 0, 1);
  v.number("readout_time_s", p.readout_time_s, 0, 1);
  v.integer("jpeg_quality", p.jpeg_quality, 1, 100);
}

/// What stands above the sections; `v.text`, `v.whole` and `v.section` in the order of the file.
template <class Visitor>
void visit(Visitor& v, Scene& scene) {
  v.text("name", scene.name);
  v.seed("seed", scene.seed);
  v.section("camera", scene.camera);
  v.section("field", scene.field);
  v.section("sun", scene.sun);
  v.section("boards", scene.boards);
  v.section("flight", scene.flight);
  v.section("log", scene.log);
  v.section("pictures", scene.pictures);
}

std::string range_text(double low, double high) {
  if (high == kUnlimited) return "a number of at least " + base::format_double(low);
  return "a number from " + base::format_double(low) + " to " + base::format_double(high);
}

bool colour_holds(const std::vector<double>& rgb) {
  if (rgb.size() != 3) return false;
  for (double c : rgb) {
    if (!(c >= 0.0 && c <= 1.0)) return false;
  }
  return true;
}

template <class Enum>
using Names = std::initializer_list<std::pair<const char*, Enum>>;

template <class Enum>
std::string names_text(Names<Enum> names) {
  std::string text = "one of";
  for (const auto& [name, value] : names) text += std::string(" ") + name;
  return text;
}

/// Fills a section from a mapping; the first fault stays in `status`.
class Reader {
 public:
  Reader(base::Fields& fields, const std::string& file) : fields_(fields), file_(file) {}

  void number(const char* key, double& x, double low, double high) {
    fields_.optional(key, x);
    fields_.require(x >= low && x <= high, key, base::format_double(x), range_text(low, high));
  }
  void integer(const char* key, int& x, int low, int high) {
    fields_.optional(key, x);
    fields_.require(x >= low && x <= high, key, std::to_string(x), range_text(low, high));
  }
  void seed(const char* key, std::uint64_t& x) {
    int value = static_cast<int>(x);
    integer(key, value, 0, std::numeric_limits<int>::max());
    x = static_cast<std::uint64_t>(value);
  }
  void boolean(const char* key, bool& x) { fields_.optional(key, x); }
  void text(const char* key, std::string& x) {
    fields_.optional(key, x);
    fields_.require(!x.empty(), key, "an empty text", "a name");
  }
  void time(const char* key, std::string& x) {
    fields_.optional(key, x);
    fields_.require(base::parse_date_time(x).has_value(), key, x, "a time such as 2024-06-18 08:41:17.370");
  }
  void numbers(const char* key, std::vector<double>& x) { fields_.optional(key, x); }
  void colour(const char* key, std::vector<double>& x) {
    fields_.optional(key, x);
    fields_.require(colour_holds(x), key, std::to_string(x.size()) + " numbers",
                    "three linear reflectances from 0 to 1");
  }
  template <class Enum>
  void choice(const char* key, Enum& x, Names<Enum> names) {
    std::string name;
    fields_.optional(key, name);
    if (name.empty()) return;
    for (const auto& [known, value] : names) {
      if (name == known) {
        x = value;
        return;
      }
    }
    fields_.fail(key, name, names_text(names));
  }
  template <class Section>
  void section(const char* key, Section& x) {
    const base::Value* value = fields_.member(key);
    if (value != nullptr) read_one(*value, key, x);
  }
  template <class Item>
  void list(const char* key, std::vector<Item>& items) {
    const base::Value* value = fields_.member(key);
    if (value == nullptr) return;
    const base::Array* array = value->array();
    fields_.require(array != nullptr, key, value->kind_name(), "a list");
    if (array == nullptr) return;
    items.clear();
    for (const base::Value& one : *array) {
      Item item;
      read_one(one, key, item);
      items.push_back(item);
    }
  }
  const Status& status() const { return status_; }

 private:
  template <class Section>
  void read_one(const base::Value& value, const char* key, Section& x) {
    if (!status_.ok()) return;
    base::Fields inner(value, file_, key);
    Reader reader(inner, file_);
    visit(reader, x);
    status_ = reader.status();
    if (status_.ok()) status_ = inner.finish();
  }

  base::Fields& fields_;
  const std::string& file_;
  Status status_ = Done{};
};

/// Checks a scene that a program made.
class Checker {
 public:
  void number(const char* key, double x, double low, double high) {
    if (!(x >= low && x <= high)) fail(key, base::format_double(x), range_text(low, high));
  }
  void integer(const char* key, int x, int low, int high) {
    if (x < low || x > high) fail(key, std::to_string(x), range_text(low, high));
  }
  void seed(const char*, std::uint64_t) {}
  void boolean(const char*, bool) {}
  void text(const char* key, const std::string& x) {
    if (x.empty()) fail(key, "an empty text", "a name");
  }
  void time(const char* key, const std::string& x) {
    if (!base::parse_date_time(x)) fail(key, x, "a time such as 2024-06-18 08:41:17.370");
  }
  void numbers(const char* key, const std::vector<double>& values) {
    for (double x : values) {
      if (!std::isfinite(x)) fail(key, base::format_double(x), "finite numbers");
    }
  }
  void colour(const char* key, const std::vector<double>& x) {
    if (!colour_holds(x))
      fail(key, std::to_string(x.size()) + " numbers", "three linear reflectances from 0 to 1");
  }
  template <class Enum>
  void choice(const char*, Enum, Names<Enum>) {}
  template <class Section>
  void section(const char* key, Section& x) {
    const std::string outer = path_;
    path_ += std::string(key) + ".";
    visit(*this, x);
    path_ = outer;
  }
  template <class Item>
  void list(const char* key, std::vector<Item>& items) {
    if (items.empty()) fail(key, "no entry", "at least one");
    for (Item& item : items) section(key, item);
  }
  Status status() const { return status_; }
  void fail(const std::string& key, const std::string& found, const std::string& wanted) {
    if (status_.ok()) status_ = Error{"scene_invalid", path_ + key, found, wanted, ""};
  }

 private:
  std::string path_;
  Status status_ = Done{};
};

/// Writes a scene as YAML.
class Writer {
 public:
  void number(const char* key, double x, double, double) { line(key, base::format_double(x)); }
  void integer(const char* key, int x, int, int) { line(key, std::to_string(x)); }
  void seed(const char* key, std::uint64_t x) { line(key, std::to_string(x)); }
  void boolean(const char* key, bool x) { line(key, x ? "true" : "false"); }
  void text(const char* key, const std::string& x) { line(key, quoted(x)); }
  void time(const char* key, const std::string& x) { line(key, quoted(x)); }
  void numbers(const char* key, const std::vector<double>& values) {
    std::string list;
    for (double x : values) list += (list.empty() ? "" : ", ") + base::format_double(x);
    line(key, "[" + list + "]");
  }
  void colour(const char* key, const std::vector<double>& x) { numbers(key, x); }
  template <class Enum>
  void choice(const char* key, Enum x, Names<Enum> names) {
    for (const auto& [name, value] : names) {
      if (x == value) line(key, name);
    }
  }
  template <class Section>
  void section(const char* key, Section& x) {
    line(key, "");
    indent_ += 2;
    visit(*this, x);
    indent_ -= 2;
  }
  template <class Item>
  void list(const char* key, std::vector<Item>& items) {
    line(key, items.empty() ? "[]" : "");
    indent_ += 4;
    for (Item& item : items) {
      dash_ = true;
      visit(*this, item);
    }
    indent_ -= 4;
  }
  const std::string& yaml() const { return yaml_; }

 private:
  static std::string quoted(const std::string& x) {
    std::string out = "\"";
    for (char c : x) {
      if (c == '"' || c == '\\') out += '\\';
      out += c;
    }
    return out + "\"";
  }
  void line(const std::string& key, const std::string& value) {
    std::string start(static_cast<std::size_t>(indent_), ' ');
    if (dash_) start.replace(start.size() - 2, 1, "-");
    dash_ = false;
    yaml_ += start + key + ":" + (value.empty() ? "" : " " + value) + "\n";
  }
  int indent_ = 0;
  bool dash_ = false;
  std::string yaml_;
};

/// What no single field can tell.
void check_together(const Scene& scene, Checker& checker) {
  const Field& f = scene.field;
  if (f.foliage_bottom_m >= f.row_height_m) {
    checker.fail("field.foliage_bottom_m", base::format_double(f.foliage_bottom_m),
                 "less than row_height_m, " + base::format_double(f.row_height_m));
  }
  if (2.0 * f.half_width_m >= f.spacing_m) {
    checker.fail("field.half_width_m", base::format_double(f.half_width_m), "less than half of spacing_m");
  }
  if (f.base_half_width_m > f.half_width_m) {
    checker.fail("field.base_half_width_m", base::format_double(f.base_half_width_m), "at most half_width_m");
  }
  // Leaves of a metre of row: more than this neither fits memory nor shows.
  constexpr double kMostLeavesPerMetre = 20000.0;
  const double envelope_m = 2.0 * (f.half_width_m + f.row_height_m);
  if (f.crop == Crop::vine && f.leaf_layers * envelope_m / (f.leaf_m * f.leaf_m) > kMostLeavesPerMetre) {
    checker.fail("field.leaf_m", base::format_double(f.leaf_m),
                 "larger leaves, or fewer leaf_layers: under 20000 leaves a metre");
  }
  const double farthest_m = f.rows_each_side * f.spacing_m;
  if (std::abs(f.curvature_per_m) * farthest_m > 0.9) {
    checker.fail("field.curvature_per_m", base::format_double(f.curvature_per_m),
                 "rows that do not fold over their common centre");
  }
  const Status board = target::validate(printed_board(scene.boards));
  if (!board.ok()) checker.fail("boards", board.error().found, board.error().wanted);
  const Status lens = camera::validate(scene.camera);
  if (!lens.ok()) checker.fail("camera", lens.error().found, lens.error().wanted);
}

}  // namespace

Camera thesis_camera() {
  Camera camera;
  camera.model = camera::CameraModel::opencv5;
  camera.width = 1280;
  camera.height = 720;
  camera.fx = 874.33;
  camera.fy = 872.39;
  camera.cx = 640.49;
  camera.cy = 360.81;
  // The thesis prints no distortion; these are of the size that the Phantom 4 Pro's 8.8 mm lens shows: 3 px
  // at the corners.
  camera.distortion = {-0.0125, 0.0180, 0.00035, -0.00025, -0.0065};
  camera.provenance = "simulated truth";
  return camera;
}

Scene empty_scene() {
  Scene scene;
  scene.camera = thesis_camera();
  return scene;
}

Status validate(const Scene& scene) {
  Scene copy = scene;
  Checker checker;
  visit(checker, copy);
  check_together(scene, checker);
  return checker.status();
}

Result<Scene> parse_scene(const std::string& text, const std::string& name) {
  FURROW_TRY(const base::Value root, base::parse_yaml(text, name));
  Scene scene = empty_scene();
  base::Fields fields(root, name, "scene");
  Reader reader(fields, name);
  visit(reader, scene);
  FURROW_DO(reader.status());
  FURROW_DO(fields.finish());
  if (Status status = validate(scene); !status.ok()) {
    Error error = status.error();
    error.where = name + ": " + error.where;
    return error;
  }
  return scene;
}

Result<Scene> read_scene(const std::filesystem::path& file) {
  FURROW_TRY(const std::string text, base::read_file(file));
  return parse_scene(text, file.string());
}

std::string to_yaml(const Scene& scene) {
  Scene copy = scene;
  Writer writer;
  visit(writer, copy);
  return writer.yaml();
}

Scene demo_scene() {
  Scene scene = empty_scene();
  scene.name = "vineyard-demo";
  scene.seed = 20240618;
  // The thesis's three flights: 3 m at -12.4 deg, 4 and 5 m at -13.8 deg.
  constexpr int kShotsPerLeg = 13;
  for (const auto& [height_m, pitch_deg] : {std::pair{3.0, -12.4}, {4.0, -13.8}, {5.0, -13.8}}) {
    Leg leg;
    leg.height_above_ground_m = leg.end_height_above_ground_m = height_m;
    leg.pitch_deg = leg.end_pitch_deg = pitch_deg;
    leg.shots = kShotsPerLeg;
    scene.flight.legs.push_back(leg);
  }
  return scene;
}

}  // namespace furrow::sim
