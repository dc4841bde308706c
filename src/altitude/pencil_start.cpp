#include "pencil_start.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "furrow/stats/robust.h"
#include "pencil_lines.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;

GimbalAngles start_angles(const std::vector<EdgeLine>& lines, const RowDirectionFit& fit,
                          const GimbalPrior& prior, bool parallel, double lambda) {
  GimbalAngles start;
  start.lambda = lambda;
  if (parallel) {
    start.theta = prior.theta.value;
    start.psi = yaw_at_pitch(lines, start.theta);
  } else {
    // Undo the roll about the level forward axis to first order by the exact VP of a level camera (eq. 3.3).
    start.theta = std::atan2(fit.direction.y(), fit.direction.z());
    start.psi = std::asin(std::clamp(fit.direction.x(), -1.0, 1.0));
  }
  return start;
}

/// Differences of slope over difference of index between lines whose rows are at most `reach` apart.
std::vector<double> slope_steps(const std::vector<double>& places, const std::vector<double>& slopes,
                                const std::vector<EdgeLine>& lines, int reach) {
  std::vector<double> steps;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = std::abs(static_cast<double>(lines[i].row) - lines[j].row);
      if (apart >= 1.0 && apart <= reach) steps.push_back((slopes[i] - slopes[j]) / (places[i] - places[j]));
    }
  }
  return steps;
}

/// b of a row alone whose half width is `ratio` spacings; as high as a spacing where its edges are not seen.
double step_by_width(const std::vector<EdgeLine>& lines, const std::vector<double>& slopes, double ratio) {
  if (lines.size() != 2 || !(lines[0].reach * lines[1].reach < 0.0)) return -1.0;
  const double width = (slopes[0] - slopes[1]) / (lines[0].reach - lines[1].reach);
  return width > 0.0 ? -width / ratio : -1.0;
}

/// Straight line through slopes over row index by medians (Theil and Sen), so that rows with a wrong index do
/// not matter: the start of a and b. Neighbours first, since a detector that miscounts does so over a gap.
/// With g = -ratio b: slope = a + b (k - ratio * reach). A row alone tells b by its width only.
void start_slopes(const std::vector<EdgeLine>& lines, const RowAxes<double>& axes, double ratio,
                  PencilVector& x) {
  std::vector<double> places, slopes, offsets;
  for (const EdgeLine& line : lines) {
    places.push_back(line.row - ratio * line.reach);
    slopes.push_back(slope_at(axes, line));
  }
  std::vector<double> steps = slope_steps(places, slopes, lines, 1);
  if (steps.empty()) steps = slope_steps(places, slopes, lines, std::numeric_limits<int>::max());
  x[kPencilB] = steps.empty() ? step_by_width(lines, slopes, ratio) : stats::median(steps);
  for (std::size_t i = 0; i < lines.size(); ++i) offsets.push_back(slopes[i] - x[kPencilB] * places[i]);
  x[kPencilA] = stats::median(offsets);
  x[kPencilG] = -ratio * x[kPencilB];
}

/// Misfit of lines to the straight line of their start, in squares of what rows stray by, each no more than a
/// line with a wrong index.
double start_misfit(const std::vector<EdgeLine>& lines, const RowAxes<double>& axes, const PencilVector& x) {
  constexpr double kStray = 0.03;  // spacings: plants, and a pixel or two
  constexpr double kMost = 5.0;    // of these
  double sum = 0.0;
  for (const EdgeLine& line : lines) {
    const double off = slope_at(axes, line) - pencil_slope(x.data(), line);
    const double strays = std::min(std::abs(off / x[kPencilB]) / kStray, kMost);
    sum += strays * strays;
  }
  return sum;
}

PencilStart start_at(double lambda, const std::vector<EdgeLine>& all, const RowDirectionFit& direction,
                     const GimbalPrior& gimbal, bool parallel, const RelativeFarm& farm) {
  const GimbalAngles angles = start_angles(all, direction, gimbal, parallel, lambda);
  PencilStart start;
  start.lines = all;
  start.axes = row_axes(angles.theta, angles.lambda, angles.psi);
  std::erase_if(start.lines, [&](const EdgeLine& line) { return !below_horizon(start.axes, line); });
  start.value << angles.theta, angles.lambda, angles.psi, 0.0, 0.0, 0.0;
  if (start.lines.empty()) return start;
  set_reaches(start.lines, start.axes, std::exp(farm.log_top_depth.value));
  start.tops = top_lines(start.lines, start.axes);
  start_slopes(start.tops, start.axes, farm.width_ratio.value, start.value);
  start.misfit = start_misfit(start.tops, start.axes, start.value);
  return start;
}

}  // namespace

PencilStart best_start(const std::vector<EdgeLine>& lines, const RowDirectionFit& direction,
                       const GimbalPrior& gimbal, bool parallel, const RelativeFarm& farm) {
  constexpr double kStep = deg_to_rad(1.5), kFarthest = deg_to_rad(30.0);
  constexpr double kMostSigmas = 3.0, kLeastGain = 10.0;
  const auto& [told, sigma, observations] = gimbal.lambda;
  PencilStart best = start_at(told, lines, direction, gimbal, parallel, farm);
  const int rows = distinct_rows(best.lines);
  if (rows < 3 || !(std::abs(best.value[kPencilPsi]) < kMaxYaw)) return best;
  double least = best.misfit - kLeastGain;
  const int steps = static_cast<int>(std::min(kFarthest, kMostSigmas * sigma) / kStep);
  for (int i = -steps; i <= steps; ++i) {
    if (i == 0) continue;  // the best so far started there
    const double off = i * kStep;
    PencilStart one = start_at(told + off, lines, direction, gimbal, parallel, farm);
    const double misfit = one.misfit + off * off / (sigma * sigma);
    if (distinct_rows(one.lines) < rows || !(misfit < least)) continue;
    least = misfit;
    best = std::move(one);
  }
  return best;
}

}  // namespace furrow::altitude
