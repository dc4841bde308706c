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

/// Samples with one common error were drawn through the meeting point of the other edges, so they say where
/// the line is and nothing about where it leads: variance of s times its slope over that of its offset.
constexpr double kFreeTurn = 9.0;

struct Samples {
  int row = 0;
  Side side = Side::centre;
  std::vector<Eigen::Vector2d> points;
  std::vector<double> sigmas;
  bool common = false;  ///< one error for all samples

  void add(const Eigen::Vector2d& point, double sigma) {
    points.push_back(point);
    sigmas.push_back(sigma);
  }
};

struct Line {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  Eigen::Vector2d along = Eigen::Vector2d::UnitY();
  double spread = 0.0;         ///< weighted rms distance from the centroid along the line
  double skewness = 0.0;       ///< weighted, of the places along the line
  double weight_sum = 0.0;     ///< sum of 1 / sigma^2
  double mean_sigma2 = 0.0;    ///< count / weight_sum
  std::vector<double> places;  ///< along the line from the centroid
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

double skewness_of(const Samples& samples, const std::vector<double>& weights, const Line& line) {
  double cubes = 0.0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double place = line.along.dot(samples.points[i] - line.centroid);
    cubes += weights[i] * place * place * place;
  }
  return cubes / (line.weight_sum * std::pow(line.spread, 3));
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
  std::vector<double> weights(n), used;
  for (std::size_t i = 0; i < n; ++i) weights[i] = 1.0 / (samples.sigmas[i] * samples.sigmas[i]);
  for (int pass = 0; pass < kLinePasses; ++pass) {
    used = weights;
    fit_weighted(samples, used, line);
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
  line.skewness = skewness_of(samples, used, line);
  line.mean_sigma2 = static_cast<double>(n) / line.weight_sum;
  for (const Eigen::Vector2d& p : samples.points) line.places.push_back(line.along.dot(p - line.centroid));
  return line;
}

/// Variances of a fitted line's offset and slope in units of what independent samples would give, for samples
/// whose errors correlate by rho from one to the next: v^T R v / v^T v with R_ij = rho^|i-j| (eq. 4.3).
struct Inflation {
  double offset = 1.0, slope = 1.0;
};

Inflation inflation_of(const std::vector<double>& places, double rho) {
  double offset = 0.0, slope = 0.0, squares = 0.0, carried = 0.0, carried_slope = 0.0;
  for (const double s : places) {
    offset += 1.0 + 2.0 * carried;
    slope += s * s + 2.0 * s * carried_slope;
    squares += s * s;
    carried = rho * (carried + 1.0);
    carried_slope = rho * (carried_slope + s);
  }
  return {offset / static_cast<double>(places.size()), slope / squares};
}

/// Scatter and correlation along the rows, typical of a shot's lines.
struct Noise {
  double variance_ratio = 1.0;  ///< scatter seen / claimed
  double rho = 0.0;             ///< between neighbouring samples
};

double squares_of(const Line& line) {
  double squares = 0.0;
  for (const double score : line.scores) squares += score * score;
  return squares;
}

/// What the sums of squares and of neighbours' products of all residuals would be for unit variance and this
/// rho: a fitted line takes its own two variances out of both (eq. 4.4).
struct ExpectedSums {
  double squares = 0.0, products = 0.0;
};

ExpectedSums expected_sums(const Line& line, double rho) {
  const double n = static_cast<double>(line.scores.size());
  const Inflation inflation = inflation_of(line.places, rho);
  const double absorbed = inflation.offset + inflation.slope;
  return {std::max(0.0, n - absorbed), rho * (n - 1.0) - absorbed * (n - 1.0) / n};
}

/// A line's scatter over what it claims, drawn towards `typical` by as much as kClaimWeight samples.
double variance_ratio(const Line& line, double typical, double rho) {
  return (kClaimWeight * typical + squares_of(line)) / (kClaimWeight + expected_sums(line, rho).squares);
}

ExpectedSums expected_sums(const std::vector<Line>& lines, double rho) {
  ExpectedSums sums;
  for (const Line& line : lines) {
    const ExpectedSums own = expected_sums(line, rho);
    sums.squares += own.squares;
    sums.products += own.products;
  }
  return sums;
}

Noise pooled_noise(const std::vector<Line>& lines) {
  double squares = 0.0, products = 0.0;
  for (const Line& line : lines) {
    squares += squares_of(line);
    for (std::size_t i = 1; i < line.scores.size(); ++i) products += line.scores[i] * line.scores[i - 1];
  }
  Noise noise;
  double low = 0.0, high = kMaxCorrelation;
  // The expected ratio grows with rho; 20 halvings fix it to 1e-6.
  for (int i = 0; i < 20 && squares > 0.0; ++i) {
    const double middle = 0.5 * (low + high);
    const ExpectedSums sums = expected_sums(lines, middle);
    (sums.products * squares < products * sums.squares ? low : high) = middle;
  }
  noise.rho = low;
  std::vector<double> ratios;
  for (const Line& line : lines) ratios.push_back(variance_ratio(line, 1.0, noise.rho));
  noise.variance_ratio = stats::median(ratios);
  return noise;
}

/// Places of the two points in units of the spread (eq. 4.2); their product is -1.
Eigen::Array2d nodes_of(const Line& line) {
  const double middle = 0.5 * line.skewness, reach = std::hypot(1.0, middle);
  return {middle - reach, middle + reach};
}

/// The two points with independent errors of the line's offset and of its slope times the spread.
void set_points(const Line& line, double offset_variance, double turn_variance, EdgeLine& edge) {
  const Eigen::Array2d nodes = nodes_of(line);
  for (int i = 0; i < 2; ++i) edge.points[i] = line.centroid + nodes[i] * line.spread * line.along;
  edge.variance = offset_variance + turn_variance * nodes.square();
  edge.covariance = offset_variance - turn_variance;
}

/// Variances of the two points (eq. 4.5): what scatters along the row averages out; what is claimed beyond
/// the scatter is common to the row and does not.
void set_variances(const Line& line, const Noise& noise, EdgeLine& edge) {
  const Inflation inflation = inflation_of(line.places, noise.rho);
  const double ratio = variance_ratio(line, noise.variance_ratio, noise.rho);
  const double scatter = ratio / line.weight_sum;
  const double common = std::max(0.0, 1.0 - ratio) * line.mean_sigma2;
  set_points(line, scatter * inflation.offset, scatter * inflation.slope, edge);
  edge.variance.array() += common;
}

/// An edge against the ground, or, where that was not seen, the top's against leaves.
void keep_better(Samples ground, Samples top, std::vector<Samples>& all) {
  constexpr std::size_t kFew = 10;
  if (ground.points.size() < kFew && top.points.size() >= 2) ground = std::move(top);
  if (ground.points.size() >= 2) all.push_back(std::move(ground));
}

std::vector<Samples> collect(const RowsOnUnitPlane& rows) {
  std::vector<Samples> all;
  for (const RowsOnUnitPlane::Row& row : rows.rows) {
    Samples left{row.index, Side::left, {}, {}}, right{row.index, Side::right, {}, {}};
    Samples top_left = left, top_right = right;
    top_left.common = top_right.common = true;
    Samples centre{row.index, Side::centre, {}, {}};
    for (const RowDirection& d : row.directions) {
      centre.add(d.centre, d.sigma);
      if (d.left) left.add(*d.left, d.edge_sigma);
      if (d.right) right.add(*d.right, d.edge_sigma);
      if (d.top_left) top_left.add(*d.top_left, d.top_sigma);
      if (d.top_right) top_right.add(*d.top_right, d.top_sigma);
    }
    const std::size_t before = all.size();
    keep_better(std::move(left), std::move(top_left), all);
    keep_better(std::move(right), std::move(top_right), all);
    if (all.size() == before) all.push_back(std::move(centre));
  }
  return all;
}

}  // namespace

std::vector<EdgeLine> reduce_to_lines(const RowsOnUnitPlane& rows) {
  std::vector<EdgeLine> result, tops;
  std::vector<Line> lines;
  for (const Samples& samples : collect(rows)) {
    auto line = fit_line(samples);
    if (!line) continue;
    EdgeLine edge;
    edge.row = samples.row;
    edge.side = samples.side;
    edge.samples = static_cast<int>(samples.points.size());
    if (samples.common) {
      set_points(*line, line->mean_sigma2, kFreeTurn * line->mean_sigma2, edge);
      tops.push_back(edge);
    } else {
      result.push_back(edge);
      lines.push_back(std::move(*line));
    }
  }
  const Noise noise = pooled_noise(lines);
  for (std::size_t i = 0; i < lines.size(); ++i) set_variances(lines[i], noise, result[i]);
  result.insert(result.end(), tops.begin(), tops.end());
  return result;
}

}  // namespace furrow::altitude
