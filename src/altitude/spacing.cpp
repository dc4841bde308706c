#include "spacing.h"

#include <ceres/tiny_solver.h>
#include <ceres/tiny_solver_autodiff_function.h>
#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <set>

#include "farm.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;
using geom::kPi;

/// A camera whose roll nobody states is taken as level like a hand-held one; gimbals do five times better.
const double kUnknownRollSigma = deg_to_rad(3.0);
/// Rows whose common point leaves the pitch open by more than this are parallel as far as the picture tells.
const double kParallelPitchSigma = deg_to_rad(5.0);
/// Beyond this yaw a cut along a picture row meets the rows at less than 30 deg and is no cut across a row.
const double kMaxYaw = deg_to_rad(60.0);
/// An exactly known angle still needs a sigma above 0.
constexpr double kExactAngleSigma = 1e-9;

Error degenerate(const char* code, std::string found, std::string wanted) {
  return Error{code, "rows", std::move(found), std::move(wanted), ""};
}

Result<Estimate> checked_angle(const char* name, const Estimate& angle) {
  if (std::isnan(angle.value)) return Estimate{};
  const bool sound = std::isfinite(angle.value) && std::isfinite(angle.sigma) && angle.sigma >= 0.0;
  if (!sound) {
    return Error{"not_finite", name,
                 base::format_double(angle.value) + " with sigma " + base::format_double(angle.sigma),
                 "a finite angle with a finite sigma, or NaN for not known", ""};
  }
  return Estimate{angle.value, std::max(angle.sigma, kExactAngleSigma), angle.observations};
}

/// Plane through the camera's centre and a line, as a unit normal.
Eigen::Vector3d plane_of(const EdgeLine& line) {
  return line.points[0].homogeneous().cross(line.points[1].homogeneous()).normalized();
}

/// Direction of the rows in the camera, with the information that the lines give about it.
struct RowDirectionFit {
  Eigen::Vector3d direction;
  double pitch_sigma = 0.0;
};

/// Eq. 3.2: all edges of all rows are parallel in the world, walls too, so all their planes hold the row
/// direction.
RowDirectionFit fit_direction(const std::vector<EdgeLine>& lines) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const EdgeLine& line : lines) {
    const Eigen::Vector3d normal = plane_of(line);
    const double half_length = 0.5 * (line.points[1] - line.points[0]).norm();
    information += half_length * half_length / line.variance.mean() * normal * normal.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(information);
  RowDirectionFit fit;
  fit.direction = eigen.eigenvectors().col(0);
  // Forward is the end of the row that the upper part of the picture shows.
  if (fit.direction.dot(Eigen::Vector3d(0, -1, 1)) < 0.0) fit.direction = -fit.direction;
  const Eigen::Vector3d& v = fit.direction;
  const Eigen::Vector3d nod = Eigen::Vector3d(0.0, v.z(), -v.y()).normalized();
  double variance = 0.0;
  for (int i = 1; i < 3; ++i) {
    const double part = nod.dot(eigen.eigenvectors().col(i));
    variance += part * part / std::max(eigen.eigenvalues()[i], 1e-300);
  }
  fit.pitch_sigma = std::sqrt(variance);
  return fit;
}

/// Yaw that turns the rows' planes onto a row direction of known pitch (eq. 3.4).
double yaw_at_pitch(const std::vector<EdgeLine>& lines, double theta) {
  double xx = 0.0, xm = 0.0, mm = 0.0;
  for (const EdgeLine& line : lines) {
    const Eigen::Vector3d l = plane_of(line);
    const double weight = (line.points[1] - line.points[0]).squaredNorm() / line.variance.mean();
    const double m = l.y() * std::sin(theta) + l.z() * std::cos(theta);
    xx += weight * l.x() * l.x();
    xm += weight * l.x() * m;
    mm += weight * m * m;
  }
  // The (sin psi, cos psi) of the smallest weighted sum of (l_x sin psi + m cos psi)^2.
  const double angle = 0.5 * std::atan2(2.0 * xm, xx - mm) + kPi / 2.0;
  return std::remainder(kPi / 2.0 - angle, kPi);
}

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

