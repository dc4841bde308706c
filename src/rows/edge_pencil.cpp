#include "rows/edge_pencil.h"

#include <algorithm>
#include <cmath>
#include <Eigen/LU>

#include "furrow/stats/robust.h"

namespace furrow::rows {
namespace {

/// Leaves are larger than the step between samples: about so many of them are one observation.
constexpr double kSamplesPerLeaf = 3.0;
/// Finest sigma of a line at the meeting point, px: rows are not straighter than that.
constexpr double kStraightPx = 1.0;
/// Misfit in sigmas at which an edge loses half its pull: wrong edges lie tens of sigmas off.
constexpr double kCauchySigmas = 2.0;

/// An edge of one row as the straight line u = u + slope (v - v_mean).
struct PictureLine {
  int row = 0;
  double u = 0.0, v = 0.0, slope = 0.0;
  double offset_variance = 0.0, slope_variance = 0.0;

  double u_at(double at) const { return u + slope * (at - v); }
  double variance_at(double at) const {
    return offset_variance + slope_variance * (at - v) * (at - v) + kStraightPx * kStraightPx;
  }
};

struct EdgePoint {
  double u = 0.0, v = 0.0, sigma = 1.0;
};

/// Weighted straight line, twice, the second time without what lies off by 2.5 of the scatter that is seen.
std::optional<PictureLine> line_through(std::vector<EdgePoint> points) {
  constexpr std::size_t kLeast = 6;
  PictureLine line;
  for (int pass = 0; pass < 3; ++pass) {
    if (points.size() < kLeast) return std::nullopt;
    double sum = 0.0, u = 0.0, v = 0.0, vv = 0.0, uv = 0.0;
    for (const EdgePoint& p : points) sum += 1.0 / (p.sigma * p.sigma);
    for (const EdgePoint& p : points)
      u += p.u / (p.sigma * p.sigma * sum), v += p.v / (p.sigma * p.sigma * sum);
    for (const EdgePoint& p : points) {
      const double weight = 1.0 / (p.sigma * p.sigma);
      vv += weight * (p.v - v) * (p.v - v);
      uv += weight * (p.v - v) * (p.u - u);
    }
    if (!(vv > 0.0)) return std::nullopt;
    line = {0, u, v, uv / vv, 0.0, 0.0};
    std::vector<double> scores;
    double squares = 0.0;
    for (const EdgePoint& p : points) scores.push_back((p.u - line.u_at(p.v)) / p.sigma);
    for (const double score : scores) squares += score * score;
    const double scatter2 = squares / static_cast<double>(points.size() - 2);
    line.offset_variance = kSamplesPerLeaf * scatter2 / sum;
    line.slope_variance = kSamplesPerLeaf * scatter2 / vv;
    const double limit = 2.5 * std::max(stats::mad_sigma(scores), 1e-9);
    std::erase_if(points,
                  [&](const EdgePoint& p) { return std::abs(p.u - line.u_at(p.v)) > limit * p.sigma; });
  }
  return line;
}

std::vector<PictureLine> picture_lines(const std::vector<RowLine>& rows) {
  std::vector<PictureLine> lines;
  for (const RowLine& row : rows) {
    for (const auto side : {&RowSample::left_u_px, &RowSample::right_u_px}) {
      std::vector<EdgePoint> points;
      for (const RowSample& sample : row.samples) {
        if (std::isfinite(sample.*side) && sample.edge_sigma_px > 0.0)
          points.push_back({sample.*side, sample.centre_px.y(), sample.edge_sigma_px});
      }
      auto line = line_through(std::move(points));
      if (!line) continue;
      line->row = row.index;
      lines.push_back(*line);
    }
  }
  return lines;
}

bool differ_in_row(const std::vector<PictureLine>& lines) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const PictureLine& line) { return line.row != lines.front().row; });
}

}  // namespace

std::optional<Eigen::Vector2d> meeting_point(const std::vector<RowLine>& rows, const Priors& priors,
                                             double u_middle) {
  if (!priors.horizon_v_px || !(priors.horizon_sigma_px > 0.0)) return std::nullopt;
  const std::vector<PictureLine> lines = picture_lines(rows);
  if (lines.size() < 2 || !differ_in_row(lines)) return std::nullopt;
  const double tilt = priors.horizon_slope.value_or(0.0);
  const auto horizon = [&](double u) { return *priors.horizon_v_px + tilt * (u - u_middle); };
  std::vector<double> starts;
  for (const PictureLine& line : lines) starts.push_back(line.u_at(*priors.horizon_v_px));
  Eigen::Vector2d point(stats::median(starts), *priors.horizon_v_px);
  constexpr int kPasses = 15, kFreePasses = 7;
  constexpr double kFree = 5.0;  // of the horizon's sigma, while the edges look for each other
  for (int pass = 0; pass < kPasses; ++pass) {
    const double sigma = priors.horizon_sigma_px * (pass < kFreePasses ? kFree : 1.0), sigma2 = sigma * sigma;
    const Eigen::Vector2d across(-tilt, 1.0);
    Eigen::Matrix2d normal = across * across.transpose() / sigma2;
    Eigen::Vector2d right = across * (horizon(0.0)) / sigma2;
    for (const PictureLine& line : lines) {
      const double variance = line.variance_at(point.y());
      const double off = point.x() - line.u_at(point.y());
      const double weight = 1.0 / (variance + off * off / (kCauchySigmas * kCauchySigmas));
      // u - slope v = u_line - slope v_line.
      const Eigen::Vector2d along(1.0, -line.slope);
      normal += weight * along * along.transpose();
      right += weight * (line.u - line.slope * line.v) * along;
    }
    point = normal.inverse() * right;
    if (!point.allFinite()) return std::nullopt;
  }
  constexpr double kMostSigmas = 3.0;
  const bool denied = std::abs(point.y() - horizon(point.x())) > kMostSigmas * priors.horizon_sigma_px;
  return denied ? std::nullopt : std::optional(point);
}

PlanarField field_through(const PlanarField& field, const Eigen::Vector2d& point, double v, double row_zero_u,
                          double spacing) {
  PlanarField straight = field;
  straight.convergence = field.length / (field.v0 - point.y());
  straight.slope = (field.u0 - point.x()) * straight.convergence;
  straight.bend = straight.bend2 = 0.0;
  const double scale = straight.scale(v);
  straight.spacing = spacing / scale;
  straight.offset = (row_zero_u - field.u0 - straight.t(v) * straight.slope) / scale;
  return straight;
}

std::optional<PlanarField> relevelled(const PlanarField& field, double tilt, double u_middle) {
  constexpr double kLeastOver = 0.1;
  const auto point = field.vanishing_point();
  if (!point) return std::nullopt;
  // A row leans by du/dv = m, and by m / (1 - tilt m) once its picture is sheared; dm of the spacing grows by
  // the derivative.
  const double steepness = field.convergence / field.length;
  const double lean = field.offset * steepness + field.slope / field.length, over = 1.0 - tilt * lean;
  if (over < kLeastOver) return std::nullopt;
  const Eigen::Vector2d level(point->x(), point->y() - tilt * (point->x() - u_middle));
  return field_through(field, level, level.y() + field.length, level.x() + field.length * lean / over,
                       field.length * steepness * field.spacing / (over * over));
}

}  // namespace furrow::rows
