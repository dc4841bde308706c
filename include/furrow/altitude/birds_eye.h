#pragma once
#include <Eigen/Core>
#include <vector>

#include "furrow/altitude/shot_height.h"
#include "furrow/camera/camera.h"
#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"

namespace furrow::altitude {

/// A found row on the plane of the row tops: points (ahead, left) of the camera's foot there, metres.
struct GroundRow {
  int index = 0;
  bool seen = true;
  std::vector<Eigen::Vector2d> centre_m, left_m, right_m;  ///< far to near
};

/// A shot as seen from straight above the plane of the row tops, up in the picture being ahead along the
/// rows. Only what lies in that plane is true to scale: soil and walls lean away from the camera.
struct BirdsEye {
  Image picture;           ///< RGB; black where the camera did not look
  double px_per_m = 0.0;   ///< along both axes
  double ahead_m = 0.0;    ///< of the picture's upper border from the camera's foot
  double left_m = 0.0;     ///< of its left border
  double spacing_m = 0.0;  ///< of the refined field
  double half_width_m = 0.0;
  double cross_track_m =
      0.0;  ///< of the camera, left of row 0: row k's axis lies at left = -cross_track - k spacing
  std::vector<GroundRow> rows;  ///< as detected, carried to the plane by the refined pose
};

struct BirdsEyeOptions {
  /// Farthest ground shown: where one picture row covers this much of it. Beyond, a picture is smeared, not
  /// seen.
  double coarsest_m_per_px = 0.25;
  double aside_spacings = 4.5;  ///< shown on either side of the camera, spacings at most
  int longest_side_px = 1000;
};

/// The picture of a refined shot, resampled. Errors: picture_size_differs (picture, rows and camera),
/// not_refined (the shot has no usable pose), no_ground (nothing of the plane is in the picture).
Result<BirdsEye> birds_eye(const Image& picture, const rows::RowLines& lines, const Camera& camera,
                           const RefinedShot& shot, const BirdsEyeOptions& options = {});

}  // namespace furrow::altitude
