#include "sim/airdata.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/base/text.h"
#include "furrow/base/time.h"
#include "furrow/geo/geodesy.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/world.h"
#include "sim/canopy.h"
#include "sim/noise.h"
#include "sim/plan.h"

namespace furrow::sim {
namespace {

using Eigen::Vector3d;
using geom::rad_to_deg;

constexpr double kFeetPerMetre = 3.28084;  // AirData's factor: 0.1 m stands as 0.328084
constexpr double kMphPerMps = 2.23694;
constexpr double kRow_s = 0.1;            // log rows at 10 Hz
constexpr double kGustTime_s = 3.0;       // correlation of pressure noise
constexpr double kPositionTime_s = 20.0;  // correlation of the receiver's slow error
constexpr double kVpsDwell_s = 1.5;       // mean stay on one of leaves and soil
constexpr double kTerrainMap_m = 190.0;   // height of the take-off point in AirData's terrain map

// Verbatim, leading blanks included.
constexpr const char* kHeader =
    "time(millisecond),datetime(utc),latitude,longitude,height_above_takeoff(feet),"
    "height_above_ground_at_drone_location(feet),ground_elevation_at_drone_location(feet),"
    "altitude_above_seaLevel(feet),height_sonar(feet),speed(mph),distance(feet),mileage(feet),satellites,"
    "gpslevel,"
    "voltage(v),max_altitude(feet),max_ascent(feet),max_speed(mph),max_distance(feet), xSpeed(mph), "
    "ySpeed(mph), "
    "zSpeed(mph), compass_heading(degrees), pitch(degrees), "
    "roll(degrees),isPhoto,isVideo,rc_elevator,rc_aileron,"
    "rc_throttle,rc_rudder,rc_elevator(percent),rc_aileron(percent),rc_throttle(percent),rc_rudder(percent),"
    "gimbal_heading(degrees),gimbal_pitch(degrees),gimbal_roll(degrees),battery_percent,voltageCell1,"
    "voltageCell2,"
    "voltageCell3,voltageCell4,voltageCell5,voltageCell6,current(A),battery_temperature(f),altitude(feet),"
    "ascent(feet),flycStateRaw,flycState,message";

double rounded(double x, double step) {
  return std::round(x / step) * step;
}

/// Gaussian noise whose memory fades over `time_s`.
class SlowNoise {
 public:
  SlowNoise(double sigma, double time_s, base::Random& random)
      : keep_(std::exp(-kRow_s / time_s)),
        kick_(sigma * std::sqrt(1.0 - keep_ * keep_)),
        value_(sigma * random.normal()) {}
  double next(base::Random& random) { return value_ = keep_ * value_ + kick_ * random.normal(); }

 private:
  double keep_, kick_, value_;
};

/// What the downward sensor says.
class Vps {
 public:
  Vps(const Scene& scene, const Canopy& canopy) : scene_(scene), canopy_(canopy) {}
  double next(const CameraState& state, base::Random& random) {
    if (random.uniform() < kRow_s / kVpsDwell_s)
      sees_leaves_ = random.uniform() < scene_.log.vps_canopy_share;
    const Field& f = scene_.field;
    const double row = std::round(state.l / f.spacing_m);
    const bool over_row =
        std::abs(state.l - row * f.spacing_m) < f.half_width_m && std::abs(row) <= f.rows_each_side;
    const bool leaves = over_row && sees_leaves_ && canopy_.density(static_cast<int>(row), state.s) > 0.5 &&
                        state.height_above_ground_m > f.row_height_m;
    const double range = state.height_above_ground_m - (leaves ? f.row_height_m : 0.0) +
                         scene_.log.vps_noise_m * random.normal();
    if (range <= scene_.log.vps_range_m) last_m_ = std::max(0.1, rounded(range, 0.1));
    return last_m_;
  }

