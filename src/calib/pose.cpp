#include "calib/pose.h"

#include <cmath>
#include <Eigen/Dense>

#include "calib/start.h"
#include "furrow/target/homography.h"

namespace furrow::calib {

std::optional<Rigid3> pose_from_corners(const Camera& camera, const target::BoardSpec& board,
                                        const SeenCorners& seen) {
  std::vector<Eigen::Vector3d> rays;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2d& px : seen.px) {
    const auto ray = camera::unproject_ray(camera, px);
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
    sum += *ray;
  }
  const Eigen::Quaterniond level_from_cam = Eigen::Quaterniond::FromTwoVectors(sum, Eigen::Vector3d::UnitZ());
  const std::vector<Eigen::Vector3d> corners = target::corners_in_board(board);
  std::vector<Eigen::Vector2d> plane, level_xy;
  for (std::size_t c = 0; c < seen.px.size(); ++c)
    plane.push_back(corners[static_cast<std::size_t>(corner_id(seen.ids, c))].head<2>());
  // A board never spans so much that a corner of it stands beside its middle's plane.
  constexpr double kFarthestOff = 0.02;
  for (const Eigen::Vector3d& ray : rays) {
    const Eigen::Vector3d level = level_from_cam * ray;
    if (level.z() < kFarthestOff) return std::nullopt;
    level_xy.emplace_back(level.hnormalized());
  }
  const auto homography = target::fit_homography(plane, level_xy);
  Camera ideal;
  ideal.fx = ideal.fy = 1.0;
  const auto pose = homography ? pose_from_homography(ideal, *homography) : std::nullopt;
  if (!pose) return std::nullopt;
  return Rigid3{(level_from_cam.conjugate() * pose->rotation).normalized(),
                level_from_cam.conjugate() * pose->translation};
}

std::optional<PoseVector> refine_pose(const SharedModel& model, const PoseVector& start,
                                      const SeenCorners& seen) {
  const auto rows = static_cast<Eigen::Index>(2 * seen.px.size());
  const Eigen::VectorXd shared = shared_of(model);
  PoseVector pose = start;
  Eigen::VectorXd residual(rows), trial(rows);
  RowMajor by(rows, 6);
  constexpr int kMostSteps = 50;
  constexpr double kConverged = 1e-12;
  for (int step = 0; step < kMostSteps; ++step) {
    if (!evaluate_view(model, shared, pose, seen, {}, residual.data(), nullptr, by.data()))
      return std::nullopt;
    const PoseVector delta = -(by.transpose() * by).ldlt().solve(by.transpose() * residual);
    if (!delta.allFinite()) return std::nullopt;
    double share = 1.0;
    constexpr double kSmallestShare = 1e-3;
    while (share > kSmallestShare &&
           !(evaluate_view(model, shared, pose + share * delta, seen, {}, trial.data(), nullptr, nullptr) &&
             trial.squaredNorm() <= residual.squaredNorm()))
      share *= 0.5;
    if (share <= kSmallestShare) return pose;
    pose += share * delta;
    if (residual.squaredNorm() - trial.squaredNorm() <= kConverged * residual.squaredNorm()) return pose;
  }
  return pose;
}

Rigid3 mirrored_pose(const target::BoardSpec& board, const Rigid3& cam_from_board) {
  const Eigen::Vector3d middle_in_board =
      0.5 * target::corner_in_board(board, board.corners_x - 1, board.corners_y - 1);
  const Eigen::Vector3d middle = cam_from_board * middle_in_board, way = middle.normalized(),
                        normal = cam_from_board.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d axis = normal.cross(way);
  const double sine = axis.norm();
  Rigid3 out = cam_from_board;
  if (!(sine > 0.0)) return out;
  const double tilt = std::atan2(sine, normal.dot(way));
  out.rotation = Eigen::AngleAxisd(2.0 * tilt, axis / sine) * cam_from_board.rotation;
  out.translation = middle - out.rotation * middle_in_board;
  return out;
}

}  // namespace furrow::calib
