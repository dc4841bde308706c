#pragma once
#include <array>
#include <Eigen/Core>
#include <vector>

#include "furrow/geom/attitude.h"
#include "furrow/sim/scene.h"

// Where things are. plan: level frame at the world's origin with x along row 0 at s = 0, y left, z up; row
// coordinates (s, l, height above the soil) follow the rows when these are curved.
namespace furrow::sim {

/// Soil height over the plan.
class Terrain {
 public:
  explicit Terrain(const Scene& scene);
  double height(double x, double y) const { return plane(x, y) + waves(x, y) - offset_; }
  /// Height and its bounds, for stepping along rays.
  double steepest() const { return steepest_; }
  double highest_wave() const { return amplitude_sum_; }
  bool flat() const { return amplitude_sum_ == 0.0; }
  const Eigen::Vector2d& slope() const { return slope_; }

 private:
  struct Wave {
    double kx, ky, phase;
  };
  double plane(double x, double y) const { return slope_.x() * x + slope_.y() * y; }
  double waves(double x, double y) const;

  Eigen::Vector2d slope_;
  std::array<Wave, 3> waves_{};
  double amplitude_ = 0.0;
  double amplitude_sum_ = 0.0;
  double steepest_ = 0.0;
  double offset_ = 0.0;
};

/// Row coordinates against the plan: concentric arcs of curvature 1 / (1/kappa - l).
class RowFrame {
 public:
  explicit RowFrame(double curvature_per_m) : kappa_(curvature_per_m) {}
  Eigen::Vector2d plan_from_row(double s, double l) const;
  Eigen::Vector2d row_from_plan(double x, double y) const;
  /// Direction of the rows at s, to the left of the plan's x axis, radians.
  double direction(double s) const { return kappa_ * s; }

 private:
  double kappa_;
};

/// Rotation from the plan to east-north.
Eigen::Matrix2d world_from_plan(double azimuth_deg);

/// The camera at one moment.
struct CameraState {
  double t_s = 0.0;
  double s = 0.0, l = 0.0;  ///< row coordinates
  Eigen::Vector3d centre_in_plan;
  double height_above_ground_m = 0.0;
  geom::Attitude attitude;        ///< against the row's direction at s
  Eigen::Matrix3d cam_from_plan;  ///< rotation
};

/// The flight as a function of time.
class FlightPath {
 public:
  explicit FlightPath(const Scene& scene);
  CameraState at(double t_s) const;
  const std::vector<double>& shot_times() const { return shot_times_; }
  double duration_s() const { return duration_s_; }
  /// s of the first and last shot.
  double first_s() const { return first_s_; }
  double last_s() const { return last_s_; }

 private:
  struct Target {
    double height_m, pitch_rad, cross_track_m, yaw_rad;
  };
  struct Phase {
    double t0, t1;
    double s0, speed0, speed1;  ///< speed changes evenly over the phase
    Target from, to;
    bool smooth;  ///< smoothstep from `from` to `to`, else straight
  };
  struct Sines {
    std::array<double, 3> omega, phase;
    double amplitude;
    double at(double t) const;
  };
  void add_phase(double length_s, double speed1, const Target& to, bool smooth);
  void plan_legs();
  Sines make_sines(double sigma, std::uint64_t salt) const;

  const Scene scene_;
  Terrain terrain_;
  RowFrame rows_;
  std::vector<Phase> phases_;
  std::vector<double> shot_times_;
  Sines cross_, height_, yaw_, pitch_, roll_;
  double duration_s_ = 0.0, first_s_ = 0.0, last_s_ = 0.0;
};

}  // namespace furrow::sim
