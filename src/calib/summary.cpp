#include <cmath>
#include <Eigen/Dense>
#include <utility>

#include "calib/round.h"
#include "furrow/base/text.h"

namespace furrow::calib {
namespace {

/// Inverse of the information of the shared parameters, judged after scaling them to unit diagonal; empty
/// when some combination of them is not determined.
Eigen::MatrixXd shared_covariance(const Information& information) {
  const Eigen::VectorXd scale = information.shared.diagonal().cwiseSqrt().cwiseInverse();
  if (!information.usable || !scale.allFinite()) return {};
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information.shared * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  // Below this the weakest combination is rounding noise of the sums.
  constexpr double kSmallestEigenvalue = 1e-13;
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues()[0] > kSmallestEigenvalue)) return {};
  const Eigen::MatrixXd inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                                  eigen.eigenvectors().transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

/// The covariance of (shared, drift) as one of (intrinsics, drift).
Eigen::MatrixXd lens_and_drift_covariance(const SharedModel& model, const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = model.intrinsics_count();
  std::vector<Eigen::Index> from;
  for (Eigen::Index i = 0; i < n; ++i) from.push_back(model.column[static_cast<std::size_t>(i)]);
  for (Eigen::Index i = 0; i < 6; ++i) from.push_back(model.count + i);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n + 6, n + 6);
  for (Eigen::Index i = 0; i < n + 6; ++i) {
    for (Eigen::Index j = 0; j < n + 6; ++j) {
      const Eigen::Index a = from[static_cast<std::size_t>(i)], b = from[static_cast<std::size_t>(j)];
      if (a >= 0 && b >= 0) out(i, j) = covariance(a, b);
    }
  }
  return out;
}

void fill_covariance(const Round& round, const CalibrateOptions& options, Calibration& out) {
  const Information info = information(round.model, round.solved, round.views);
  out.degrees_of_freedom =
      info.residuals - static_cast<int>(round.model.count) - 6 * static_cast<int>(round.views.size());
  out.sigma0_px = out.degrees_of_freedom > 0 ? std::sqrt(info.squared_sum / out.degrees_of_freedom) : kNan;
  const Eigen::MatrixXd shared = shared_covariance(info);
  if (shared.size() == 0 || !std::isfinite(out.sigma0_px)) {
    out.warnings.push_back(
        "the pictures leave some combination of the parameters undetermined: no sigma can be given");
    return;
  }
  const Eigen::MatrixXd full = full_covariance(round.model, out.sigma0_px * out.sigma0_px * shared);
  const Eigen::Index n = round.model.intrinsics_count();
  // Equal both sides of the diagonal to the last bit, so that it reads back the same from rows or columns.
  out.lens_and_board_covariance = 0.5 * (full + full.transpose());
  out.camera.covariance = out.lens_and_board_covariance.topLeftCorner(n, n);
  out.drift_covariance = out.sigma0_px * out.sigma0_px *
                         lens_and_drift_covariance(round.model, drift_covariance(info, round.solved, shared));
  const Eigen::Vector2d warp_m = warp_of(round.model, round.solved.shared);
  if (options.solve_aspect) {
    out.board_aspect = {board_of(round.model, round.solved.shared).aspect, std::sqrt(full(n, n)),
                        out.corners};
  }
  if (options.solve_warp) {
    out.board_warp_x_m = {warp_m.x(), std::sqrt(full(n + 1, n + 1)), out.corners};
    out.board_warp_y_m = {warp_m.y(), std::sqrt(full(n + 2, n + 2)), out.corners};
  }
}

/// What the pictures' own metadata should make a person think of.
void warn_of_turned_pictures(const Job& job, const Round& round, Calibration& out) {
  std::size_t turned = 0;
  std::string first;
  for (const std::size_t i : round.order) {
    if (job.detections[i].exif_orientation == 1) continue;
    if (turned++ == 0) first = job.detections[i].image;
  }
  if (turned == 0) return;
  out.warnings.push_back(std::to_string(turned) + " of " + std::to_string(round.order.size()) +
                         " pictures ask to be turned when shown (EXIF orientation; " + first +
                         "): corners and camera are in the pixels as the sensor read them, so carry this "
                         "camera to pictures that are "
                         "not turned");
}

}  // namespace

void fill_view(const Round& round, std::size_t i, View& view) {
  const Camera camera = camera_of(round.model, round.solved.shared);
  const target::BoardSpec board = board_of(round.model, round.solved.shared);
  const Eigen::Vector2d warp_m = warp_of(round.model, round.solved.shared);
  view.cam_from_board = pose_of(round.solved.poses[i]);
  view.weight = round.views[i].weight;
  view.residual_px.clear();
  double squared = 0.0, distance = 0.0, n = 0.0;
  for (std::size_t c = 0; c < view.observed_px.size(); ++c) {
    const int id = corner_id(view.corner_ids, c), x = id % board.corners_x, y = id / board.corners_x;
    const auto px = camera::project(camera, view.cam_from_board * warped_corner(board, warp_m, x, y));
    const Eigen::Vector2d residual =
        px ? Eigen::Vector2d(view.observed_px[c] - *px) : Eigen::Vector2d::Constant(kNan);
    view.residual_px.push_back(residual);
    if (is_left_out(view, c)) continue;
    squared += residual.squaredNorm();
    distance += residual.norm();
    n += 1.0;
  }
  view.rms_px = std::sqrt(squared / n);
  view.mean_error_px = distance / n;
}

Calibration summarize(const Job& job, const Round& round, std::vector<View> views) {
  Calibration out;
  out.camera = camera_of(round.model, round.solved.shared);
  out.board = board_of(round.model, round.solved.shared);
  out.views = std::move(views);
  out.iterations = round.solved.iterations;
  out.termination = round.solved.termination;
  double squared = 0.0, distance = 0.0;
  for (const std::size_t i : round.order) {
    for (std::size_t c = 0; c < out.views[i].residual_px.size(); ++c) {
      if (is_left_out(out.views[i], c)) {
        ++out.corners_left_out;
        continue;
      }
      squared += out.views[i].residual_px[c].squaredNorm();
      distance += out.views[i].residual_px[c].norm();
      ++out.corners;
    }
  }
  out.rms_px = std::sqrt(squared / out.corners);
  out.mean_error_px = distance / out.corners;
  fill_covariance(round, job.options, out);
  warn_of_turned_pictures(job, round, out);
  out.usable = std::isfinite(out.rms_px) && out.camera.covariance.size() > 0;
  out.camera.provenance = "calibrated from " + std::to_string(round.order.size()) + " views at " +
                          std::to_string(job.width) + "x" + std::to_string(job.height) + ", RMS " +
                          base::format_fixed(out.rms_px, 3) + " px";
  return out;
}

}  // namespace furrow::calib
