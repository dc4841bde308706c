#include "furrow/calib/calibrate.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <functional>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "calib/pose.h"
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

/// Sets the solved camera and poses as the start of what follows.
void take_over(Round& round, const Solved& solved, Camera& camera) {
  if (!solved.shared.allFinite()) return;
  camera = camera_of(round.model, solved.shared);
  for (std::size_t i = 0; i < round.views.size(); ++i) round.views[i].pose = solved.poses[i];
}

/// The start of one stage only has to be near: the last stage goes to the end.
constexpr double kStageTolerance = 1e-5;

/// One stage of a lens with a formula: the first `coefficients` of it are solved.
void solve_stage(const Job& job, int coefficients, Round& round, Camera& camera) {
  FreeTerms free;
  free.square_pixels = job.options.square_pixels || job.options.solve_aspect;
  free.distortion = coefficients;
  round.model = make_shared_model(camera, round.model.board, Eigen::Vector2d::Zero(), free);
  take_over(
      round,
      solve(round.model, shared_of(round.model), round.views, {job.options.max_iterations, kStageTolerance}),
      camera);
}

/// Root mean square residual of the views per coordinate, px.
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

/// Weak knowledge of the coefficients beyond Brown-Conrady's: 0 with this sigma, in units of the noise. Where
/// numerator and denominator of a rational lens cancel, nothing else holds them; a value of 1 costs a ninth
/// of one residual.
void add_coefficient_prior(Round& round) {
  constexpr double kCoefficientSigma = 3.0;
  constexpr std::size_t kBrown = 4 + 5;
  if (round.model.camera.model == camera::CameraModel::fisheye ||
      round.model.camera.distortion.size() + 4 <= kBrown)
    return;
  const double weight = residual_px(round) / kCoefficientSigma;
  round.model.prior_weight = round.model.prior_mean = Eigen::VectorXd::Zero(round.model.count);
  for (std::size_t i = kBrown; i < round.model.column.size() - kBoardTerms; ++i) {
    if (round.model.column[i] >= 0) round.model.prior_weight[round.model.column[i]] = weight;
  }
}

/// Squared residuals of a view in a pose, px^2; infinity where a corner has no pixel.
double squared_of(const SharedModel& model, const Eigen::VectorXd& shared, const PoseVector& pose,
                  const SolveView& view) {
  Eigen::VectorXd residual(static_cast<Eigen::Index>(2 * view.seen.px.size()));
  const bool seen =
      evaluate_view(model, shared, pose, view.seen, view.weight, residual.data(), nullptr, nullptr);
  return seen ? residual.squaredNorm() : std::numeric_limits<double>::infinity();
}

/// A small board that is hardly tilted looks nearly the same tilted the other way, and no solve crosses from
/// one to the other: takes whichever of the two fits a view better with lens and board as they are. Whether
/// any view changed.
bool mirror_worse_poses(Round& round, const Eigen::VectorXd& full) {
  SharedModel held = round.model;
  held.full = full;
  held.column.assign(held.column.size(), -1);
  held.count = 0;
  const Eigen::VectorXd nothing;
  bool any = false;
  for (SolveView& view : round.views) {
    const PoseVector other = pose_vector(mirrored_pose(board_of(held, nothing), pose_of(view.pose)));
    const double squared = squared_of(held, nothing, view.pose, view);
    // Of a board that is seen well, the other way fits worse by far, and no refinement mends that.
    constexpr double kHopeless = 100.0;
    if (squared_of(held, nothing, other, view) > kHopeless * squared) continue;
    const auto refined = refine_pose(held, other, view.seen);
    // Where the pose comes back to where it was, rounding must not count as better.
    constexpr double kBetter = 0.999;
    if (!refined || !(squared_of(held, nothing, *refined, view) < kBetter * squared)) continue;
    view.pose = *refined;
    any = true;
  }
  return any;
}

/// Solves on as long as a view fits better tilted the other way.
void solve_from_better_poses(const Job& job, Round& round) {
  constexpr int kMostRounds = 5;
  for (int again = 0; again < kMostRounds && round.solved.shared.allFinite(); ++again) {
    for (std::size_t i = 0; i < round.views.size(); ++i) round.views[i].pose = round.solved.poses[i];
    if (!mirror_worse_poses(round, full_of(round.model, round.solved.shared))) return;
    round.solved = solve(round.model, round.solved.shared, round.views, {job.options.max_iterations});
  }
}