/// Slope at which a line lies: the t that puts its middle on l = m + t q.
double slope_at(const RowAxes<double>& axes, const EdgeLine& line) {
  const Eigen::Vector2d p = 0.5 * (line.points[0] + line.points[1]);
  const double lateral = axes.m.x * p.x() + axes.m.y * p.y() + axes.m.z;
  const double up = axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z;
  return -lateral / up;
}

/// By the middle of its samples; its two points may reach beyond them.
bool below_horizon(const RowAxes<double>& axes, const EdgeLine& line) {
  const Eigen::Vector2d p = 0.5 * (line.points[0] + line.points[1]);
  return axes.q.x * p.x() + axes.q.y * p.y() + axes.q.z < 0.0;
}

/// -1, 0, 1: to which side of its row's axis the line lies.
double side_of(const EdgeLine& line) {
  if (line.side == Side::centre) return 0.0;
  return line.side == Side::left ? 1.0 : -1.0;
}

/// EdgeLine::reach of far edges of tops that are `depth` half widths deep; 1 for near edges.
void set_reaches(std::vector<EdgeLine>& lines, const RowAxes<double>& axes, double depth) {
  for (EdgeLine& line : lines) {
    const double side = side_of(line), t = depth * std::max(0.0, side * slope_at(axes, line));
    line.reach = side * (std::sqrt(1.0 + t * t) - t);
  }
}

/// The silhouette on the far side is the top edge whatever the shape of the wall (eq. 3.5).
bool is_top_edge(const EdgeLine& line, double slope) {
  return side_of(line) * slope >= 0.0;
}

int distinct_rows(const std::vector<EdgeLine>& lines) {
  std::set<int> rows;
  for (const EdgeLine& line : lines) rows.insert(line.row);
  return static_cast<int>(rows.size());
}

/// A row that shows no edge has grown into its neighbours, and where its middle lies is the detector's guess;
/// it counts only when there are not two rows with edges. Nor does a glimpse of an edge count beside rows
/// that show theirs: leaves in front of it and behind it decide what is seen.
std::vector<EdgeLine> prefer_edges(const std::vector<EdgeLine>& lines) {
  constexpr int kGlimpse = 6;  // samples
  std::vector<EdgeLine> edges, clear;
  for (const EdgeLine& line : lines) {
    if (line.side == Side::centre) continue;
    edges.push_back(line);
    if (line.samples >= kGlimpse) clear.push_back(line);
  }
  if (distinct_rows(clear) >= 2) return clear;
  return distinct_rows(edges) >= 2 ? edges : lines;
}

/// Of a row alone: its two edges where both are clear; its middle says no more than they do.
std::vector<EdgeLine> single_row_lines(const std::vector<EdgeLine>& lines) {
  constexpr int kGlimpse = 6;  // samples
  std::vector<EdgeLine> edges;
  for (const EdgeLine& line : lines) {
    if (line.side != Side::centre && line.samples >= kGlimpse) edges.push_back(line);
  }
  return edges.size() == 2 ? edges : lines;
}

/// Lines that the pencil's model holds for: far edges and centres; near edges too when fewer than two rows
/// are left without them.
std::vector<EdgeLine> pencil_lines(const std::vector<EdgeLine>& lines, const RowAxes<double>& axes) {
  std::vector<EdgeLine> tops;
  for (const EdgeLine& line : lines) {
    if (is_top_edge(line, slope_at(axes, line))) tops.push_back(line);
  }
  return distinct_rows(tops) >= 2 ? tops : lines;
}

/// One prior of the pencil: coefficients on the parameters, value wanted, sigma.
struct PencilPrior {
  PencilVector coefficients = PencilVector::Zero();
  double value = 0.0, sigma = 1.0;
};

struct PencilBlock {
  RowBlock rows;
  Eigen::MatrixXd whitener;
};

struct PencilResidual {
  const std::vector<PencilBlock>* blocks = nullptr;
  const std::vector<PencilPrior>* priors = nullptr;

  int NumResiduals() const {
    int n = static_cast<int>(priors->size());
    for (const PencilBlock& block : *blocks) n += block.rows.residuals();
    return n;
  }

