#pragma once
#include <string>
#include <vector>

#include "furrow/calib/calibrate.h"

namespace furrow::calib {

/// What a view adds to a calibration, as the shares by which sigmas would grow without it: 0.1 is a tenth
/// more. NaN for views not used; infinity where the rest would not determine the lens. Linear at the solution
/// (docs/formulation/calibration.md, eq. 8).
struct ViewGain {
  std::string image;
  double focal = 0.0;    ///< of the focal length, and so of heights
  double picture = 0.0;  ///< of picture_sigma_px()
};

/// Of every view, in their order; for lenses of any model. All NaN without a covariance.
std::vector<ViewGain> information_gain(const Calibration& calibration);

/// "upper left", "left", "middle" ...: the ninth of the picture in which a pixel lies.
std::string part_of_picture(const Camera& camera, const Eigen::Vector2d& px);

/// A pose of the board that is worth a picture.
struct NextView {
  Rigid3 cam_from_board;
  Eigen::Vector2d middle_px;  ///< where the middle of its corners is seen
  double distance_m = 0.0;    ///< from the camera to the middle of its corners
  /// From facing the camera: about its own x (above 0: its top comes nearer), then about its own y (above 0:
  /// its right side comes nearer); and a quarter turn in its plane before both.
  double tilt_x_rad = 0.0, tilt_y_rad = 0.0;
  bool upright = false;
  /// Expected once it and the poses before it are taken.
  double picture_sigma_px = 0.0, focal_percent = 0.0;
  std::string how_to_hold;  ///< the pose, in words
  std::string sentence;     ///< and what it brings
};

/// The poses that lower picture_sigma_px() most, each counting on those before it: the best of a ladder of
/// places, sizes and tilts in which the whole board shows, from half the nearest distance at which a board
/// was seen to twice the farthest. Corners are taken as sharp as those there are. Empty without a covariance.
std::vector<NextView> next_views(const Calibration& calibration, int count = 3);

}  // namespace furrow::calib
