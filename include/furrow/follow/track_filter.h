#pragma once
#include <Eigen/Core>
#include <optional>

#include "furrow/base/time.h"
#include "furrow/stats/estimate.h"

namespace furrow::follow {

/// Filter of one quantity over a sequence: an offset in metres or pixels, or an angle
/// (docs/formulation/follow.md). "Unit" is the unit of that quantity.
struct FilterOptions {
  /// One-sigma of the change of the rate in one second, unit/s: how lively the aircraft moves. Default: a
  /// multirotor in light wind. Larger follows faster and smooths less.
  double agility = 1.0;
  /// One-sigma of the rate before anything was seen, unit/s.
  double start_rate_sigma = 0.5;
  /// Part of a measurement's variance that pictures shortly after each other have in common, since they show
  /// the same plants; it does not average out. And the time after which it is forgotten to 1/e, seconds: that
  /// which the plants of the near half of the picture take to leave it.
  double common_share = 0.5;
  double common_time_s = 2.0;
  /// A measurement farther from the prediction than this many sigmas of their difference is left out; after
  /// so many in a row the filter starts anew from them.
  double gate_sigmas = 4.0;
  int restart_after = 5;
  /// Beyond this time without a measurement, or this sigma, there is no answer any more: hold.
  double hold_after_s = 1.0;
  double hold_sigma = 0.5;
};

enum class Intake {
  nothing,    ///< no measurement came
  used,       ///< it took part
  left_out,   ///< it came, but beyond the gate
  restarted,  ///< the filter began with it, or began anew
};

/// What is known after a picture. The default knows nothing.
struct Filtered {
  base::Nanoseconds t_ns = 0, last_used_ns = 0;
  bool has_started = false;
  /// Value, its rate per second, and the common error of the measurements in units of their sigma; with
  /// covariance.
  Eigen::Vector3d state = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  Intake intake = Intake::nothing;
  int left_out_in_row = 0;
  int used = 0;
};

/// Kalman prediction to `t_ns`, later than `before`'s, and update with `measured`; a measurement that is not
/// usable is only predicted over, with growing sigma.
Filtered filter_step(const Filtered& before, base::Nanoseconds t_ns, const Estimate& measured,
                     const FilterOptions& options);

/// The value with its sigma, or nothing where `options` say hold.
std::optional<Estimate> filtered_value(const Filtered& filtered, const FilterOptions& options);
/// Change of the value per second.
Estimate filtered_rate(const Filtered& filtered);

/// The same counted from another zero: `shift` is added to the value.
Filtered shifted(Filtered filtered, double shift);

}  // namespace furrow::follow
