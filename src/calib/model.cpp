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
  SharedModel model{camera, board, {}, {}, 0, {}, {}};
  const Eigen::VectorXd lens = camera::intrinsics(camera);
  const auto n = static_cast<std::size_t>(lens.size());
  model.full.resize(lens.size() + kBoardTerms);
  model.full << lens, board.aspect, warp_m;
  model.column.assign(n + kBoardTerms, -1);
  int next = 0;
  if (free.core) {
    model.column[0] = next++;
    model.column[1] = free.square_pixels ? model.column[0] : next++;
    model.column[2] = next++;
    model.column[3] = next++;
  }
  for (std::size_t i = 4; i < std::min(n, 4 + static_cast<std::size_t>(free.distortion)); ++i)
    model.column[i] = next++;
  if (free.aspect) model.column[n] = next++;
  if (free.warp) {
    model.column[n + 1] = next++;
    model.column[n + 2] = next++;
  }
  model.count = next;
  return model;
}

Eigen::VectorXd shared_of(const SharedModel& model) {
  Eigen::VectorXd shared = Eigen::VectorXd::Zero(model.count), entries = shared;
  for (std::size_t i = 0; i < model.column.size(); ++i) {
    if (model.column[i] < 0) continue;
    shared[model.column[i]] += model.full[static_cast<Eigen::Index>(i)];
    entries[model.column[i]] += 1.0;
  }
  return shared.cwiseQuotient(entries);
}

Eigen::VectorXd full_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  Eigen::VectorXd full = model.full;
  for (std::size_t i = 0; i < model.column.size(); ++i) {
    if (model.column[i] >= 0) full[static_cast<Eigen::Index>(i)] = shared[model.column[i]];
  }
  return full;
}

Eigen::MatrixXd full_covariance(const SharedModel& model, const Eigen::MatrixXd& shared) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(model.full.size(), model.full.size());
  for (std::size_t i = 0; i < model.column.size(); ++i) {
    for (std::size_t j = 0; j < model.column.size(); ++j) {
      if (model.column[i] < 0 || model.column[j] < 0) continue;
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          shared(model.column[i], model.column[j]);
    }
  }
  return out;
}

Camera camera_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  return camera::with_intrinsics(model.camera, full_of(model, shared).head(model.intrinsics_count()));
}

target::BoardSpec board_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  target::BoardSpec board = model.board;
  board.aspect = full_of(model, shared)[model.intrinsics_count()];
  return board;
}

Eigen::Vector2d warp_of(const SharedModel& model, const Eigen::VectorXd& shared) {
  return full_of(model, shared).tail<2>();
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

namespace {

/// Adds columns of derivatives by entries of full to those by `shared`.
void add_by_full(const SharedModel& model, Eigen::Index entry, const Eigen::Vector2d& by,
                 Eigen::Ref<RowMajor> d_shared) {
  const int column = model.column[static_cast<std::size_t>(entry)];
  if (column >= 0) d_shared.col(column) += by;
}

}  // namespace

bool evaluate_view(const SharedModel& model, const Eigen::VectorXd& shared, const PoseVector& pose,
                   const SeenCorners& seen, const std::vector<double>& weight, double* residual,
                   double* d_shared, double* d_pose) {
  const Eigen::VectorXd full = full_of(model, shared);
  const Eigen::Index n = model.intrinsics_count();
  const Camera camera = camera::with_intrinsics(model.camera, full.head(n));
  target::BoardSpec board = model.board;
  board.aspect = full[n];
  const Eigen::Vector2d warp_m = full.tail<2>();
  const Eigen::Matrix3d rotation = geom::rotation_from_vector(pose.head<3>()).toRotationMatrix();
  const Eigen::Matrix3d jacobian = right_jacobian(pose.head<3>());
  const auto rows = static_cast<Eigen::Index>(2 * seen.px.size());
  for (std::size_t c = 0; c < seen.px.size(); ++c) {
    const int id = corner_id(seen.ids, c), i = id % board.corners_x, j = id / board.corners_x;
    const auto row = static_cast<Eigen::Index>(2 * c);
    const Eigen::Vector3d x_in_board = warped_corner(board, warp_m, i, j);
    const auto at = camera::project_with_jacobians(camera, rotation * x_in_board + pose.tail<3>());
    if (!at) return false;
    const double w = weight.empty() ? 1.0 : weight[c];
    Eigen::Map<Eigen::Vector2d>(residual + row) = w * (at->px - seen.px[c]);
    if (d_shared == nullptr && d_pose == nullptr) continue;
    const Eigen::Matrix<double, 2, 3> d_board = w * at->d_point * rotation;
    if (d_shared != nullptr) {
      auto block = Eigen::Map<RowMajor>(d_shared, rows, model.count).middleRows<2>(row);
      block.setZero();
      for (Eigen::Index k = 0; k < at->d_intrinsics.cols(); ++k)
        add_by_full(model, at->place[static_cast<std::size_t>(k)], w * at->d_intrinsics.col(k), block);
      add_by_full(model, n, d_board.col(1) * (x_in_board.y() / board.aspect), block);
      const Eigen::Vector2d bend = bends(board, i, j);
      add_by_full(model, n + 1, d_board.col(2) * bend.x(), block);
      add_by_full(model, n + 2, d_board.col(2) * bend.y(), block);
    }
    if (d_pose != nullptr) {
      auto block = Eigen::Map<RowMajor>(d_pose, rows, 6).middleRows<2>(row);
      block.leftCols<3>() = -d_board * (cross_matrix(x_in_board) * jacobian);
      block.rightCols<3>() = w * at->d_point;
    }
  }
  return true;
}

PatchCorner evaluate_patch_corner(const SharedModel& model, const Camera& camera, const PoseVector& pose,
                                  const Eigen::Vector2d& warp_m, int corner,
                                  const camera::SplinePatch& patch) {
  const int i = corner % model.board.corners_x, j = corner / model.board.corners_x;
  const Eigen::Matrix3d rotation = geom::rotation_from_vector(pose.head<3>()).toRotationMatrix();
  const Eigen::Vector3d x_in_board = warped_corner(model.board, warp_m, i, j);
  PatchCorner out;
  out.seen = camera::project_by_patch(camera, rotation * x_in_board + pose.tail<3>(), patch);
  if (!out.seen) return out;
  const Eigen::Matrix<double, 2, 3> d_board = out.seen->d_point * rotation;
  out.d_pose.leftCols<3>() = -d_board * (cross_matrix(x_in_board) * right_jacobian(pose.head<3>()));
  out.d_pose.rightCols<3>() = out.seen->d_point;
  out.d_warp = d_board.col(2) * bends(model.board, i, j).transpose();
  return out;
}

}  // namespace furrow::calib