/// A lens with a formula. First the focal length with two radial coefficients, then Brown-Conrady's, then
/// everything: a rational lens started from nothing finds false minima.
Status solve_formula(const Job& job, const Start& start, Round& round) {
  Camera camera = start.camera;
  camera.model = job.options.model;
  const int count = camera::distortion_count(job.options.model);
  camera.distortion.assign(static_cast<std::size_t>(count), 0.0);
  constexpr int kFirstCoefficients = 2, kBrownCoefficients = 5;
  solve_stage(job, std::min(count, kFirstCoefficients), round, camera);
  if (count > kBrownCoefficients) solve_stage(job, kBrownCoefficients, round, camera);
  FreeTerms free;
  free.square_pixels = job.options.square_pixels || job.options.solve_aspect;
  free.distortion = count;
  free.aspect = job.options.solve_aspect;
  free.warp = job.options.solve_warp;
  round.model = make_shared_model(camera, round.model.board, Eigen::Vector2d::Zero(), free);
  add_coefficient_prior(round);
  round.solved = solve(round.model, shared_of(round.model), round.views, {job.options.max_iterations});
  solve_from_better_poses(job, round);
  return Done{};
}

/// Largest |x| and |y| on the stereographic plane that the picture reaches; pixels without a ray, as in the
/// dark corners of a circular picture, are left out.
Eigen::Vector2d stereographic_reach(const Camera& camera) {
  Eigen::Vector2d reach = Eigen::Vector2d::Zero();
  // Nearer to straight behind than this (155 degrees off) the plane has no end.
  constexpr double kFarthestZ = -0.9;
  constexpr int kPlaces = 32;
  for (int j = 0; j <= kPlaces; ++j) {
    for (int i = 0; i <= kPlaces; ++i) {
      const auto ray = camera::unproject_ray(
          camera, {(camera.width - 1.0) * i / kPlaces, (camera.height - 1.0) * j / kPlaces});
      if (ray && ray->z() > kFarthestZ)
        reach = reach.cwiseMax((ray->head<2>() * 2.0 / (1.0 + ray->z())).cwiseAbs());
    }
  }
  return reach;
}

/// A grid of square meshes over all that the picture sees, with about nine corners to a knot.
camera::SplineGrid grid_for(const Camera& seen, std::size_t corners) {
  const Eigen::Vector2d reach = stereographic_reach(seen).cwiseMax(1e-3);
  constexpr double kCornersPerKnot = 9.0, kFewest = 8.0, kMost = 16.0, kMargin = 1.05;
  camera::SplineGrid grid;
  const double fov_rad = 4.0 * std::atan(0.5 * kMargin * reach.x());
  grid.fov_x_deg = std::clamp(static_cast<int>(std::ceil(fov_rad * 180.0 / std::numbers::pi)), 10, 340);
  const double ratio = reach.y() / reach.x();
  grid.columns = static_cast<int>(std::clamp(
      std::round(std::sqrt(static_cast<double>(corners) / (kCornersPerKnot * ratio))), kFewest, kMost));
  const double mesh = 4.0 * std::tan(grid.fov_x_deg * std::numbers::pi / 720.0) / (grid.columns - 3.0);
  grid.rows = std::max(4, static_cast<int>(std::ceil(2.0 * kMargin * reach.y() / mesh)) + 3);
  return grid;
}

