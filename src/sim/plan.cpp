#include "sim/plan.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/world.h"

namespace furrow::sim {
namespace {

using geom::deg_to_rad;
using geom::rad_to_deg;

constexpr double kOnGround_s = 2.0;         // log rows before take-off
constexpr double kCameraOnGround_m = 0.15;  // camera of an aircraft that stands on the soil
constexpr double kClimb_mps = 1.0;
constexpr double kAccelerate_s = 3.0;
constexpr double kSettle_s = 1.0;          // steady flight before a leg's first and after its last shot
constexpr double kShortestChange_s = 4.0;  // between legs
constexpr double kChange_mps = 0.8;        // climb rate between legs
constexpr double kShotJitter_s = 0.04;     // intervalometers are not exact
constexpr double kFullWanderHeight_m = 1.5;

double smoothstep(double q) {
  return q * q * (3.0 - 2.0 * q);
}

std::uint64_t seed_of(const Scene& scene, std::uint64_t salt) {
  return base::mix_bits(scene.seed ^ base::mix_bits(salt));
}

}  // namespace

Terrain::Terrain(const Scene& scene) : slope_(scene.field.slope_along, scene.field.slope_across) {
  base::Random random(seed_of(scene, 0x7e44a1));
  // Three waves of equal power: each amplitude is sigma sqrt(2 / 3).
  amplitude_ = scene.field.undulation_m * std::sqrt(2.0 / 3.0);
  amplitude_sum_ = 3.0 * amplitude_;
  steepest_ = slope_.norm();
  for (Wave& wave : waves_) {
    const double direction = random.uniform(0.0, 2.0 * geom::kPi);
    const double k = 2.0 * geom::kPi / (scene.field.undulation_wavelength_m * random.uniform(0.8, 1.25));
    wave = {k * std::cos(direction), k * std::sin(direction), random.uniform(0.0, 2.0 * geom::kPi)};
    steepest_ += amplitude_ * k;
  }
  offset_ = waves(0.0, 0.0);
}

double Terrain::waves(double x, double y) const {
  if (amplitude_ == 0.0) return 0.0;
  double sum = 0.0;
  for (const Wave& wave : waves_) sum += std::sin(wave.kx * x + wave.ky * y + wave.phase);
  return amplitude_ * sum;
}

Eigen::Vector2d RowFrame::plan_from_row(double s, double l) const {
  if (kappa_ == 0.0) return {s, l};
  const double radius = 1.0 / kappa_;
  const double turn = kappa_ * s;
  return {(radius - l) * std::sin(turn), radius - (radius - l) * std::cos(turn)};
}

Eigen::Vector2d RowFrame::row_from_plan(double x, double y) const {
  if (kappa_ == 0.0) return {x, y};
  const double radius = 1.0 / kappa_;
  const double side = kappa_ > 0.0 ? 1.0 : -1.0;
  const double turn = std::atan2(side * x, side * (radius - y));
  return {turn * radius, radius - side * std::hypot(x, radius - y)};
}

Eigen::Matrix2d world_from_plan(double azimuth_deg) {
  const double azimuth = deg_to_rad(azimuth_deg);
  Eigen::Matrix2d rotation;  // columns: forward and left in east, north
  rotation << std::sin(azimuth), -std::cos(azimuth), std::cos(azimuth), std::sin(azimuth);
  return rotation;
}

double FlightPath::Sines::at(double t) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < omega.size(); ++i) sum += std::sin(omega[i] * t + phase[i]);
  return amplitude * sum;
}

FlightPath::Sines FlightPath::make_sines(double sigma, std::uint64_t salt) const {
  base::Random random(seed_of(scene_, salt));
  Sines sines{};
  // Periods of a hovering aircraft in light wind.
  const std::array<std::pair<double, double>, 3> periods_s = {{{5.0, 9.0}, {11.0, 17.0}, {19.0, 31.0}}};
  for (std::size_t i = 0; i < periods_s.size(); ++i) {
    sines.omega[i] = 2.0 * geom::kPi / random.uniform(periods_s[i].first, periods_s[i].second);
    sines.phase[i] = random.uniform(0.0, 2.0 * geom::kPi);
  }
  sines.amplitude = sigma * std::sqrt(2.0 / 3.0);
  return sines;
}

