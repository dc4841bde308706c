#pragma once
#include <optional>
#include <string>
#include <vector>

#include "furrow/telemetry/shot.h"
#include "furrow/telemetry/track.h"

namespace furrow::sync {

/// What the aircraft knew at the moment of a shot.
struct ShotPose {
  std::string shot_id;
  bool located = false;
  std::string reason;  ///< when not located
  /// Interpolated between log rows; from the picture's metadata where there is no log, and where the log says
  /// nothing.
  telemetry::Sample state;
  /// One sigma of the moment in the log, from the steps of marks and clocks alone; NaN when not placed in a
  /// log. A constant lag of the marks behind the shutter is not in it.
  double t_sigma_s = telemetry::kMissing;
};

/// How the shots were found in the log.
struct Located {
  /// "picture time", "isPhoto marks", "isPhoto marks by time pattern", "picture local time" or
  /// "picture metadata only"; docs/telemetry.md says when each is used.
  std::string method;
  std::vector<ShotPose> poses;  ///< one per shot, same order
  std::vector<std::string> warnings;
};

/// Places shots in a log: by their own UTC time when they have it, else the i-th shot by the i-th isPhoto
/// mark. Without a log the metadata of each picture is all there is. Errors: shots_not_locatable (says how
/// many shots, marks and times there are).
Result<Located> locate_shots(const std::vector<telemetry::Shot>& shots,
                             const std::optional<telemetry::Track>& track);

/// State at `t_log_ns`, linear between rows (angles the short way round, flags from the nearer row); nothing
/// outside the log.
std::optional<telemetry::Sample> interpolate(const telemetry::Track& track, base::Nanoseconds t_log_ns);

}  // namespace furrow::sync
