#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "furrow/calib/calibrate.h"

namespace furrow::calib {

/// A picture of the board that is worth a look, and what a drawing over it needs beside its corners.
struct TellingView {
  std::size_t view = 0;  ///< place in Calibration::views
  std::string why;       ///< "lowest RMS"; what the view's own reason says where it was not used
  /// The part of the picture to show, whole pixels: all of it where the board takes at least half of its
  /// width or height, else so much around the board that it does.
  int left_px = 0, top_px = 0, width_px = 0, height_px = 0;
  /// The board's first row and column from its first corner to the third, as projected; empty without a pose.
  std::vector<Eigen::Vector2d> x_axis_px, y_axis_px;
};

struct TellingViews {
  std::vector<TellingView> views;
  double residual_px =
      0.0;  ///< 95 of 100 corners of the used views that were not left out lie nearer to their projections
  double spacing_px = 0.0;  ///< median distance of a corner of these views to its nearest neighbour
};

/// The used views of the lowest, the median and the highest RMS and the one with most corners left out; then,
/// up to five in all, those dropped for their error, worst first, and pictures that were searched and show no
/// board, by name. Copies and unreadable pictures are never among them. `detections` are those that the
/// calibration was made of.
TellingViews telling_views(const Calibration& calibration,
                           const std::vector<target::BoardDetection>& detections);

}  // namespace furrow::calib
