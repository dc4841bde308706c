#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/shot_height.h"
#include "furrow/base/result.h"

namespace furrow::altitude {

/// One shot of a flight, as far as the refinement needs it.
struct ShotInput {
  std::string shot_id;
  rows::RowLines lines;
  /// What the gimbal says; sigma is the total, bias and noise together, as for refine_shot.
  AttitudePrior attitude;
  /// Height by the log above any fixed level (barometer, IMU), metres; NaN when not known. Only its steps are
  /// used.
  double log_height_m = std::numeric_limits<double>::quiet_NaN();
  /// +1 when the shot looks along the rows' direction, -1 against it: on sloping ground the two see opposite
  /// pitch errors.
  double direction = 1.0;
};

struct FlightOptions {
  RefineOptions shot;
  /// One-sigma of the logged angles against the rows' plane from shot to shot, apart from what is common to
  /// the flight: gimbal, rounding of the log, waves of the ground
  /// (shot.terrain_slope_sigma_rad counts for the biases, which take a slope for their own). Default 0.3 deg:
  /// logs give 0.1 deg steps, gimbals hold to 0.2 deg, and a picture averages the ground over ten metres and
  /// more.
  double angle_noise_rad = 0.0052;
  /// So many shots in a row see much the same plants, whose own shapes then do not average out: the sigmas of
  /// all that is common to the flight grow by its root. Default: a shot every metre or two, and the nearest
  /// six metres of the rows tell most. 1 for shots that share no plants.
  double shots_per_stretch = 4.0;
  /// One-sigma of the slope of the rows' plane along the flight, common to all shots, in the direction of
  /// travel. 0: the pitch bias then includes the slope, which a flight one way cannot tell from it. Give it
  /// when shots look both ways (ShotInput::direction).
  double mean_slope_sigma_rad = 0.0;
  /// One-sigma of the common factor on the focal length; 0 keeps the camera's. Worth more than 0 only when
  /// log heights are given.
  double focal_sigma = 0.0;
  /// One-sigma of how far a step of the height differs from the log's step, between neighbouring shots that
  /// both have a log height.
  double log_step_sigma_m = 0.15;
  /// One-sigma of a step of the height itself between neighbouring shots; NaN for no such tie.
  double height_step_sigma_m = std::numeric_limits<double>::quiet_NaN();
  /// A shot whose own rows, farm and gimbal fit worse than this many times the flight's median (or their
  /// claims, where that is better), alone or beside what the flight shares, is left out with the status
  /// rows_do_not_fit. Right shots of renders fit alone within 2.0 times.
  double misfit_over_others = 2.5;
  /// A shot whose own height is farther from what the log's steps make of up to six shots around it than this
  /// many sigmas (its own, their scatter, log_step_sigma_m), or than 2.5 of them where half or twice its
  /// height would suit, is left out with the status denied_by_neighbours. Needs log heights. Raise it for
  /// logs that jump between neighbouring shots.
  double neighbour_conflict_sigmas = 5.0;
  /// Threads for the work that is done shot by shot; 0: one per core. The result does not depend on it.
  int threads = 0;
};

/// A quantity common to the flight, and whether the flight told it.
struct SharedQuantity {
  std::string name;    ///< pitch_bias, roll_bias, terrain_slope, focal_factor, row_spacing, half_width,
                       ///< foliage_depth, base_ratio, rounding
  Estimate prior;      ///< what was known before
  Estimate posterior;  ///< what is known after all shots
  /// Posterior sigma over prior sigma: 1 when the flight says nothing about it, near 0 when the flight alone
  /// fixes it.
  double sigma_ratio = 1.0;
  /// The name of the shared quantity that it correlates with most, and that correlation: near -1 or 1, only
  /// the two together are told.
  std::string most_correlated;
  double correlation = 0.0;
};

/// A flight's refinement.
struct RefinedFlight {
  std::vector<RefinedShot> shots;   ///< one for each input; not usable where status is not "ok"
  std::vector<std::string> status;  ///< "ok", or the shot's error code
  std::vector<std::string> reason;  ///< the shot's error message when not ok
  /// Log minus true pitch and roll; against the rows' plane when mean_slope_sigma_rad is 0, against level
  /// ground otherwise.
  Estimate pitch_bias_rad, roll_bias_rad;
  Estimate row_spacing_m, half_width_m, foliage_depth_m;
  std::vector<SharedQuantity> shared;
  Eigen::MatrixXd shared_correlation;  ///< in the order of `shared`
  int iterations = 0;
  double residual_rms = 0.0;  ///< weighted; about 1 when the sigmas are right
  std::string termination = "never ran";
  /// Why there is no answer for the flight as a whole: no_usable_shot (with the first shot's reason) where
  /// each shot failed or was denied, solve_failed. `status` and `reason` say of each shot what was made of
  /// it.
  std::optional<Error> failure = Error{"not_run", "flight", "not refined yet", "", ""};

  bool usable() const { return !failure; }
  /// Whether the flight leaves the shot out for what the other shots say (denied_by_neighbours,
  /// rows_do_not_fit); what the shot says alone is then not to be believed either.
  bool denies(std::size_t shot) const;
};

/// All shots at once: each has its height, angles and cross-track; gimbal bias, slope, focal factor and the
/// farm's numbers are shared (docs/formulation/altitude.md, section 9). Time and memory grow linearly with
/// the shots. Errors: no_shots, no_spacing, not_finite, bad_field; see also `failure`.
Result<RefinedFlight> refine_flight(const std::vector<ShotInput>& shots, const Camera& camera,
                                    const FieldKnowledge& field, const FlightOptions& options = {});

/// Why a flight has no answer as a whole, be it bad input or its shots; nothing where it has one.
std::optional<Error> failure_of(const Result<RefinedFlight>& flight);

}  // namespace furrow::altitude
