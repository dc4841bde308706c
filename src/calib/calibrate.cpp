#include "furrow/calib/calibrate.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "calib/solve.h"
#include "calib/start.h"
#include "furrow/base/text.h"
#include "furrow/stats/robust.h"

namespace furrow::calib {
namespace {

/// Fewer views than these leave the focal length and the principal point to chance.
constexpr std::size_t kFewestViews = 3;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool all_finite(const std::vector<Eigen::Vector2d>& points) {
  return std::all_of(points.begin(), points.end(), [](const Eigen::Vector2d& p) { return p.allFinite(); });
}

/// Rising, and each one of the board's corners.
bool are_ids(const std::vector<int>& ids, std::size_t corners) {
  return ids.empty() || (ids.front() >= 0 && static_cast<std::size_t>(ids.back()) < corners &&
                         std::adjacent_find(ids.begin(), ids.end(), std::greater_equal<>()) == ids.end());
}

View start_view(const target::BoardDetection& detection, const target::BoardSpec& board) {
  View view;
  view.image = detection.image;
  view.rms_px = view.mean_error_px = kNan;
  const auto all = static_cast<std::size_t>(board.corners_x) * static_cast<std::size_t>(board.corners_y);
  const auto wanted = detection.corner_ids.empty() ? all : detection.corner_ids.size();
  if (!detection.found) {
    view.reason = detection.reason.empty() ? "no board found" : detection.reason;
  } else if (detection.corners_px.size() != wanted) {
    view.reason = std::to_string(detection.corners_px.size()) + " corners, not " + std::to_string(wanted);
  } else if (!all_finite(detection.corners_px)) {
    view.reason = "corners that are not finite";
  } else if (!are_ids(detection.corner_ids, all)) {
    view.reason = "corners that are not the board's";
  } else {
    view.used = true;
    view.observed_px = detection.corners_px;
    view.corner_ids = detection.corner_ids;
  }
  return view;
}

Error too_few(const std::vector<View>& views, std::size_t usable) {
  std::string reasons;
  constexpr std::size_t kShown = 3;
  std::size_t shown = 0;
  for (const View& view : views) {
    if (view.used || shown == kShown) continue;
    reasons += (shown++ == 0 ? ": " : "; ") + view.image + ": " + view.reason;
  }
  return {
      "too_few_boards", "calibration",
      std::to_string(usable) + " usable boards in " + std::to_string(views.size()) + " pictures" + reasons,
      "at least " + std::to_string(kFewestViews),
      "check the board's corner counts (inner corners, not squares), and take pictures in which the whole "
      "board shows"};
}

/// Places of the used views in an order that does not depend on the order of the files.
std::vector<std::size_t> in_name_order(const std::vector<View>& views) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].used) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].image < views[b].image; });
  return order;
}

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

/// Everything the rounds of one calibration share.
struct Job {
  const std::vector<target::BoardDetection>& detections;
  target::BoardSpec board;
  CalibrateOptions options;
  int width = 0, height = 0;
};

/// A solution of the views in `order`.
struct Round {
  std::vector<std::size_t> order;
  SharedModel model;
  std::vector<SolveView> views;
  Solved solved;
};

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

Error solve_failed(const std::string& why) {
  return {"solve_failed", "calibration", why, "a solution",
          "take pictures with the board tilted different ways, near and far, in all parts of the picture"};
}

