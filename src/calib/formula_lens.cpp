#include <algorithm>

#include "calib/pose.h"
#include "calib/round.h"

namespace furrow::calib {
namespace {

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

}  // namespace

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

}  // namespace furrow::calib
