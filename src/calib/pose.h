#pragma once
#include <optional>
#include <vector>

#include "calib/model.h"

namespace furrow::calib {

/// Pose of a board from where its corners are seen, whatever the lens: rays turned so that their mean looks
/// along z, a homography there, and back. Nothing when a corner has no ray, or the corners allow no pose.
std::optional<Rigid3> pose_from_corners(const Camera& camera, const target::BoardSpec& board,
                                        const SeenCorners& seen);

/// The pose with the least sum of squared distances in px, the lens and the board held as they are; nothing
/// where the search leaves the camera's view. Gauss-Newton with step halving.
std::optional<PoseVector> refine_pose(const SharedModel& model, const PoseVector& start,
                                      const SeenCorners& seen);

}  // namespace furrow::calib
