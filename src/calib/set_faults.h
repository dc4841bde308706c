#pragma once
#include <vector>

#include "furrow/calib/verdict.h"

namespace furrow::calib {

/// "zoom": whether the focal length changes from one picture on. Each view's own focal length, the rest of the
/// lens held, is estimated by one step; where two runs of pictures, in name order, differ most beyond their
/// noise, both are solved apart. Not met when that fits better and the focal lengths differ by over 1 % and by
/// five sigma, widened by `sigma_factor`: what two interleaved halves differ by is no zoom. value: the
/// difference in percent.
Criterion zoom_criterion(const Calibration& calibration, const std::vector<target::BoardDetection>& detections,
                         const CalibrateOptions& options, double sigma_factor);

/// "bend": by how much the focal length moves, in percent, once the board's bend is solved too. Not met
/// beyond `limit_percent` and three sigma.
Criterion bend_criterion(const Calibration& calibration,
                         const std::vector<target::BoardDetection>& detections,
                         const CalibrateOptions& options, double limit_percent);

}  // namespace furrow::calib
