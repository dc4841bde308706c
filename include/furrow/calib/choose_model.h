#pragma once
#include <string>
#include <vector>

#include "furrow/calib/calibrate.h"

namespace furrow::calib {

/// How well one lens model foretells pictures that it was not solved from.
struct ModelTrial {
  camera::CameraModel model = camera::CameraModel::pinhole;
  int parameters = 0;
  double held_out_rms_px =
      0.0;             ///< over the pictures left out, their poses fitted; NaN when no solve came off
  std::string reason;  ///< why there is none
};

struct ModelChoice {
  camera::CameraModel model = camera::CameraModel::opencv5;
  std::vector<ModelTrial> trials;  ///< fewest parameters first
  std::string sentence;            ///< the choice and its reason
};

/// Cross-validation: the views, in name order, are dealt into three parts; each model is solved from two of
/// them and the corners of the third foretold, its poses fitted with the lens held. Of the models within 1 %
/// of the best the one with the fewest parameters is taken. Tried: opencv4, 5, 8 and 12, fisheye, and the
/// splined one from 2000 corners on. Errors: those of calibrate() when none comes off; too_few_boards below 6
/// views.
Result<ModelChoice> choose_model(const std::vector<target::BoardDetection>& detections,
                                 const target::BoardSpec& board, const CalibrateOptions& options = {});

/// A camera on new pictures of a board: each board's pose is fitted, the lens held as it is. `used` views
/// have pose, residuals and RMS; the others a reason.
std::vector<View> locate_boards(const Camera& camera, const std::vector<target::BoardDetection>& detections,
                                const target::BoardSpec& board);

}  // namespace furrow::calib
