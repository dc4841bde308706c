#pragma once
#include <array>
#include <optional>
#include <vector>

#include "furrow/rows/row_lines.h"
#include "rows/row_light.h"
#include "rows/common_model.h"

namespace furrow::rows {

/// Where edges against the ground lie, in row numbers: the followed row's, and those of the rows beside it.
struct GroundEdges {
  double middle = 0.0, half_width = 0.0;
  double near_left = 0.0, near_right = 0.0;  ///< distances of the neighbours' near edges from the middle
  /// Mean distance of their far edges, where both show these against the ground, too.
  std::optional<double> far;

  double near() const { return 0.5 * (near_left + near_right); }
};

/// Nothing where the followed row does not show both edges, or neither neighbour its near one.
std::optional<GroundEdges> ground_edges(const std::vector<RowLine>& rows, const CommonModel& model);

/// How tops stand against what is behind them.
struct TopLight {
  double spacing = 0.0;                        ///< row numbers of the model
  std::array<bool, 2> rises = {false, false};  ///< the light at far edges, on the left and right
};

/// What the light beside the followed row says of the tops.
struct TopsByLight {
  std::optional<TopLight> tops;
  double by_saw = 0.0;    ///< part of the light's squares that the best saw explains
  double by_faces = 0.0;  ///< part of the leaves' that walls and tops of any light explain; 0 when not tried
};

/// `sides` count bare ground as dark, in `leaf_sides` it is not there.
TopsByLight tops_by_light(const std::array<LightSide, 2>& sides, const std::array<LightSide, 2>& leaf_sides,
                          const GroundEdges& ground, const Fan& fan);

/// A tilt of the rows' plane that the fan does not count with, where a saw under it explains clearly more
/// than without (FoundTops::tilt), else 0; and the part of the light's squares that the saw explains.
struct TiltByLight {
  double tilt = 0.0, by_saw = 0.0;
};
TiltByLight tilt_by_light(const std::array<LightSide, 2>& sides, const GroundEdges& ground, const Fan& fan);

}  // namespace furrow::rows
