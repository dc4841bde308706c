#pragma once
#include <limits>

#include "furrow/base/result.h"
#include "furrow/telemetry/track.h"

namespace furrow::sync {

/// Where a video clip's own telemetry (subtitles) lies in the flight log: t_log = t_clip + shift_ns.
struct ClipAlignment {
  base::Nanoseconds shift_ns = 0;
  double sigma_s = std::numeric_limits<double>::quiet_NaN();       ///< from the curvature of the misfit
  double height_rms_m = std::numeric_limits<double>::quiet_NaN();  ///< NaN when clip or log has no height
  double speed_rms_mps = std::numeric_limits<double>::quiet_NaN();
  int rows = 0;  ///< rows of the clip that were compared
  /// Misfit (sum of squares over their variance) of the best shift more than 2 s away, less that of the best
  /// one.
  double margin = 0.0;
};

struct AlignOptions {
  /// Clip and log both show the aircraft's height and speed in steps of 0.1; the difference of two such
  /// roundings has 0.1 / sqrt(6). Enlarged by what the two records differ in age.
  double height_sigma_m = 0.05;
  double speed_sigma_mps = 0.1;
  /// Below this the runner-up is no worse than noise would make it and the answer is refused. Five sigma of
  /// one quantity: 25.
  double least_margin = 25.0;
};

/// Finds the shift at which height above take-off and speed of clip and log agree best (mean square over the
/// clip's rows, shifts of 0.1 s, then a parabola). At least half the clip must lie in the log. Errors:
/// alignment_no_data, alignment_ambiguous (a hover looks like any other).
Result<ClipAlignment> align_clip(const telemetry::Track& clip, const telemetry::Track& log,
                                 const AlignOptions& options = {});

}  // namespace furrow::sync
