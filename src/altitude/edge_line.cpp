#include "edge_line.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

/// Huber's bend in sigmas: 99 % of Gaussian samples keep full weight.
constexpr double kHuberBend = 2.5;
/// Reweighting passes of one line; each shrinks the pull of an outlier at least by half.
constexpr int kLinePasses = 6;
/// How many observations the detection's own sigma is worth against the scatter that is seen.
constexpr double kClaimWeight = 20.0;
/// Largest lag-1 correlation taken at its word; beyond it a line is one observation anyway.
constexpr double kMaxCorrelation = 0.98;

struct Samples {
  int row = 0;
  Side side = Side::centre;
  std::vector<Eigen::Vector2d> points;
  std::vector<double> sigmas;
};

struct Line {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Vector2d along = Eigen::Vector2d::UnitY();
  double spread = 0.0;         ///< weighted rms distance from the centroid along the line
  double weight_sum = 0.0;     ///< sum of 1 / sigma^2
  double mean_sigma2 = 0.0;    ///< count / weight_sum
  std::vector<double> scores;  ///< perpendicular residual / sigma, outliers drawn in to the bend
};

/// Weighted total least squares (eq. 4.1).
void fit_weighted(const Samples& samples, const std::vector<double>& weights, Line& line) {
  double sum = 0.0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    centroid += weights[i] * samples.points[i];
  }
  centroid /= sum;
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const Eigen::Vector2d d = samples.points[i] - centroid;
    scatter += weights[i] * d * d.transpose();
  }
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  line.along = {std::cos(angle), std::sin(angle)};
  line.centroid = centroid;
  line.weight_sum = sum;
  line.spread = std::sqrt(std::max(0.0, line.along.dot(scatter * line.along) / sum));
}

double signed_distance(const Line& line, const Eigen::Vector2d& p) {
  const Eigen::Vector2d d = p - line.centroid;
  return line.along.x() * d.y() - line.along.y() * d.x();
}

std::optional<Line> fit_line(const Samples& samples) {
  const std::size_t n = samples.points.size();
  if (n < 2) return std::nullopt;
  Line line;
  line.scores.resize(n);
  std::vector<double> weights(n);
  for (std::size_t i = 0; i < n; ++i) weights[i] = 1.0 / (samples.sigmas[i] * samples.sigmas[i]);
  for (int pass = 0; pass < kLinePasses; ++pass) {
    fit_weighted(samples, weights, line);
    for (std::size_t i = 0; i < n; ++i) {
      line.scores[i] = signed_distance(line, samples.points[i]) / samples.sigmas[i];
    }
    const double bend = kHuberBend * std::max(1.0, stats::mad_sigma(line.scores));
    bool drawn_in = false;
    for (std::size_t i = 0; i < n; ++i) {
      const double excess = std::abs(line.scores[i]) / bend;
      weights[i] = 1.0 / (samples.sigmas[i] * samples.sigmas[i] * std::max(1.0, excess));
      drawn_in = drawn_in || excess > 1.0;
      line.scores[i] = std::clamp(line.scores[i], -bend, bend);
    }
    if (!drawn_in) break;
  }
  if (!(line.spread > 0.0) || !std::isfinite(line.weight_sum)) return std::nullopt;
  line.mean_sigma2 = static_cast<double>(n) / line.weight_sum;
  return line;
}

/// Scatter and correlation along the rows, pooled over a shot's lines.
struct Noise {
  double variance_ratio = 1.0;  ///< scatter seen / claimed
  double inflation = 1.0;       ///< samples per independent sample (eq. 4.4)
};

Noise pooled_noise(const std::vector<Line>& lines) {
  double squares = 0.0, products = 0.0, freedom = 0.0, samples = 0.0;
  for (const Line& line : lines) {
    const double n = static_cast<double>(line.scores.size());
    freedom += n - 2.0;
    samples += n;
    for (std::size_t i = 0; i < line.scores.size(); ++i) {
      squares += line.scores[i] * line.scores[i];
      if (i > 0) products += line.scores[i] * line.scores[i - 1];
    }
  }
  Noise noise;
  noise.variance_ratio = (kClaimWeight + squares) / (kClaimWeight + freedom);
  const double mean_count = samples / static_cast<double>(std::max<std::size_t>(1, lines.size()));
  // A fitted line absorbs correlation; the bias of lag 1 about a fitted trend is -(2 + 4 rho) / n (Marriott
  // and Pope 1954).
  if (squares > 0.0 && mean_count > 8.0) {
    const double seen = products / squares;
    const double rho = (seen + 2.0 / mean_count) / (1.0 - 4.0 / mean_count);
    const double bounded = std::clamp(rho, 0.0, kMaxCorrelation);
    noise.inflation = std::min((1.0 + bounded) / (1.0 - bounded), mean_count / 2.0);
  }
  return noise;
}

/// Sigma of each of the two points (eq. 4.5): what scatters along the row averages out over the independent
/// samples; what is claimed beyond the scatter is common to the row and does not.
double point_sigma(const Line& line, const Noise& noise) {
  const double scattering = 2.0 * noise.variance_ratio * noise.inflation / line.weight_sum;
  const double common = std::max(0.0, 1.0 - noise.variance_ratio) * line.mean_sigma2;
  return std::sqrt(scattering + common);
}

std::vector<Samples> collect(const RowsOnUnitPlane& rows) {
  std::vector<Samples> all;
  for (const RowsOnUnitPlane::Row& row : rows.rows) {
    Samples left{row.index, Side::left, {}, {}}, right{row.index, Side::right, {}, {}};
    Samples centre{row.index, Side::centre, {}, {}};
    for (const RowDirection& d : row.directions) {
      centre.points.push_back(d.centre);
      centre.sigmas.push_back(d.sigma);
      if (d.left) left.points.push_back(*d.left), left.sigmas.push_back(d.edge_sigma);
      if (d.right) right.points.push_back(*d.right), right.sigmas.push_back(d.edge_sigma);
    }
    const bool has_left = left.points.size() >= 2, has_right = right.points.size() >= 2;
    if (has_left) all.push_back(std::move(left));
    if (has_right) all.push_back(std::move(right));
    if (!has_left && !has_right) all.push_back(std::move(centre));
  }
  return all;
}

}  // namespace

std::vector<EdgeLine> reduce_to_lines(const RowsOnUnitPlane& rows) {
  std::vector<EdgeLine> result;
  std::vector<Line> lines;
  for (const Samples& samples : collect(rows)) {
    auto line = fit_line(samples);
    if (!line) continue;
    EdgeLine edge;
    edge.row = samples.row;
    edge.side = samples.side;
    edge.points[0] = line->centroid - line->spread * line->along;
    edge.points[1] = line->centroid + line->spread * line->along;
    edge.samples = static_cast<int>(samples.points.size());
    result.push_back(edge);
    lines.push_back(std::move(*line));
  }
  const Noise noise = pooled_noise(lines);
  for (std::size_t i = 0; i < lines.size(); ++i) result[i].sigma = point_sigma(lines[i], noise);
  return result;
}

}  // namespace furrow::altitude
