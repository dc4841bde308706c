#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "calib/model.h"
#include "furrow/camera/camera.h"
#include "furrow/geom/rigid3.h"
#include "furrow/target/board.h"

namespace furrow::calib {

/// A camera without distortion and poses to start from, with no guess from the user.
struct Start {
  Camera camera;
  std::vector<Rigid3> cam_from_board;
};

/// Zhang's closed form with the principal point at the picture's middle, free and square pixels, beside a
/// ladder of fields of view; the one that reprojects best is taken. Nothing when a view's corners allow no
/// homography or no pose.
std::optional<Start> find_start(const std::vector<SeenCorners>& views, const target::BoardSpec& board,
                                int width, int height);

/// The same for a wide lens: `model` (fisheye without coefficients, stereographic, latlon) at a ladder of
/// fields of view from 230 to 20 degrees, whichever reprojects best.
std::optional<Start> find_wide_start(const std::vector<SeenCorners>& views, const target::BoardSpec& board,
                                     int width, int height, camera::CameraModel model);

/// Pose of a plane seen by a pinhole camera, from its homography; nothing when it is degenerate.
std::optional<Rigid3> pose_from_homography(const Camera& camera, const Eigen::Matrix3d& picture_from_board);

}  // namespace furrow::calib
