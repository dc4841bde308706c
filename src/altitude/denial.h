#pragma once
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/flight.h"

namespace furrow::altitude {

/// What a shot says, by itself or in its flight.
struct JudgedShot {
  std::string shot_id;
  Estimate height_above_canopy_m;
  double log_height_m = std::numeric_limits<double>::quiet_NaN();  ///< as ShotInput's
  double residual_rms = 0.0;  ///< of its rows and priors together, weighted
};

/// Where a shot's rows are asked whether they fit: in a field of their own, within what the farm's numbers
/// and the gimbal leave open, or in the one that the flight's shots show together.
enum class JudgedIn { own_field, flight };

/// For each shot the error that names how far worse than the flight's other shots it fits
/// (rows_do_not_fit, eq. 9.10), or nothing. Three shots cannot outvote a fourth.
std::vector<std::optional<Error>> denied_by_fit(const std::vector<JudgedShot>& shots, JudgedIn field,
                                                const FlightOptions& options);

/// For each shot the error that names why its flight cannot take it, or nothing. First those that fit their
/// own rows, the farm and the gimbal far worse than the flight's other shots do (rows_do_not_fit, eq. 9.10),
/// then, of the rest, those whose height parts from their neighbours' and the log's steps
/// (denied_by_neighbours, eq. 9.8). Their rows were miscounted, and tied to the others they would bend the
/// flight.
std::vector<std::optional<Error>> denied_shots(const std::vector<JudgedShot>& shots,
                                               const FlightOptions& options);

}  // namespace furrow::altitude
