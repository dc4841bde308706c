#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/camera/camera.h"
#include "furrow/rows/row_lines.h"

namespace furrow::altitude {

/// One cut across a row as directions: (x, y) on the plane z = 1 of the camera, with one-sigma across the row
/// in the same unit.
struct RowDirection {
  Eigen::Vector2d centre;
  double sigma = 0.0;
  std::optional<Eigen::Vector2d> left, right;  ///< edges of the visible row
  double edge_sigma = std::numeric_limits<double>::quiet_NaN();
  /// Far edges of the top against leaves; their sigma is common to the row.
  std::optional<Eigen::Vector2d> top_left = {}, top_right = {};
  double top_sigma = std::numeric_limits<double>::quiet_NaN();
};

/// All that a picture knows: angles, no metres. The hinge between what is seen and what the farm knows.
struct RowsOnUnitPlane {
  struct Row {
    int index = 0;
    std::vector<RowDirection> directions;  ///< from the picture's top to its bottom
  };
  std::vector<Row> rows;
  std::optional<Eigen::Vector2d> vanishing_point;
};

/// Takes rows from pixels to directions through the full camera model; samples that the model cannot
/// unproject are left out. Errors: rows_not_ok (the detection's own reason), picture_size_differs (camera and
/// picture).
Result<RowsOnUnitPlane> rows_on_unit_plane(const rows::RowLines& lines, const Camera& camera);

}  // namespace furrow::altitude
