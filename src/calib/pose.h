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

/// The other pose in which a flat board looks nearly the same: its tilt against the line of sight to its
/// middle reversed (Schweighofer and Pinz 2006).
Rigid3 mirrored_pose(const target::BoardSpec& board, const Rigid3& cam_from_board);

}  // namespace furrow::calib
