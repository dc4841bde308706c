#include "calib/round.h"

#include <algorithm>
#include <cmath>

#include "furrow/stats/robust.h"

namespace furrow::calib {
namespace {

/// 1 / sigma relative to the mean, so that the weighted residuals stay near pixels.
std::vector<double> weights(const target::BoardDetection& detection, double typical_sigma_px) {
  std::vector<double> out;
  for (const double sigma : detection.sigma_px) out.push_back(sigma > 0.0 ? typical_sigma_px / sigma : 1.0);
  return out;
}

double typical_sigma(const std::vector<target::BoardDetection>& detections) {
  std::vector<double> all;
  for (const auto& one : detections) all.insert(all.end(), one.sigma_px.begin(), one.sigma_px.end());
  const double middle = stats::median(all);
  return middle > 0.0 ? middle : 1.0;
}

std::vector<SolveView> solve_views(const Job& job, const std::vector<std::size_t>& order,
                                   const std::vector<View>& views, const Start& start) {
  const double sigma_px = typical_sigma(job.detections);
  std::vector<SolveView> out;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const target::BoardDetection& detection = job.detections[order[i]];
    SolveView view{{detection.corner_ids, detection.corners_px}, {}, pose_vector(start.cam_from_board[i])};
    if (job.options.use_corner_sigma && detection.sigma_px.size() == detection.corners_px.size()) {
      view.weight = weights(detection, sigma_px);
    }
    const std::vector<bool>& left_out = views[order[i]].left_out;
    if (!left_out.empty() && view.weight.empty()) view.weight.assign(left_out.size(), 1.0);
    for (std::size_t c = 0; c < left_out.size(); ++c) {
      if (left_out[c]) view.weight[c] = 0.0;
    }
    out.push_back(std::move(view));
  }
  return out;
}

}  // namespace

Error solve_failed(const std::string& why) {
  return {"solve_failed", "calibration", why, "a solution",
          "take pictures with the board tilted different ways, near and far, in all parts of the picture"};
}

void take_over(Round& round, const Solved& solved, Camera& camera) {
  if (!solved.shared.allFinite()) return;
  camera = camera_of(round.model, solved.shared);
  for (std::size_t i = 0; i < round.views.size(); ++i) round.views[i].pose = solved.poses[i];
}

double residual_px(const Round& round) {
  double squared = 0.0;
  Eigen::Index count = 0;
  const Eigen::VectorXd shared = shared_of(round.model);
  for (const SolveView& view : round.views) {
    Eigen::VectorXd residual(static_cast<Eigen::Index>(2 * view.seen.px.size()));
    if (!evaluate_view(round.model, shared, view.pose, view.seen, view.weight, residual.data(), nullptr,
                       nullptr))
      return 0.0;
    squared += residual.squaredNorm();
    count += residual.size();
  }
  return std::sqrt(squared / static_cast<double>(std::max<Eigen::Index>(1, count)));
}

Result<Round> solve_round(const Job& job, const std::vector<std::size_t>& order,
                          const std::vector<View>& views) {
  using camera::CameraModel;
  std::vector<SeenCorners> corners;
  for (const std::size_t i : order)
    corners.push_back({job.detections[i].corner_ids, job.detections[i].corners_px});
  const CameraModel model = job.options.model;
  const bool splined = model == CameraModel::splined_stereographic;
  const bool wide = splined || model == CameraModel::fisheye || model == CameraModel::stereographic ||
                    model == CameraModel::latlon;
  const std::optional<Start> start = wide ? find_wide_start(corners, job.board, job.width, job.height,
                                                            splined ? CameraModel::fisheye : model)
                                          : find_start(corners, job.board, job.width, job.height);
  if (!start) return solve_failed("a board whose corners allow no pose (all in a line, or in one point)");
  Round round;
  round.order = order;
  round.views = solve_views(job, order, views, *start);
  round.model.board = job.board;
  if (splined) {
    FURROW_DO(solve_splined_lens(job, *start, round));
  } else {
    FURROW_DO(solve_formula(job, *start, round));
  }
  if (!round.solved.converged)
    return solve_failed("the solver stopped without an answer: " + round.solved.termination);
  if (!camera::validate(camera_of(round.model, round.solved.shared)).ok()) {
    return solve_failed("an impossible camera (a focal length below 0)");
  }
  return round;
}

}  // namespace furrow::calib
