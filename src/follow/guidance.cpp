#include "furrow/follow/guidance.h"

#include <algorithm>
#include <cmath>

namespace furrow::follow {

PidStep pid_step(const PidState& before, const PidOptions& options, double error, double error_rate,
                 double dt_s) {
  const double direct = options.kp * error + options.kd * error_rate;
  const double grown = std::clamp(before.integral + options.ki * error * std::max(dt_s, 0.0),
                                  -options.integral_limit, options.integral_limit);
  const double wanted = direct + grown;
  const bool drives_on = std::abs(wanted) > options.limit && wanted * (grown - before.integral) > 0.0;
  PidStep step;
  step.state.integral = drives_on ? before.integral : grown;
  const double output = direct + step.state.integral;
  step.output = std::clamp(output, -options.limit, options.limit);
  step.is_limited = std::abs(output) > options.limit;
  return step;
}

Guidance guidance_step(const Guidance& before, const std::optional<SteeringError>& error, double dt_s,
                       const GuidanceOptions& options) {
  if (!error) return {};
  const PidStep lateral =
      pid_step(before.lateral, options.lateral, error->cross_track_m, error->cross_track_rate_mps, dt_s);
  const PidStep yaw = pid_step(before.yaw, options.yaw, error->heading_rad, 0.0, dt_s);
  Guidance now;
  now.is_hold = false;
  now.lateral = lateral.state;
  now.yaw = yaw.state;
  now.velocity = {options.forward_mps, lateral.output, 0.0, yaw.output};
  return now;
}

}  // namespace furrow::follow