  template <class T>
  bool operator()(const T* x, T* residuals) const {
    const RowAxes<T> axes = row_axes(x[kPencilTheta], x[kPencilLambda], x[kPencilPsi]);
    int at = 0;
    for (const PencilBlock& block : *blocks) {
      const int n = block.rows.residuals();
      Eigen::Matrix<T, Eigen::Dynamic, 1> raw(n);
      for (int i = 0; i < n; ++i) {
        const EdgeLine& line = block.rows.lines[static_cast<std::size_t>(i / 2)];
        const T t = x[kPencilA] + x[kPencilB] * static_cast<double>(line.row) + x[kPencilG] * line.reach;
        raw[i] = distance(line_at(axes, t), line.points[i % 2]);
      }
      for (int i = 0; i < n; ++i, ++at) {
        residuals[at] = T(0.0);
        for (int j = 0; j <= i; ++j) residuals[at] += block.whitener(i, j) * raw[j];
      }
    }
    for (const PencilPrior& prior : *priors) {
      T sum = T(-prior.value);
      for (int i = 0; i < kPencilSize; ++i) sum += prior.coefficients[i] * x[i];
      residuals[at++] = sum / prior.sigma;
    }
    return true;
  }
};

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
    const double wanted = x[kPencilA] + x[kPencilB] * line.row + x[kPencilG] * line.reach;
    const double off = std::min(std::abs((slope_at(axes, line) - wanted) / x[kPencilB]) / kStray, kMost);
    sum += off * off;
  }
  return sum;
}

/// Whether a line lies where an edge of its row can lie, within half a spacing (eq. 3.6): at the top edge;
/// or, for the near edge, from there to the foot of a wall as deep as the spacing, but not before the far
/// edge of the row in front. Others carry a wrong index.
bool lies_at_its_row(const EdgeLine& line, double slope, const PencilVector& x) {
  const double b = x[kPencilB], side = side_of(line);
  const double top = x[kPencilA] + b * line.row + x[kPencilG] * line.reach;
  const double margin = 0.5 * std::abs(b);
  if (side == 0.0 || side * top >= 0.0) return std::abs(slope - top) <= margin;
  // Distances from the foot of the camera, both positive on the row's own side.
  const double away = top < 0.0 ? -1.0 : 1.0;
  const double foot = away * top / (1.0 + std::abs(b));
  const double front = away * top - std::abs(b) + 2.0 * x[kPencilG];
  const double seen = away * slope;
  return seen <= away * top + margin && seen >= std::max(foot, front) - margin;
}

/// Half width over spacing with sigma, the shape of the tops, and the rows' wander over spacing.
struct RelativeFarm {
  Estimate width_ratio;
  Estimate log_top_depth;  ///< of the rounded top over the half width
  RowWander wander;
};

RelativeFarm relative_farm(const FieldKnowledge& field) {
  RelativeFarm r;
  // Without numbers: anywhere between no width and rows that touch.
  r.width_ratio = {0.25, 0.5 / std::sqrt(12.0), 0};
  const double s = field.row_spacing_m.value;
  if (field.row_spacing_m.usable() && field.half_width_m.usable() && s > 0.0) {
    const double w = field.half_width_m.value / s;
    const double relative =
        std::hypot(field.half_width_m.sigma / field.half_width_m.value, field.row_spacing_m.sigma / s);
    r.width_ratio = {w, std::max(w * relative, 1e-6), 0};
  }
  const bool metres = field.row_spacing_m.usable() && s > 0.0;
  r.log_top_depth = log_rounding(metres ? field : FieldKnowledge{}, r.width_ratio.value * (metres ? s : 1.0));
  r.wander.planting_sigma_m =
      metres && std::isfinite(field.planting_sigma_m) ? field.planting_sigma_m / s : kPlantingSigmaPerSpacing;
  r.wander.growth_sigma_m = metres && std::isfinite(field.growth_sigma_m)
                                ? field.growth_sigma_m / s
                                : kGrowthSigmaPerHalfWidth * r.width_ratio.value;
  return r;
}

/// How wrong the top edge's slope is for a near edge, which may be the foot of a wall as deep as the spacing:
/// uniform over t to t / (1 + |b|), about its upper end (eq. 3.7).
double wall_slope_sigma(const EdgeLine& line, double slope, double b) {
  if (is_top_edge(line, slope)) return 0.0;
  return std::abs(slope * b) / (1.0 + std::abs(b)) / std::sqrt(3.0);
}

