#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/camera/camera.h"
#include "furrow/target/board.h"

namespace furrow::sim {

enum class Crop {
  vine,  ///< a trellised hedge: leaves on a V- or box-shaped envelope, trunks, posts
  corn,  ///< young maize: separate plants with arching blades along the line
};

/// The field. Row coordinates: s along row 0 from the world's origin, l to the left, height above the soil.
struct Field {
  Crop crop = Crop::vine;
  double azimuth_deg = 62.0;  ///< of the rows (direction of flight), clockwise from north
  double spacing_m = 3.0;     ///< between row centres
  double row_height_m =
      1.70;  ///< plane of the row tops above the soil: mean first-hit height of the foliage seen from above
  double half_width_m = 0.60;  ///< half width of the mean silhouette seen from above (half-coverage edge)
  double base_half_width_m =
      0.25;  ///< of the foliage at its lowest; equal to half_width_m for a box, less for a V
  double foliage_bottom_m = 0.70;     ///< lowest leaves above the soil
  double leaf_m = 0.11;               ///< diameter of a leaf
  double leaf_layers = 2.6;           ///< leaf area per envelope area
  double surface_roughness_m = 0.03;  ///< one-sigma of leaves about the envelope
  double width_roughness_m = 0.04;    ///< one-sigma of the envelope's edge along the row
  double height_roughness_m = 0.03;   ///< one-sigma of the envelope's top along the row
  double density_variation = 0.25;    ///< relative one-sigma of leaf density along the row
  double plant_spacing_m = 1.5;       ///< between vines (or plants) of a row
  double gap_probability = 0.03;      ///< of a missing plant
  double post_spacing_m = 6.0;        ///< between trellis posts; 0: no posts
  double post_height_m = 1.85;        ///< above the soil
  int rows_each_side = 40;            ///< rows left and right of row 0
  double before_m = 20.0;             ///< length of the rows before the first shot
  double after_m = 140.0;             ///< length of the rows beyond the last shot
  double curvature_per_m = 0.0;       ///< of row 0, positive to the left; the other rows are parallel curves
  double slope_along = 0.0;           ///< rise per metre along the rows
  double slope_across = 0.0;          ///< rise per metre to the left
  double undulation_m = 0.0;          ///< one-sigma of the terrain's waves
  double undulation_wavelength_m = 40.0;
  double grass_cover = 0.30;                           ///< part of the alleys under grass, 0 to 1
  std::vector<double> soil_rgb = {0.27, 0.20, 0.135};  ///< linear reflectance
  std::vector<double> leaf_rgb = {0.068, 0.135, 0.026};
};

struct Sun {
  double elevation_deg = 52.0;
  double azimuth_deg = 118.0;  ///< clockwise from north
  double diffuse = 0.22;       ///< sky light on a level surface as a part of the sun's
};

/// The session with a calibration board.
struct Boards {
  int count = 20;  ///< pictures; 0: no session
  target::BoardKind type = target::BoardKind::checkerboard;
  int corners_x = 9, corners_y = 6;  ///< inner corners; on an AprilGrid two a tag
  double square_m = 0.038;           ///< of an AprilGrid: a tag
  double marker_m = 0.028;           ///< ChArUco
  double gap_m = 0.0114;             ///< AprilGrid
  double outside = 0.0;              ///< share of the picture's breadth by which a board may reach beyond it
  double max_tilt_deg = 40.0;
  double light_gradient = 0.25;  ///< relative change of light over the picture
};

/// One stretch of level or steadily climbing flight along the followed row.
struct Leg {
  double height_above_ground_m = 3.0;      ///< at the first shot
  double end_height_above_ground_m = 3.0;  ///< at the last shot
  double pitch_deg = -12.4;                ///< gimbal, negative below the horizon
  double end_pitch_deg = -12.4;
  double cross_track_m = 0.0;  ///< mean offset to the left of row 0
  double yaw_deg = 0.0;        ///< mean camera yaw against the row, positive to the left
  int shots = 12;
};

/// One-sigma of slow wander about the plan, each a sum of sines.
struct Wander {
  double cross_track_m = 0.16;
  double height_m = 0.07;
  double yaw_deg = 1.5;
  double pitch_deg = 0.15;
  double roll_deg = 0.5;
};

struct Flight {
  double latitude_deg = 38.3506;  ///< of the world's origin: the take-off point, on the soil of row 0
  double longitude_deg = 28.5173;
  double height_ellipsoid_m = 230.0;
  std::string start_utc = "2024-06-18 08:41:17.370";  ///< first row of the log
  double speed_mps = 1.0;
  double shot_interval_s = 2.0;
  bool follow_terrain =
      true;  ///< heights of the legs are above the soil below; false: above the take-off point
  std::vector<Leg> legs;
  Wander wander;
};

/// What is wrong with the log.
struct LogErrors {
  double gimbal_pitch_bias_deg = 0.7;  ///< logged minus true
  double gimbal_roll_bias_deg = 0.3;   ///< true roll of a gimbal that says 0
  double gimbal_noise_deg = 0.1;
  double heading_bias_deg = 1.2;
  double heading_noise_deg = 0.2;
  double baro_drift_m = 0.5;  ///< drift from the first to the last row
  double baro_gust_m = 0.10;  ///< one-sigma of correlated pressure noise
  double vps_noise_m = 0.03;
  double vps_canopy_share = 0.55;    ///< part of the time that the sensor over a row sees leaves and not soil
  double vps_range_m = 10.0;         ///< beyond it the last value is held
  double gnss_bias_m = 0.8;          ///< constant horizontal error
  double gnss_noise_m = 0.25;        ///< one-sigma of slow horizontal error
  double latency_s = 0.0;            ///< how late values reach the log
  double dropout_probability = 0.0;  ///< of a second without rows
  int extra_photos = 0;              ///< isPhoto marks without a picture, after the last shot
};

/// From light to file.
struct Pictures {
  double exposure = 1.0;           ///< gain over the nominal exposure
  double blur_px = 0.55;           ///< one-sigma of the lens
  double noise = 0.006;            ///< one-sigma at full scale (shot noise), linear light
  double exposure_time_s = 0.001;  ///< motion blur
  double readout_time_s = 0.0;     ///< rolling shutter, first to last row; 0: global
  int jpeg_quality = 92;
};

/// The simulator's input. The file form is scene.yaml, section by section with the same names;
/// docs/formulation/simulation.md.
struct Scene {
  std::string name = "scene";
  std::uint64_t seed = 1;
  Camera camera;
  Field field;
  Sun sun;
  Boards boards;
  Flight flight;
  LogErrors log;
  Pictures pictures;
};

/// The thesis's camera (1280x720) with a mild Brown-Conrady distortion.
Camera thesis_camera();

/// A scene with the thesis's camera and no legs.
Scene empty_scene();

/// Reads a scene; what the file leaves out keeps empty_scene()'s values, but `flight.legs` must be there.
/// Errors: file_*, malformed_yaml, scene_invalid, unknown_key (with the nearest known name and line).
Result<Scene> read_scene(const std::filesystem::path& file);
Result<Scene> parse_scene(const std::string& text, const std::string& name);

/// Every field of the scene as YAML that read_scene takes.
std::string to_yaml(const Scene& scene);

/// Errors: scene_invalid, naming the field and its range.
Status validate(const Scene& scene);

}  // namespace furrow::sim
