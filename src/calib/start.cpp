#include "calib/start.h"

#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <numbers>

#include "calib/pose.h"
#include "furrow/target/homography.h"

namespace furrow::calib {
namespace {

/// The corners that a view shows, on the board's plane.
std::vector<Eigen::Vector2d> on_board(const std::vector<Eigen::Vector3d>& corners, const SeenCorners& view) {
  std::vector<Eigen::Vector2d> out;
  for (std::size_t c = 0; c < view.px.size(); ++c)
    out.push_back(corners[static_cast<std::size_t>(corner_id(view.ids, c))].head<2>());
  return out;
}

/// Zhang (2000), section 3.1, for a known principal point: two equations a view in 1/fx^2 and 1/fy^2 (one
/// unknown for square pixels).
std::optional<Eigen::Vector2d> zhang_focal_px(const std::vector<Eigen::Matrix3d>& centred,
                                              bool square_pixels) {
  Eigen::MatrixXd a(2 * static_cast<Eigen::Index>(centred.size()), 2);
  Eigen::VectorXd b(a.rows());
  for (std::size_t i = 0; i < centred.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(2 * i);
    const Eigen::Vector3d h1 = centred[i].col(0), h2 = centred[i].col(1);
    const double scale = 1.0 / (h1.norm() * h2.norm());
    a.row(row) << h1.x() * h2.x() * scale, h1.y() * h2.y() * scale;
    b[row] = -h1.z() * h2.z() * scale;
    a.row(row + 1) << (h1.x() * h1.x() - h2.x() * h2.x()) * scale,
        (h1.y() * h1.y() - h2.y() * h2.y()) * scale;
    b[row + 1] = -(h1.z() * h1.z() - h2.z() * h2.z()) * scale;
  }
  Eigen::Vector2d inverse_square;
  if (square_pixels) {
    const Eigen::VectorXd both = a.rowwise().sum();
    inverse_square.setConstant(both.dot(b) / both.squaredNorm());
  } else {
    inverse_square = a.colPivHouseholderQr().solve(b);
  }
  if (!(inverse_square.minCoeff() > 0.0) || !inverse_square.allFinite()) return std::nullopt;
  return inverse_square.cwiseSqrt().cwiseInverse();
}

/// Focal lengths worth trying, px.
std::vector<Eigen::Vector2d> focal_candidates(const std::vector<Eigen::Matrix3d>& homographies, int width,
                                              int height) {
  Eigen::Matrix3d to_middle = Eigen::Matrix3d::Identity();
  to_middle(0, 2) = -0.5 * (width - 1);
  to_middle(1, 2) = -0.5 * (height - 1);
  std::vector<Eigen::Matrix3d> centred;
  for (const Eigen::Matrix3d& h : homographies) centred.push_back(to_middle * h);
  std::vector<Eigen::Vector2d> out;
  for (const bool square : {false, true}) {
    if (const auto f = zhang_focal_px(centred, square)) out.push_back(*f);
  }
  // From 100 down to 14 degrees across: drones, action cameras, long lenses. Zhang's form fails on strong
  // distortion and on boards that all face the camera.
  for (const double widths : {0.42, 0.6, 0.85, 1.2, 1.7, 2.4, 4.0})
    out.emplace_back(widths * width, widths * width);
  return out;
}

/// Root mean square distance of the corners from where the start puts them, px; infinite when a pose is
/// impossible. `pose_of(v)` gives the pose of view v, or nothing.
template <class PoseOf>
double start_rms_px(const Camera& camera, const PoseOf& pose_of, const std::vector<SeenCorners>& views,
                    const std::vector<Eigen::Vector3d>& corners, std::vector<Rigid3>& poses) {
  double sum = 0.0;
  std::size_t count = 0;
  poses.clear();
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::optional<Rigid3> pose = pose_of(v);
    if (!pose) return std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < views[v].px.size(); ++c) {
      const auto id = static_cast<std::size_t>(corner_id(views[v].ids, c));
      const auto px = camera::project(camera, *pose * corners[id]);
      if (!px) return std::numeric_limits<double>::infinity();
      sum += (*px - views[v].px[c]).squaredNorm();
      ++count;
    }
    poses.push_back(*pose);
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

std::optional<Rigid3> pose_from_homography(const Camera& camera, const Eigen::Matrix3d& picture_from_board) {
  Eigen::Matrix3d rays = picture_from_board;
  rays.row(0) = (picture_from_board.row(0) - camera.cx * picture_from_board.row(2)) / camera.fx;
  rays.row(1) = (picture_from_board.row(1) - camera.cy * picture_from_board.row(2)) / camera.fy;
  double scale = 2.0 / (rays.col(0).norm() + rays.col(1).norm());
  if (rays(2, 2) < 0.0) scale = -scale;
  rays *= scale;
  Eigen::Matrix3d frame;
  frame << rays.col(0), rays.col(1), rays.col(0).cross(rays.col(1));
  if (!frame.allFinite() || !rays.allFinite()) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(frame, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (!(rotation.determinant() > 0.0)) return std::nullopt;
  return Rigid3{Eigen::Quaterniond(rotation).normalized(), rays.col(2)};
}

namespace {

Camera plain_camera(camera::CameraModel model, int width, int height, const Eigen::Vector2d& focal_px) {
  Camera camera;
  camera.model = model;
  camera.width = width;
  camera.height = height;
  camera.fx = focal_px.x();
  camera.fy = focal_px.y();
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  camera.distortion.assign(static_cast<std::size_t>(camera::distortion_count(model)), 0.0);
  return camera;
}

/// The candidate that reprojects best; `pose_of(camera, v)` as above.
template <class PoseOf>
std::optional<Start> best_start(const std::vector<Camera>& candidates, const PoseOf& pose_of,
                                const std::vector<SeenCorners>& views, const target::BoardSpec& board) {
  const std::vector<Eigen::Vector3d> corners = target::corners_in_board(board);
  Start best;
  double best_rms_px = std::numeric_limits<double>::infinity();
  for (const Camera& camera : candidates) {
    Start start{camera, {}};
    const double rms_px = start_rms_px(
        camera, [&](std::size_t v) { return pose_of(camera, v); }, views, corners, start.cam_from_board);
    if (rms_px < best_rms_px) {
      best_rms_px = rms_px;
      best = std::move(start);
    }
  }
  if (!std::isfinite(best_rms_px)) return std::nullopt;
  return best;
}

}  // namespace

std::optional<Start> find_start(const std::vector<SeenCorners>& views, const target::BoardSpec& board,
                                int width, int height) {
  const std::vector<Eigen::Vector3d> corners = target::corners_in_board(board);
  std::vector<Eigen::Matrix3d> homographies;
  for (const SeenCorners& view : views) {
    const auto h = target::fit_homography(on_board(corners, view), view.px);
    if (!h) return std::nullopt;
    homographies.push_back(*h);
  }
  std::vector<Camera> candidates;
  for (const Eigen::Vector2d& focal : focal_candidates(homographies, width, height))
    candidates.push_back(plain_camera(camera::CameraModel::pinhole, width, height, focal));
  const auto pose = [&](const Camera& camera, std::size_t v) {
    return pose_from_homography(camera, homographies[v]);
  };
  return best_start(candidates, pose, views, board);
}

std::optional<Start> find_wide_start(const std::vector<SeenCorners>& views, const target::BoardSpec& board,
                                     int width, int height, camera::CameraModel model) {
  std::vector<Camera> candidates;
  for (const double fov_deg : {230.0, 200.0, 180.0, 160.0, 140.0, 120.0, 100.0, 80.0, 60.0, 40.0, 20.0}) {
    const double focal_px = width / (fov_deg * std::numbers::pi / 180.0);
    candidates.push_back(plain_camera(model, width, height, {focal_px, focal_px}));
  }
  const auto pose = [&](const Camera& camera, std::size_t v) {
    return pose_from_corners(camera, board, views[v]);
  };
  return best_start(candidates, pose, views, board);
}

}  // namespace furrow::calib