std::vector<PencilBlock> whitened_blocks(const std::vector<EdgeLine>& lines, const PencilVector& x,
                                         const RowWander& wander) {
  const RowAxes<double> axes = row_axes(x[kPencilTheta], x[kPencilLambda], x[kPencilPsi]);
  std::vector<PencilBlock> blocks;
  for (RowBlock& rows : group_by_row(lines)) {
    std::vector<LinePlace> places;
    for (const EdgeLine& line : rows.lines) {
      const double slope = x[kPencilA] + x[kPencilB] * line.row + x[kPencilG] * line.reach;
      // Lengths in units of the spacing: the drop is 1 / |b|.
      places.push_back({slope, 1.0 / std::abs(x[kPencilB]), wall_slope_sigma(line, slope, x[kPencilB])});
    }
    PencilBlock block;
    block.whitener = whitener_of(block_covariance(rows, places, axes, wander));
    block.rows = std::move(rows);
    blocks.push_back(std::move(block));
  }
  return blocks;
}

/// What the picture leaves open: the pitch where rows are parallel or alone, and then b, which a row alone
/// hardly tells and nobody asks of it.
struct OpenParts {
  bool pitch = false, step = false;
};

std::vector<PencilPrior> pencil_priors(const GimbalPrior& prior, const OpenParts& open,
                                       const RelativeFarm& farm, double b) {
  std::vector<PencilPrior> priors(2);
  priors[0].coefficients[kPencilLambda] = 1.0;
  priors[0].value = prior.lambda.value;
  priors[0].sigma = prior.lambda.sigma;
  // g = -ratio b.
  priors[1].coefficients[kPencilG] = 1.0;
  priors[1].coefficients[kPencilB] = farm.width_ratio.value;
  priors[1].sigma = farm.width_ratio.sigma * std::abs(b);
  if (open.pitch) {
    PencilPrior pitch;
    pitch.coefficients[kPencilTheta] = 1.0;
    pitch.value = prior.theta.value;
    pitch.sigma = prior.theta.sigma;
    priors.push_back(pitch);
  }
  if (open.step) {
    PencilPrior step;
    step.coefficients[kPencilB] = 1.0;
    step.value = b;
    step.sigma = std::abs(b);
    priors.push_back(step);
  }
  return priors;
}

/// Weighted adjustment of the pencil from its start; covariance from the normal equations.
Status adjust(const std::vector<EdgeLine>& lines, const GimbalPrior& prior, const OpenParts& open,
              const RelativeFarm& farm, Pencil& pencil) {
  const std::vector<PencilBlock> blocks = whitened_blocks(lines, pencil.value, farm.wander);
  const std::vector<PencilPrior> priors = pencil_priors(prior, open, farm, pencil.value[kPencilB]);
  PencilResidual residual{&blocks, &priors};
  using Function = ceres::TinySolverAutoDiffFunction<PencilResidual, Eigen::Dynamic, kPencilSize>;
  Function function(residual);
  ceres::TinySolver<Function> solver;
  solver.options.max_num_iterations = 50;
  solver.options.gradient_tolerance = 1e-14;
  solver.options.parameter_tolerance = 1e-13;
  solver.options.function_tolerance = 1e-15;
  solver.Solve(function, &pencil.value);
  Eigen::MatrixXd jacobian(residual.NumResiduals(), kPencilSize);
  Eigen::VectorXd r(residual.NumResiduals());
  function(pencil.value.data(), r.data(), jacobian.data());
  const Eigen::LDLT<Eigen::MatrixXd> normal(jacobian.transpose() * jacobian);
  pencil.covariance = normal.solve(Eigen::MatrixXd::Identity(kPencilSize, kPencilSize));
  const bool sound = pencil.value.allFinite() && pencil.covariance.allFinite() &&
                     pencil.covariance.diagonal().minCoeff() > 0.0 && pencil.value[kPencilB] < 0.0;
  if (!sound)
    return degenerate("ill_conditioned", "rows that fit no set of equally spaced lines",
                      "rows in order from left to right");
  return Done{};
}