/// The splined camera whose surface is that of `seen`: least squares over the stereographic plane, a linear
/// problem, a touch of ridge for the knots beyond.
Camera splined_like(const Camera& seen, const camera::SplineGrid& grid) {
  Camera out = seen;
  out.model = camera::CameraModel::splined_stereographic;
  out.spline = grid;
  out.distortion.assign(static_cast<std::size_t>(camera::distortion_count(out.model, grid)), 0.0);
  out.covariance.resize(0, 0);
  const Eigen::Index knots = grid.columns * grid.rows;
  Eigen::MatrixXd normal = 1e-6 * Eigen::MatrixXd::Identity(knots, knots);
  Eigen::MatrixX2d right = Eigen::MatrixX2d::Zero(knots, 2);
  const double reach = 2.0 * std::tan(grid.fov_x_deg * std::numbers::pi / 720.0),
               mesh = 2.0 * reach / (grid.columns - 3.0);
  const double down = 0.5 * mesh * (grid.rows - 3.0);
  constexpr int kPerMesh = 3;
  for (double y = -down; y <= down; y += mesh / kPerMesh) {
    for (double x = -reach; x <= reach; x += mesh / kPerMesh) {
      const Eigen::Vector3d ray = Eigen::Vector3d(x, y, 1.0 - 0.25 * (x * x + y * y)).normalized();
      const auto px = camera::project(seen, ray);
      const auto back = px ? camera::unproject_ray(seen, *px) : std::nullopt;
      // Beyond the fold of the formula there is nothing to imitate.
      if (!back || (*back - ray).norm() > 1e-6) continue;
      const auto at = camera::project_with_jacobians(out, ray);
      const Eigen::Vector2d shift((px->x() - seen.cx) / seen.fx - x, (px->y() - seen.cy) / seen.fy - y);
      for (Eigen::Index a = 4; a < at->d_intrinsics.cols(); a += 2) {
        const Eigen::Index knot_a = (at->place[static_cast<std::size_t>(a)] - 4) / 2;
        const double weight_a = at->d_intrinsics(0, a) / seen.fx;
        right.row(knot_a) += weight_a * shift.transpose();
        for (Eigen::Index b = 4; b < at->d_intrinsics.cols(); b += 2)
          normal(knot_a, (at->place[static_cast<std::size_t>(b)] - 4) / 2) +=
              weight_a * at->d_intrinsics(0, b) / seen.fx;
      }
    }
  }
  const Eigen::MatrixX2d values = normal.ldlt().solve(right);
  for (Eigen::Index k = 0; k < knots; ++k) {
    out.distortion[static_cast<std::size_t>(2 * k)] = values(k, 0);
    out.distortion[static_cast<std::size_t>(2 * k + 1)] = values(k, 1);
  }
  return out;
}

/// A splined lens: a fisheye first, which bends to anything radial, then knots that start on its surface.
/// They are free of it but for a prior that speaks where no corner does: there the surface stays near the
/// fisheye's.
Status solve_splined_lens(const Job& job, const Start& start, Round& round) {
  Job first = job;
  first.options.model = camera::CameraModel::fisheye;
  first.options.solve_aspect = first.options.solve_warp = false;
  FURROW_DO(solve_formula(first, start, round));
  Camera seen = start.camera;
  take_over(round, round.solved, seen);
  if (!camera::validate(seen).ok()) return solve_failed("no fisheye to start the splines from");
  std::size_t corners = 0;
  for (const SolveView& view : round.views) corners += view.seen.px.size();
  FreeTerms free;
  free.core = false;
  const camera::SplineGrid grid = grid_for(seen, corners);
  const Camera camera = splined_like(seen, grid);
  if (!camera::validate(camera).ok()) return solve_failed("no grid of knots over what the lens sees");
  free.distortion = static_cast<int>(camera.distortion.size());
  free.warp = job.options.solve_warp;
  const double noise_px = residual_px(round);
  round.model = make_shared_model(camera, round.model.board, Eigen::Vector2d::Zero(), free);
  // Knots within 0.02 of the fisheye's surface, one sigma: some 20 px at a focal length of 1000.
  constexpr double kKnotSigma = 0.02;
  round.model.prior_mean = shared_of(round.model);
  round.model.prior_weight = Eigen::VectorXd::Constant(round.model.count, noise_px / kKnotSigma);
  if (free.warp) round.model.prior_weight.tail<2>().setZero();
  round.solved = solve(round.model, shared_of(round.model), round.views, {job.options.max_iterations});
  return Done{};
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

bool is_left_out(const View& view, std::size_t corner) {
  return !view.left_out.empty() && view.left_out[corner];
}

/// Writes a solved view's pose and residuals.
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

}  // namespace

Result<Calibration> calibrate(const std::vector<target::BoardDetection>& detections,
                              const target::BoardSpec& board, const CalibrateOptions& options) {
  FURROW_DO(target::validate(board));
  if (options.solve_aspect && options.model == camera::CameraModel::splined_stereographic) {
    return Error{"bad_option", "calibration", "a splined lens with the board's aspect free", "one of the two",
                 "splines take up any stretch; measure the board"};
  }
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
