#pragma once
#include <Eigen/Core>
#include <vector>

#include "edge_line.h"

namespace furrow::altitude {

/// Direction of the rows in the camera, with the information that the lines give about it.
struct RowDirectionFit {
  Eigen::Vector3d direction;
  double pitch_sigma = 0.0;
};

/// Eq. 3.2: all edges of all rows are parallel in the world, walls too, so all their planes hold the row
/// direction.
RowDirectionFit fit_direction(const std::vector<EdgeLine>& lines);

/// Yaw that turns the rows' planes onto a row direction of known pitch (eq. 3.4).
double yaw_at_pitch(const std::vector<EdgeLine>& lines, double theta);

}  // namespace furrow::altitude