/// Adds to the covariance what the tops' depth, shallower by a sigma, does to the pencil (eq. 3.9).
Status add_top_depth(std::vector<EdgeLine> lines, const GimbalPrior& prior, const OpenParts& open,
                     const RelativeFarm& farm, Pencil& pencil) {
  const GimbalAngles angles = pencil.angles();
  set_reaches(lines, row_axes(angles.theta, angles.lambda, angles.psi),
              std::exp(farm.log_top_depth.value - farm.log_top_depth.sigma));
  Pencil flatter = pencil;
  FURROW_DO(adjust(lines, prior, open, farm, flatter));
  const PencilVector moved = flatter.value - pencil.value;
  pencil.covariance += moved * moved.transpose();
  return Done{};
}

/// Where the adjustment of the pencil starts: lines below the horizon, those of tops, angles and slopes.
struct PencilStart {
  std::vector<EdgeLine> lines, tops;
  RowAxes<double> axes;
  PencilVector value;
  double misfit = 0.0;
};

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
  start.tops = pencil_lines(start.lines, start.axes);
  start_slopes(start.tops, start.axes, farm.width_ratio.value, start.value);
  start.misfit = start_misfit(start.tops, start.axes, start.value);
  return start;
}

/// Starts from the gimbal's roll, unless another within three of its sigmas suits the rows clearly better: on
/// ground that slopes across, steps between rows grow to the one side and shrink to the other, and their
/// median, and which lines carry a wrong index, are off (eq. 3.12).
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
    const double off = i * kStep;
    PencilStart one = start_at(told + off, lines, direction, gimbal, parallel, farm);
    const double misfit = one.misfit + off * off / (sigma * sigma);
    if (distinct_rows(one.lines) < rows || !(misfit < least)) continue;
    least = misfit;
    best = std::move(one);
  }
  return best;
}

/// `may_be_one`: a row alone, row 0, will do.
Result<std::vector<EdgeLine>> usable_lines(const RowsOnUnitPlane& rows, bool may_be_one) {
  for (const RowsOnUnitPlane::Row& row : rows.rows) {
    for (const RowDirection& d : row.directions) {
      if (!d.centre.allFinite() || !std::isfinite(d.sigma)) {
        return degenerate("not_finite",
                          "a direction of row " + std::to_string(row.index) + " that is not finite",
                          "finite directions with finite sigmas");
      }
    }
  }
  std::vector<EdgeLine> lines = prefer_edges(reduce_to_lines(rows));
  const int distinct = distinct_rows(lines);
  if (distinct >= 2) return lines;
  if (may_be_one && rows.rows.size() == 1 && distinct == 1 && lines.front().row == 0)
    return single_row_lines(lines);
  const bool shared = rows.rows.size() >= 2 && !lines.empty();
  if (shared)
    return degenerate("ill_conditioned", "all rows share one index", "two or more rows that differ in index");
  return degenerate("not_enough_rows", std::to_string(distinct) + " row with two or more samples",
                    may_be_one ? "two or more rows, or one and the gimbal's pitch" : "two or more rows");
}

}  // namespace

Result<GimbalPrior> gimbal_prior(const AttitudePrior& prior) {
  GimbalPrior result;
  FURROW_TRY(const Estimate pitch, checked_angle("pitch_rad", prior.pitch_rad));
  FURROW_TRY(const Estimate roll, checked_angle("roll_rad", prior.roll_rad));
  result.lambda = {0.0, kUnknownRollSigma, 0};
  if (roll.usable()) {
    const double p = pitch.usable() ? pitch.value : 0.0;
    result.lambda = {lambda_of(p, roll.value), roll.sigma, 1};
  }
  if (pitch.usable()) {
    const double sine = std::sin(pitch.value) / std::cos(result.lambda.value);
    result.theta = {std::asin(std::clamp(sine, -1.0, 1.0)), pitch.sigma, 1};
  }
  return result;
}