/// First the focal length with two radial coefficients, then everything: a rational lens started from nothing
/// finds false minima.
Result<Round> solve_round(const Job& job, const std::vector<std::size_t>& order,
                          const std::vector<View>& views) {
  std::vector<SeenCorners> corners;
  for (const std::size_t i : order)
    corners.push_back({job.detections[i].corner_ids, job.detections[i].corners_px});
  const std::optional<Start> start = find_start(corners, job.board, job.width, job.height);
  if (!start) return solve_failed("a board whose corners allow no pose (all in a line, or in one point)");
  Round round;
  round.order = order;
  round.views = solve_views(job, order, views, *start);
  Camera camera = start->camera;
  camera.model = job.options.model;
  camera.distortion.assign(static_cast<std::size_t>(camera::distortion_count(job.options.model)), 0.0);
  FreeTerms free;
  free.square_pixels = job.options.square_pixels || job.options.solve_aspect;
  const SolveOptions settings{job.options.max_iterations};
  constexpr int kFirstCoefficients = 2;
  free.distortion = kFirstCoefficients;
  round.model = make_shared_model(camera, job.board, Eigen::Vector2d::Zero(), free);
  const Solved first = solve(round.model, shared_of(round.model), round.views, settings);
  if (first.shared.allFinite()) {
    camera = camera_of(round.model, first.shared);
    for (std::size_t i = 0; i < round.views.size(); ++i) round.views[i].pose = first.poses[i];
  }
  free.distortion = camera::distortion_count(job.options.model);
  free.aspect = job.options.solve_aspect;
  free.warp = job.options.solve_warp;
  round.model = make_shared_model(camera, job.board, Eigen::Vector2d::Zero(), free);
  round.solved = solve(round.model, shared_of(round.model), round.views, settings);
  if (!round.solved.converged)
    return solve_failed("the solver stopped without an answer: " + round.solved.termination);
  if (!camera::validate(camera_of(round.model, round.solved.shared)).ok()) {
    return solve_failed("an impossible camera (a focal length below 0)");
  }
  return round;
}

bool is_left_out(const View& view, std::size_t corner) {
  return !view.left_out.empty() && view.left_out[corner];
}

/// Writes a solved view's pose and residuals.
void fill_view(const Round& round, std::size_t i, View& view) {
  const Camera camera = camera_of(round.model, round.solved.shared);
  const target::BoardSpec board = board_of(round.model, round.solved.shared);
  const Eigen::Vector2d warp_m = warp_of(round.model, round.solved.shared);
  view.cam_from_board = pose_of(round.solved.poses[i]);
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

/// Unuses the views whose RMS stands out; whether any did.
bool drop_outlying_views(const Round& round, double ratio, std::vector<View>& views) {
  if (!(ratio > 0.0) || round.order.size() <= kFewestViews) return false;
  std::vector<double> rms_px;
  for (const std::size_t i : round.order) rms_px.push_back(views[i].rms_px);
  const double limit_px = ratio * stats::median(rms_px);
  std::vector<std::size_t> worst_first = round.order;
  std::stable_sort(worst_first.begin(), worst_first.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].rms_px > views[b].rms_px; });
  std::size_t left = round.order.size();
  bool any = false;
  for (const std::size_t i : worst_first) {
    if (!(views[i].rms_px > limit_px) || left == kFewestViews) break;
    views[i].used = false;
    views[i].reason = "RMS " + base::format_fixed(views[i].rms_px, 2) + " px is over " +
                      base::format_fixed(ratio, 1) + " times the median view's (" +
                      base::format_fixed(limit_px / ratio, 2) + " px)";
    --left;
    any = true;
  }
  return any;
}

/// Leaves out the corners that lie too far from their projections; whether there were new ones. A view keeps
/// at least half of its corners: one that would lose more is bad as a whole, and its corners say nothing
/// about single ones.
bool leave_out_corners(const Round& round, double sigmas, std::vector<View>& views) {
  if (!(sigmas > 0.0)) return false;
  std::vector<double> distances_px;
  for (const std::size_t i : round.order) {
    for (std::size_t c = 0; c < views[i].residual_px.size(); ++c) {
      if (!is_left_out(views[i], c)) distances_px.push_back(views[i].residual_px[c].norm());
    }
  }
  constexpr double kRayleighMedian = 1.1774;
  const double limit_px = sigmas * stats::median(distances_px) / kRayleighMedian;
  bool any = false;
  for (const std::size_t i : round.order) {
    View& view = views[i];
    std::vector<bool> far(view.residual_px.size());
    for (std::size_t c = 0; c < far.size(); ++c)
      far[c] = is_left_out(view, c) || !(view.residual_px[c].norm() <= limit_px);
    if (2 * std::count(far.begin(), far.end(), true) > static_cast<std::ptrdiff_t>(far.size())) continue;
    any = any || std::count(far.begin(), far.end(), true) >
                     std::count(view.left_out.begin(), view.left_out.end(), true);
    view.left_out = far;
  }
  return any;
}

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