FlightPath::FlightPath(const Scene& scene)
    : scene_(scene), terrain_(scene), rows_(scene.field.curvature_per_m) {
  const Wander& wander = scene.flight.wander;
  cross_ = make_sines(wander.cross_track_m, 11);
  height_ = make_sines(wander.height_m, 12);
  yaw_ = make_sines(deg_to_rad(wander.yaw_deg), 13);
  pitch_ = make_sines(deg_to_rad(wander.pitch_deg), 14);
  roll_ = make_sines(deg_to_rad(wander.roll_deg), 15);
  plan_legs();
  duration_s_ = phases_.back().t1;
  if (!shot_times_.empty()) {
    first_s_ = at(shot_times_.front()).s;
    last_s_ = at(shot_times_.back()).s;
  }
}

void FlightPath::add_phase(double length_s, double speed1, const Target& to, bool smooth) {
  Phase phase{};
  if (phases_.empty()) {
    phase.from = {kCameraOnGround_m, to.pitch_rad, to.cross_track_m, to.yaw_rad};
  } else {
    const Phase& last = phases_.back();
    phase.t0 = last.t1;
    phase.s0 = last.s0 + 0.5 * (last.speed0 + last.speed1) * (last.t1 - last.t0);
    phase.speed0 = last.speed1;
    phase.from = last.to;
  }
  phase.t1 = phase.t0 + length_s;
  phase.speed1 = speed1;
  phase.to = to;
  phase.smooth = smooth;
  phases_.push_back(phase);
}

void FlightPath::plan_legs() {
  const Flight& flight = scene_.flight;
  base::Random random(seed_of(scene_, 16));
  Target last{kCameraOnGround_m, 0.0, 0.0, 0.0};
  for (const Leg& leg : flight.legs) {
    const Target start{leg.height_above_ground_m, deg_to_rad(leg.pitch_deg), leg.cross_track_m,
                       deg_to_rad(leg.yaw_deg)};
    const Target end{leg.end_height_above_ground_m, deg_to_rad(leg.end_pitch_deg), leg.cross_track_m,
                     deg_to_rad(leg.yaw_deg)};
    if (phases_.empty()) {
      last.pitch_rad = start.pitch_rad;
      add_phase(kOnGround_s, 0.0, last, false);
      add_phase(std::max(1.0, start.height_m / kClimb_mps), 0.0, start, true);
      add_phase(kAccelerate_s, flight.speed_mps, start, false);
    } else {
      const double change_s = std::abs(start.height_m - last.height_m) / kChange_mps;
      add_phase(std::max(kShortestChange_s, change_s), flight.speed_mps, start, true);
    }
    add_phase(kSettle_s, flight.speed_mps, start, false);
    const double first_t = phases_.back().t1;
    for (int i = 0; i < leg.shots; ++i) {
      shot_times_.push_back(first_t + i * flight.shot_interval_s +
                            random.uniform(-kShotJitter_s, kShotJitter_s));
    }
    if (leg.shots > 1) add_phase((leg.shots - 1) * flight.shot_interval_s, flight.speed_mps, end, false);
    add_phase(kSettle_s, flight.speed_mps, leg.shots > 1 ? end : start, false);
    last = leg.shots > 1 ? end : start;
  }
  if (phases_.empty()) add_phase(kOnGround_s, 0.0, last, false);
}