Result<Pencil> fit_pencil(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                          const AttitudePrior& prior, int least_rows) {
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(prior));
  FURROW_TRY(std::vector<EdgeLine> lines, usable_lines(rows, least_rows < 2 && gimbal.theta.usable()));
  const bool is_alone = distinct_rows(lines) < 2;
  const RowDirectionFit direction = fit_direction(lines);
  const bool parallel = is_alone || direction.pitch_sigma > kParallelPitchSigma;
  if (parallel && !gimbal.theta.usable()) {
    return degenerate("no_pitch", "rows that are parallel in the picture, and no pitch prior",
                      "a pitch from the gimbal");
  }
  const RelativeFarm farm = relative_farm(field);
  const PencilStart start = best_start(lines, direction, gimbal, parallel, farm);
  if (!(std::abs(start.value[kPencilPsi]) < kMaxYaw)) {
    return degenerate(
        "rows_across",
        "rows at " + base::format_fixed(geom::rad_to_deg(start.value[kPencilPsi]), 1) + " deg to the camera",
        "rows within 60 deg of the viewing direction");
  }
  lines = start.lines;
  const int needed = is_alone ? 1 : 2;
  if (distinct_rows(lines) < needed) {
    return degenerate("camera_along_horizon", "fewer than two rows below the horizon of the rows' plane",
                      "a camera that looks down on the rows");
  }
  const RowAxes<double>& axes = start.axes;
  std::vector<EdgeLine> tops = start.tops;
  Pencil pencil;
  pencil.value = start.value;
  const auto misplaced = [&](const EdgeLine& line) {
    return !lies_at_its_row(line, slope_at(axes, line), pencil.value);
  };
  const int rows_before = distinct_rows(lines);
  std::erase_if(lines, misplaced);
  std::erase_if(tops, misplaced);
  pencil.rows_left_out = rows_before - distinct_rows(lines);
  pencil.rows = distinct_rows(tops);
  if (pencil.rows < needed) {
    return degenerate("ill_conditioned", "rows that fit no set of equally spaced lines",
                      "rows in order from left to right");
  }
  const OpenParts open{parallel, is_alone};
  FURROW_DO(adjust(tops, gimbal, open, farm, pencil));
  FURROW_DO(add_top_depth(tops, gimbal, open, farm, pencil));
  pencil.blocks = group_by_row(lines);
  for (const EdgeLine& line : tops) pencil.observations += line.samples;
  return pencil;
}

namespace {

/// Places in Scale's vector.
constexpr int kA = 0, kB = 1, kG = 2, kDrop = 3, kRise = 4;
using ScaleVector = Eigen::Matrix<double, 5, 1>;

/// The pencil in metres: a, b, g, drop to the rows' outline, and the outline's rise over the named top
/// (eq. 3.10).
struct Scale {
  ScaleVector value = ScaleVector::Zero();
  Eigen::Matrix<double, 5, 5> covariance = Eigen::Matrix<double, 5, 5>::Zero();

