#pragma once
#include <optional>

#include "furrow/stats/estimate.h"

namespace furrow::follow {

/// A PID loop. Units: the output's unit per the error's for the gains, per second more for `ki`, less for
/// `kd`.
struct PidOptions {
  double kp = 0.0, ki = 0.0, kd = 0.0;
  double limit = 1.0;           ///< |output| stays at or below it
  double integral_limit = 0.5;  ///< the same for the integral's part of the output
};

/// What the loop carries from step to step: the integral's part of the output.
struct PidState {
  double integral = 0.0;
};

struct PidStep {
  PidState state;
  double output = 0.0;
  bool is_limited = false;
};

/// One step over `dt_s` with the error and its rate (of the filter, not a difference of noisy values).
/// Against wind-up the integral stands still while the output is limited and the error would drive it on
/// (docs/formulation/follow.md, section 4).
PidStep pid_step(const PidState& before, const PidOptions& options, double error, double error_rate,
                 double dt_s);

/// What the aircraft is asked to do, in its own level axes: forward, right, down, clockwise from above.
struct BodyVelocity {
  double forward_mps = 0.0, right_mps = 0.0, down_mps = 0.0, yaw_rate_rad_s = 0.0;
};

struct GuidanceOptions {
  double forward_mps = 0.0;  ///< speed along the row while it is followed
  /// Lateral speed from the cross-track. Defaults: half the offset in a second without overshoot at the 0.3 s
  /// that a small multirotor takes to follow a velocity, at most walking pace.
  PidOptions lateral{.kp = 0.5, .ki = 0.05, .kd = 0.1, .limit = 0.5, .integral_limit = 0.1};
  /// Yaw rate, rad/s, from the heading error.
  PidOptions yaw{.kp = 0.5, .ki = 0.0, .kd = 0.0, .limit = 0.35, .integral_limit = 0.1};
};

/// What there is to steer by: camera left of the row, and the camera's heading to the left of it.
struct SteeringError {
  double cross_track_m = 0.0, cross_track_rate_mps = 0.0;
  double heading_rad = 0.0;
};

struct Guidance {
  BodyVelocity velocity;  ///< all zero on hold: the aircraft stands
  PidState lateral, yaw;
  bool is_hold = true;
};

/// Steers to the right when the camera is to the left. Nothing to steer by means hold: all speeds zero,
/// integrals forgotten.
Guidance guidance_step(const Guidance& before, const std::optional<SteeringError>& error, double dt_s,
                       const GuidanceOptions& options);

}  // namespace furrow::follow