 private:
  const Scene& scene_;
  const Canopy& canopy_;
  bool sees_leaves_ = true;
  double last_m_ = 0.1;
};

/// One row of cells.
class Row {
 public:
  void text(const std::string& cell) { line_ += (line_.empty() ? "" : ",") + cell; }
  void number(double x, int decimals = 12) {
    std::string cell = base::format_fixed(x, decimals);
    if (cell.find('.') != std::string::npos) {
      while (cell.back() == '0') cell.pop_back();
      if (cell.back() == '.') cell.pop_back();
    }
    text(cell);
  }
  void feet(double metres) { number(metres * kFeetPerMetre); }
  void blank(int count) {
    for (int i = 0; i < count; ++i) line_ += ',';
  }
  const std::string& line() const { return line_; }

 private:
  std::string line_;
};

/// Largest values so far.
struct Extremes {
  double height_m = 0.0, speed_mps = 0.0, distance_m = 0.0, mileage_m = 0.0;
};

/// What a row is made of, in our units, before AirData's.
struct Reading {
  double t_s, height_takeoff_m, sonar_m, pitch_deg, roll_deg, heading_deg;
  geo::Geodetic place;
  Vector3d velocity;  // east, north, up
  double distance_m;
  bool photo, airborne;
};

std::string date_time(base::Nanoseconds t_utc_ns) {
  std::string text = base::format_utc(t_utc_ns);  // 2024-06-18T08:41:17.370Z
  text[10] = ' ';
  return text.substr(0, 19);
}

std::string row_text(const Reading& r, base::Nanoseconds start_ns, bool first, Extremes& most,
                     double battery) {
  const double speed = r.velocity.head<2>().norm();
  most.height_m = std::max(most.height_m, r.height_takeoff_m);
  most.speed_mps = std::max(most.speed_mps, rounded(speed, 0.1));
  most.distance_m = std::max(most.distance_m, r.distance_m);
  most.mileage_m += speed * kRow_s;
  Row row;
  row.number(std::round(r.t_s * 1000.0), 0);
  row.text(date_time(start_ns + base::seconds_to_ns(r.t_s)));
  row.number(r.place.latitude_deg, 13);
  row.number(r.place.longitude_deg, 12);
  row.feet(r.height_takeoff_m);
  row.text(first ? "Available with any HD 360 subscription" : "");
  row.text(first ? "Available with any HD 360 subscription" : "");
  row.feet(kTerrainMap_m + r.height_takeoff_m);
  row.feet(r.sonar_m);
  row.number(rounded(speed, 0.1) * kMphPerMps);
  row.feet(r.distance_m);
  row.feet(most.mileage_m);
  row.text("17");
  row.text("5");
  row.number(15.2 - 0.8 * (1.0 - battery), 3);
  row.feet(kTerrainMap_m + most.height_m);
  row.feet(most.height_m);
  row.number(most.speed_mps * kMphPerMps);
  row.feet(most.distance_m);
  for (int i : {1, 0, 2}) row.number(rounded(i == 2 ? -r.velocity[i] : r.velocity[i], 0.1) * kMphPerMps);
  row.number(r.heading_deg, 1);
  row.text(" " + base::format_fixed(r.airborne ? -2.1 : 0.3, 1));
  row.text(" 0.4");
  row.text(r.photo ? "1" : "0");
  row.text("0");
  for (int i = 0; i < 4; ++i) row.text("1024");
  for (int i = 0; i < 4; ++i) row.text("0");
  row.number(r.heading_deg, 1);
  row.number(r.pitch_deg, 1);
  row.number(r.roll_deg, 1);
  row.number(std::floor(100.0 * battery), 0);
  for (int i = 0; i < 4; ++i) row.number(3.8 - 0.2 * (1.0 - battery), 3);
  for (int i = 0; i < 2; ++i) row.text("0");
  row.number(r.airborne ? 12.4 : 0.9, 3);
  row.number(86.0, 2);
  row.feet(kTerrainMap_m + r.height_takeoff_m);
  row.feet(r.height_takeoff_m);
  row.text(r.airborne ? "6" : "41");
  row.text(r.airborne ? "P-GPS" : "Motors_Started");
  row.text("");
  return row.line();
}

}  // namespace

std::string airdata_csv(const Scene& scene) {
  const FlightPath path(scene);
  const Canopy canopy(scene, false);
  const LogErrors& e = scene.log;
  const Flight& flight = scene.flight;
  const geo::LocalFrame world({flight.latitude_deg, flight.longitude_deg, flight.height_ellipsoid_m});
  const base::Nanoseconds start_ns = base::parse_date_time(flight.start_utc).value_or(0);
  base::Random random(base::mix_bits(scene.seed ^ 0x106));
  const double bias_toward = random.uniform(0.0, 2.0 * geom::kPi);
  SlowNoise gust(e.baro_gust_m, kGustTime_s, random);
  SlowNoise east(e.gnss_noise_m, kPositionTime_s, random), north(e.gnss_noise_m, kPositionTime_s, random);
  Vps vps(scene, canopy);
  Eigen::Matrix3d world_rotation = Eigen::Matrix3d::Identity();
  world_rotation.topLeftCorner<2, 2>() = world_from_plan(scene.field.azimuth_deg);

  std::string csv = std::string(kHeader) + "\n";
  Extremes most;
  const std::vector<double>& shots = path.shot_times();
  std::size_t next_shot = 0;
  const int extra_rows = 20 + 10 * e.extra_photos;
  const auto rows = static_cast<std::int64_t>(std::ceil(path.duration_s() / kRow_s)) + extra_rows;
  double start_baro_m = 0.0;
  for (std::int64_t i = 0; i < rows; ++i) {
    Reading r{};
    r.t_s = static_cast<double>(i) * kRow_s;
    const CameraState state = path.at(r.t_s - e.latency_s);
    const CameraState later = path.at(r.t_s - e.latency_s + kRow_s);
    r.airborne = state.height_above_ground_m > 0.3;
    const Vector3d at = world_rotation * state.centre_in_plan;
    r.velocity = world_rotation * (later.centre_in_plan - state.centre_in_plan) / kRow_s;
    const Vector3d error(e.gnss_bias_m * std::cos(bias_toward) + east.next(random),
                         e.gnss_bias_m * std::sin(bias_toward) + north.next(random), 0.0);
    r.place = world.geodetic(at + error);
    const double drift = e.baro_drift_m * static_cast<double>(i) / static_cast<double>(rows);
    const double baro_m = at.z() + drift + (r.airborne ? gust.next(random) : 0.0);
    if (i == 0) start_baro_m = baro_m;
    r.height_takeoff_m = rounded(baro_m - start_baro_m, 0.1);
    r.sonar_m = vps.next(state, random);
    r.pitch_deg = rounded(
        rad_to_deg(state.attitude.pitch_rad) + e.gimbal_pitch_bias_deg + e.gimbal_noise_deg * random.normal(),
        0.1);
    r.roll_deg = rounded(
        rad_to_deg(state.attitude.roll_rad) - e.gimbal_roll_bias_deg + e.gimbal_noise_deg * random.normal(),
        0.1);
    const double turned = rad_to_deg(state.attitude.yaw_rad + scene.field.curvature_per_m * state.s);
    const double heading =
        scene.field.azimuth_deg - turned + e.heading_bias_deg + e.heading_noise_deg * random.normal();
    r.heading_deg = rounded(std::fmod(std::fmod(heading, 360.0) + 360.0, 360.0), 0.1);
    r.distance_m = (at + error).head<2>().norm();
    // The mark stands on the first row at or after the exposure.
    if (next_shot < shots.size() && shots[next_shot] <= r.t_s) {
      r.photo = true;
      ++next_shot;
    }
    const std::int64_t beyond = i - (rows - extra_rows) - 10;
    if (next_shot == shots.size() && beyond >= 0 && beyond % 10 == 0 && beyond / 10 < e.extra_photos)
      r.photo = true;
    const bool dropped = !r.photo && i > 0 &&
                         unit_hash(scene.seed ^ base::mix_bits(0xd409 + static_cast<std::uint64_t>(i / 10))) <
                             e.dropout_probability;
    const double battery =
        0.96 - 0.25 * static_cast<double>(i) / static_cast<double>(std::max<std::int64_t>(rows, 6000));
    const std::string line = row_text(r, start_ns, i == 0, most, battery);
    if (!dropped) csv += line + "\n";
  }
  return csv;
}

}  // namespace furrow::sim