CameraState FlightPath::at(double t_s) const {
  const auto after = std::find_if(phases_.begin(), phases_.end(), [&](const Phase& p) { return t_s < p.t1; });
  const Phase& phase = after == phases_.end() ? phases_.back() : *after;
  const double length_s = std::max(phase.t1 - phase.t0, 1e-9);
  const double q = std::clamp((t_s - phase.t0) / length_s, 0.0, 1.0);
  const double w = phase.smooth ? smoothstep(q) : q;
  const auto blend = [w](double a, double b) { return a + w * (b - a); };
  const double planned_m = blend(phase.from.height_m, phase.to.height_m);
  const double wander =
      smoothstep(std::clamp((planned_m - kCameraOnGround_m) / kFullWanderHeight_m, 0.0, 1.0));

  CameraState state;
  state.t_s = t_s;
  const double dt = t_s - phase.t0;  // beyond the last phase the flight goes on straight
  state.s = phase.s0 + phase.speed0 * dt + 0.5 * (phase.speed1 - phase.speed0) * q * dt;
  state.l = blend(phase.from.cross_track_m, phase.to.cross_track_m) + wander * cross_.at(t_s);
  const Eigen::Vector2d xy = rows_.plan_from_row(state.s, state.l);
  const double soil_m = terrain_.height(xy.x(), xy.y());
  const double above_m = planned_m + wander * height_.at(t_s);
  const double z = scene_.flight.follow_terrain ? soil_m + above_m : above_m;
  state.centre_in_plan = {xy.x(), xy.y(), z};
  state.height_above_ground_m = z - soil_m;
  state.attitude.yaw_rad = blend(phase.from.yaw_rad, phase.to.yaw_rad) + wander * yaw_.at(t_s);
  state.attitude.pitch_rad =
      std::max(blend(phase.from.pitch_rad, phase.to.pitch_rad) + wander * pitch_.at(t_s), -0.5 * geom::kPi);
  state.attitude.roll_rad = deg_to_rad(scene_.log.gimbal_roll_bias_deg) + wander * roll_.at(t_s);
  geom::Attitude in_plan = state.attitude;
  in_plan.yaw_rad += rows_.direction(state.s);
  state.cam_from_plan = geom::cam_from_level(in_plan);
  return state;
}

namespace {

ShotTruth truth_at(const Scene& scene, const CameraState& state, std::size_t index) {
  ShotTruth truth;
  const std::string number = std::to_string(index + 1);
  truth.shot_id = "shot-" + std::string(number.size() < 4 ? 4 - number.size() : 0, '0') + number;
  truth.t_log_s = state.t_s;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  rotation.topLeftCorner<2, 2>() = world_from_plan(scene.field.azimuth_deg);
  truth.x_in_world = rotation * state.centre_in_plan;
  truth.cam_from_world.rotation = Eigen::Quaterniond(state.cam_from_plan * rotation.transpose());
  truth.cam_from_world.translation = -(truth.cam_from_world.rotation * truth.x_in_world);
  truth.along_row_m = state.s;
  const double reach = static_cast<double>(scene.field.rows_each_side);
  truth.nearest_row =
      static_cast<int>(std::clamp(std::round(state.l / scene.field.spacing_m), -reach, reach));
  truth.cross_track_m = state.l - truth.nearest_row * scene.field.spacing_m;
  truth.height_above_ground_m = state.height_above_ground_m;
  truth.height_above_canopy_m = state.height_above_ground_m - scene.field.row_height_m;
  truth.attitude = state.attitude;
  const double turned = rad_to_deg(state.attitude.yaw_rad + scene.field.curvature_per_m * state.s);
  truth.heading_deg = std::fmod(std::fmod(scene.field.azimuth_deg - turned, 360.0) + 360.0, 360.0);
  return truth;
}

}  // namespace

std::vector<ShotTruth> true_shots(const Scene& scene) {
  const FlightPath path(scene);
  std::vector<ShotTruth> shots;
  for (std::size_t i = 0; i < path.shot_times().size(); ++i) {
    shots.push_back(truth_at(scene, path.at(path.shot_times()[i]), i));
  }
  return shots;
}

Eigen::Vector3d world_from_row(const Scene& scene, const Eigen::Vector3d& s_l_height) {
  const Eigen::Vector2d xy =
      RowFrame(scene.field.curvature_per_m).plan_from_row(s_l_height.x(), s_l_height.y());
  const Eigen::Vector2d east_north = world_from_plan(scene.field.azimuth_deg) * xy;
  return {east_north.x(), east_north.y(), Terrain(scene).height(xy.x(), xy.y()) + s_l_height.z()};
}

Eigen::Vector3d row_from_world(const Scene& scene, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector2d xy = world_from_plan(scene.field.azimuth_deg).transpose() * x_in_world.head<2>();
  const Eigen::Vector2d row = RowFrame(scene.field.curvature_per_m).row_from_plan(xy.x(), xy.y());
  return {row.x(), row.y(), x_in_world.z() - Terrain(scene).height(xy.x(), xy.y())};
}

}  // namespace furrow::sim
