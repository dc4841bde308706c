#include "calib/model.h"

#include <cmath>

namespace furrow::calib {
namespace {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d out;
  out << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return out;
}

/// Right Jacobian of the rotation vector: R(v + d) = R(v) R(J d) to first order (Sola 2017, eq. 143).
Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  const Eigen::Matrix3d x = cross_matrix(v);
  // Below this angle the series' next term is under the rounding of the first.
  constexpr double kSmallAngle = 1e-5;
  if (angle < kSmallAngle) return Eigen::Matrix3d::Identity() - 0.5 * x + x * x / 6.0;
  const double a2 = angle * angle;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / a2 * x +
         (angle - std::sin(angle)) / (a2 * angle) * x * x;
}

/// 1 - x^2 and 1 - y^2 with x, y from -1 to 1 across the corners: the parabolas' heights over their chords.
Eigen::Vector2d bends(const target::BoardSpec& board, int i, int j) {
  const Eigen::Vector2d own = target::corner_in_board(board, i, j).head<2>(),
                        last = target::corner_in_board(board, board.corners_x - 1, board.corners_y - 1)
                                   .head<2>();
  return 1.0 - (2.0 * own.array() / last.array() - 1.0).square();
}

}  // namespace

SharedModel make_shared_model(const Camera& camera, const target::BoardSpec& board,
                              const Eigen::Vector2d& warp_m, const FreeTerms& free) {
  SharedModel model{camera, board, {}, {}};
  const Eigen::VectorXd lens = camera::intrinsics(camera);
  const Eigen::Index n = lens.size();
  model.origin.resize(n + kBoardTerms);
  model.origin << lens, board.aspect, warp_m;
  std::vector<std::vector<Eigen::Index>> columns;
  if (free.square_pixels) {
    columns.push_back({0, 1});
  } else {
    columns.push_back({0});
    columns.push_back({1});
  }
  columns.push_back({2});
  columns.push_back({3});
  for (Eigen::Index i = 0; i < std::min<Eigen::Index>(free.distortion, n - 4); ++i)
    columns.push_back({4 + i});
  if (free.aspect) columns.push_back({n});
  if (free.warp) {
    columns.push_back({n + 1});
    columns.push_back({n + 2});
  }
  model.basis.setZero(n + kBoardTerms, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) {
    for (const Eigen::Index row : columns[c]) model.basis(row, static_cast<Eigen::Index>(c)) = 1.0;
  }
  // What is free starts from `shared` alone.
  for (const auto& rows : columns) {
    for (const Eigen::Index row : rows) model.origin[row] = 0.0;
  }
  return model;
}

Eigen::VectorXd shared_of(const SharedModel& model) {
  Eigen::VectorXd full(model.origin.size());
  full << camera::intrinsics(model.camera), model.board.aspect, 0.0, 0.0;
  Eigen::VectorXd shared(model.basis.cols());
  for (Eigen::Index c = 0; c < model.basis.cols(); ++c)
    shared[c] = model.basis.col(c).dot(full) / model.basis.col(c).sum();
  return shared;
}

Camera camera_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  const Eigen::VectorXd full = model.origin + model.basis * shared;
  return camera::with_intrinsics(model.camera, full.head(model.intrinsics_count()));
}

target::BoardSpec board_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  target::BoardSpec board = model.board;
  const Eigen::Index at = model.intrinsics_count();
  board.aspect = model.origin[at] + model.basis.row(at).dot(shared);
  return board;
}

Eigen::Vector2d warp_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  return model.origin.tail<2>() + model.basis.bottomRows<2>() * shared;
}

PoseVector pose_vector(const Rigid3& cam_from_board) {
  PoseVector out;
  out << geom::rotation_vector(cam_from_board.rotation), cam_from_board.translation;
  return out;
}

Rigid3 pose_of(const PoseVector& pose) {
  return {geom::rotation_from_vector(pose.head<3>()), pose.tail<3>()};
}

Eigen::Vector3d warped_corner(const target::BoardSpec& board, const Eigen::Vector2d& warp_m, int i, int j) {
  Eigen::Vector3d out = target::corner_in_board(board, i, j);
  out.z() = warp_m.dot(bends(board, i, j));
  return out;
}

Eigen::Matrix<double, 6, 6> drift_of_pose(const PoseVector& pose) {
  // R(v + d) = R exp(J d) = exp(R J d) R; and a turn about the camera moves the board's origin, which the
  // shift takes back.
  const Eigen::Matrix3d turn =
      geom::rotation_from_vector(pose.head<3>()).toRotationMatrix() * right_jacobian(pose.head<3>());
  Eigen::Matrix<double, 6, 6> out = Eigen::Matrix<double, 6, 6>::Zero();
  out.topLeftCorner<3, 3>() = turn;
  out.bottomLeftCorner<3, 3>() = cross_matrix(pose.tail<3>()) * turn;
  out.bottomRightCorner<3, 3>().setIdentity();
  return out;
}

bool evaluate_view(const SharedModel& model, const Eigen::VectorXd& shared, const PoseVector& pose,
                   const SeenCorners& seen, const std::vector<double>& weight, double* residual,
                   double* d_shared, double* d_pose) {
  const Camera camera = camera_of(model, shared);
  const target::BoardSpec board = board_of(model, shared);
  const Eigen::Vector2d warp_m = warp_of(model, shared);
  const Eigen::Matrix3d rotation = geom::rotation_from_vector(pose.head<3>()).toRotationMatrix();
  const Eigen::Matrix3d turn = -rotation, jacobian = right_jacobian(pose.head<3>());
  const auto rows = static_cast<Eigen::Index>(2 * seen.px.size());
  const Eigen::Index n = model.intrinsics_count();
  Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, camera::kMaxIntrinsics + kBoardTerms> d_full(
      2, n + kBoardTerms);
  for (std::size_t c = 0; c < seen.px.size(); ++c) {
    const int id = corner_id(seen.ids, c), i = id % board.corners_x, j = id / board.corners_x;
    const auto row = static_cast<Eigen::Index>(2 * c);
    const Eigen::Vector3d x_in_board = warped_corner(board, warp_m, i, j);
    const auto projected = camera::project_with_jacobians(camera, rotation * x_in_board + pose.tail<3>());
    if (!projected) return false;
    const double w = weight.empty() ? 1.0 : weight[c];
    Eigen::Map<Eigen::Vector2d>(residual + row) = w * (projected->px - seen.px[c]);
    if (d_shared != nullptr) {
      const Eigen::Matrix<double, 2, 3> d_board = projected->d_point * rotation;
      d_full.leftCols(n) = projected->d_intrinsics;
      d_full.col(n) = d_board.col(1) * (x_in_board.y() / board.aspect);
      d_full.rightCols<2>() = d_board.col(2) * bends(board, i, j).transpose();
      Eigen::Map<RowMajor>(d_shared, rows, model.basis.cols()).middleRows<2>(row) = w * d_full * model.basis;
    }
    if (d_pose != nullptr) {
      auto block = Eigen::Map<RowMajor>(d_pose, rows, 6).middleRows<2>(row);
      block.leftCols<3>() = w * projected->d_point * turn * cross_matrix(x_in_board) * jacobian;
      block.rightCols<3>() = w * projected->d_point;
    }
  }
  return true;
}

}  // namespace furrow::calib