  double covariance_of(const ScaleVector& one, const ScaleVector& other) const {
    return one.dot(covariance * other);
  }
  double sigma_of(const ScaleVector& gradient) const {
    return std::sqrt(std::max(0.0, covariance_of(gradient, gradient)));
  }
  /// The drop as what `gradient` of the others and an independent sigma make it.
  void set_drop(double drop, const ScaleVector& gradient, double sigma) {
    value[kDrop] = drop;
    covariance.row(kDrop) = (covariance * gradient).transpose();
    covariance.col(kDrop) = covariance.row(kDrop).transpose();
    covariance(kDrop, kDrop) = covariance_of(gradient, gradient) + sigma * sigma;
  }
  /// One more independent measurement that differs from the value by `misfit` (eq. 3.11).
  void measure(const ScaleVector& gradient, double misfit, double sigma) {
    const ScaleVector shared = covariance * gradient;
    const double variance = gradient.dot(shared) + sigma * sigma;
    value += shared * (misfit / variance);
    covariance -= shared * shared.transpose() / variance;
  }
};

ScaleVector unit(int place) {
  return ScaleVector::Unit(place);
}

Estimate rise_at(const FieldKnowledge& field, double half_width) {
  const auto part = [&](const Estimate& log_part) { return half_width * std::exp(log_part.value); };
  return outline_rise(
      field, {half_width, part(log_rounding(field, half_width)), part(log_softness(field, half_width))});
}

/// Nothing where no metres are known, or those that are leave the camera under the rows.
std::optional<Scale> scale_of(const Pencil& pencil, const FieldKnowledge& field, const Estimate& height) {
  Scale s;
  s.value.head<3>() = pencil.value.segment<3>(kPencilA);
  s.covariance.topLeftCorner<3, 3>() = pencil.covariance.block<3, 3>(kPencilA, kPencilA);
  const double b = s.value[kB], g = s.value[kG];
  const Estimate &spacing = field.row_spacing_m, &width = field.half_width_m;
  const bool by_spacing = spacing.usable() && pencil.rows >= 2;
  const bool by_width = !by_spacing && width.usable() && g > 0.0;
  if (!by_spacing && !by_width && !height.usable()) return std::nullopt;
  double drop = by_spacing ? -spacing.value / b : height.usable() ? height.value : width.value / g;
  Estimate rise = rise_at(field, g * drop);
  if (!by_spacing && height.usable()) {
    drop = height.value - rise.value;
    rise = rise_at(field, g * drop);
    drop = height.value - rise.value;
  }
  if (!(drop > 0.0)) return std::nullopt;
  s.value[kRise] = rise.value;
  s.covariance(kRise, kRise) = rise.sigma * rise.sigma;
  if (by_spacing) {
    s.set_drop(drop, spacing.value / (b * b) * unit(kB), spacing.sigma / b);
    if (height.usable()) s.measure(unit(kDrop) + unit(kRise), height.value - drop - rise.value, height.sigma);
    return s;
  }
  if (height.usable()) {
    s.set_drop(drop, -unit(kRise), height.sigma);
    if (by_width) s.measure(drop * unit(kG) + g * unit(kDrop), width.value - g * drop, width.sigma);
    return s;
  }
  s.set_drop(drop, -width.value / (g * g) * unit(kG), width.sigma / g);
  return s;
}

SpacingHeight in_metres(const Pencil& pencil, const FieldKnowledge& field, const Estimate& height) {
  const geom::Attitude attitude = attitude_from(pencil.angles());
  const Eigen::Matrix3d turn = attitude_jacobian(pencil.angles());
  const Eigen::Matrix3d angles = turn * pencil.covariance.topLeftCorner<3, 3>() * turn.transpose();
  const int n = pencil.observations;
  SpacingHeight result;
  result.pitch_rad = {attitude.pitch_rad, std::sqrt(angles(0, 0)), n};
  result.yaw_rad = {attitude.yaw_rad, std::sqrt(angles(2, 2)), n};
  const double over_spacing = -1.0 / pencil.value[kPencilB];
  if (pencil.rows >= 2) {
    const double b_sigma = std::sqrt(pencil.covariance(kPencilB, kPencilB));
    result.height_over_spacing = {over_spacing, b_sigma * over_spacing * over_spacing, n};
  }
  const std::optional<Scale> scale = scale_of(pencil, field, height);
  if (!scale) return result;
  const double a = scale->value[kA], b = scale->value[kB], drop = scale->value[kDrop];
  const ScaleVector to_cross = -drop * unit(kA) - a * unit(kDrop);    // c = -a H
  const ScaleVector to_spacing = -drop * unit(kB) - b * unit(kDrop);  // S = -b H
  const ScaleVector to_height = unit(kDrop) + unit(kRise);
  result.height_above_canopy_m = {drop + scale->value[kRise], scale->sigma_of(to_height), n};
  result.cross_track_m = {-a * drop, scale->sigma_of(to_cross), n};
  if (pencil.rows < 2) return result;
  result.row_spacing_m = {-b * drop, scale->sigma_of(to_spacing), n};
  result.cross_track_spacing_covariance_m2 = scale->covariance_of(to_cross, to_spacing);
  return result;
}

}  // namespace

Result<SpacingHeight> from_spacing(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                   const AttitudePrior& prior) {
  FURROW_TRY(const Pencil pencil, fit_pencil(rows, field, prior));
  FieldKnowledge known = field;
  if (!field.row_spacing_m.usable()) known.half_width_m = {};
  return in_metres(pencil, known, {});
}

Result<SpacingHeight> from_any_scale(const RowsOnUnitPlane& rows, const FieldKnowledge& field,
                                     const AttitudePrior& prior, const Estimate& height_above_canopy_m) {
  FURROW_TRY(const Pencil pencil, fit_pencil(rows, field, prior, 1));
  return in_metres(pencil, field, height_above_canopy_m);
}

}  // namespace furrow::altitude