void fill_covariance(const Round& round, const CalibrateOptions& options, Calibration& out) {
  const Information info = information(round.model, round.solved, round.views);
  out.degrees_of_freedom =
      info.residuals - static_cast<int>(round.model.basis.cols()) - 6 * static_cast<int>(round.views.size());
  out.sigma0_px = out.degrees_of_freedom > 0 ? std::sqrt(info.squared_sum / out.degrees_of_freedom) : kNan;
  const Eigen::MatrixXd shared = shared_covariance(info);
  if (shared.size() == 0 || !std::isfinite(out.sigma0_px)) {
    out.warnings.push_back(
        "the pictures leave some combination of the parameters undetermined: no sigma can be given");
    return;
  }
  for (std::size_t i = 0; i < round.order.size(); ++i) {
    out.views[round.order[i]].information = info.view_gain[i] / (out.sigma0_px * out.sigma0_px);
  }
  const Eigen::MatrixXd full =
      out.sigma0_px * out.sigma0_px * round.model.basis * shared * round.model.basis.transpose();
  const Eigen::Index n = round.model.intrinsics_count();
  // Equal both sides of the diagonal to the last bit, so that it reads back the same from rows or columns.
  out.camera.covariance = 0.5 * (full.topLeftCorner(n, n) + full.topLeftCorner(n, n).transpose());
  Eigen::MatrixXd lens_and_drift = Eigen::MatrixXd::Zero(n + 6, shared.rows() + 6);
  lens_and_drift.topLeftCorner(n, shared.rows()) = round.model.basis.topRows(n);
  lens_and_drift.bottomRightCorner<6, 6>().setIdentity();
  out.drift_covariance = out.sigma0_px * out.sigma0_px * lens_and_drift *
                         drift_covariance(info, round.solved, shared) * lens_and_drift.transpose();
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

Status check_sizes(const std::vector<target::BoardDetection>& detections, const std::vector<View>& views,
                   Job& job) {
  const target::BoardDetection* first = nullptr;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (!views[i].used) continue;
    const target::BoardDetection& one = detections[i];
    if (first == nullptr) first = &one;
    if (one.width != first->width || one.height != first->height) {
      return Error{"picture_sizes_differ", one.image,
                   std::to_string(one.width) + "x" + std::to_string(one.height) + ", while " + first->image +
                       " has " + std::to_string(first->width) + "x" + std::to_string(first->height),
                   "pictures of one size", "calibrate each size by itself"};
    }
  }
  if (first == nullptr) return Done{};
  job.width = first->width;
  job.height = first->height;
  return Done{};
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
  out.usable = std::isfinite(out.rms_px) && out.camera.covariance.size() > 0;
  out.camera.provenance = "calibrated from " + std::to_string(round.order.size()) + " views at " +
                          std::to_string(job.width) + "x" + std::to_string(job.height) + ", RMS " +
                          base::format_fixed(out.rms_px, 3) + " px";
  return out;
}

}  // namespace

Result<Calibration> calibrate(const std::vector<target::BoardDetection>& detections,
                              const target::BoardSpec& board, const CalibrateOptions& options) {
  FURROW_DO(target::validate(board));
  std::vector<View> views;
  for (const target::BoardDetection& detection : detections) views.push_back(start_view(detection, board));
  Job job{detections, board, options};
  FURROW_DO(check_sizes(detections, views, job));
  int rounds = 0;
  while (true) {
    const std::vector<std::size_t> order = in_name_order(views);
    if (order.size() < kFewestViews) return too_few(views, order.size());
    FURROW_TRY(const Round round, solve_round(job, order, views));
    for (std::size_t i = 0; i < order.size(); ++i) fill_view(round, i, views[order[i]]);
    // Corners only ever leave, so this ends; a few rounds find all that a better fit uncovers.
    constexpr int kMostRounds = 10;
    const bool again =
        rounds++ < kMostRounds && leave_out_corners(round, options.corner_outlier_sigmas, views);
    if (!again && !drop_outlying_views(round, options.view_outlier_ratio, views))
      return summarize(job, round, std::move(views));
  }
}

}  // namespace furrow::calib
