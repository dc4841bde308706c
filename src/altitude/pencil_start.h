#pragma once
#include <vector>

#include "furrow/geom/angles.h"
#include "gimbal_prior.h"
#include "pencil.h"
#include "relative_farm.h"
#include "row_direction.h"

namespace furrow::altitude {

/// Beyond this yaw a cut along a picture row meets the rows at less than 30 deg and is no cut across a row.
inline constexpr double kMaxYaw = geom::deg_to_rad(60.0);

/// Where the adjustment of the pencil starts: lines below the horizon, those of tops, angles and slopes.
struct PencilStart {
  std::vector<EdgeLine> lines, tops;
  RowAxes<double> axes;
  PencilVector value;
  double misfit = 0.0;
};

/// Starts from the gimbal's roll, unless another within three of its sigmas suits the rows clearly better: on
/// ground that slopes across, steps between rows grow to the one side and shrink to the other, and their
/// median, and which lines carry a wrong index, are off (eq. 3.12).
PencilStart best_start(const std::vector<EdgeLine>& lines, const RowDirectionFit& direction,
                       const GimbalPrior& gimbal, bool parallel, const RelativeFarm& farm);

}  // namespace furrow::altitude
