#include "rows/top_spacing.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Cholesky>

#include "furrow/stats/robust.h"

namespace furrow::rows {
namespace {

std::optional<double> median_place(const RowLine& row, const CommonModel& model, double RowSample::*edge) {
  constexpr std::size_t kLeast = 8;  // samples
  std::vector<double> places;
  for (const RowSample& sample : row.samples) {
    const Cut cut = model.at(sample.centre_px.y());
    if (std::isfinite(sample.*edge)) places.push_back((sample.*edge - cut.centre) / cut.spacing);
  }
  return places.size() >= kLeast ? std::optional(stats::median(places)) : std::nullopt;
}

/// The light on one side by its distance from the followed row, and what a straight trend leaves of it.
struct Trendless {
  std::vector<double> away, trend;  ///< row numbers; the same centred, with squares that sum up to 1
  std::vector<double> rest;         ///< of the light
  double total = 0.0;               ///< sum of the rest's squares
};

/// Row numbers where the rows' plane is tilted by `tilt` more than the fan counts with: lines through the
/// vanishing point that lean by m lean by m / (1 - tilt m) once that is levelled. Middle and spacing of the
/// followed row stay.
class Relevelled {
 public:
  Relevelled(const Fan& fan, double middle, double tilt)
      : lean_(fan.zero + middle * fan.per_row), per_row_(fan.per_row), middle_(middle), tilt_(tilt) {}

  /// Nothing on and beyond the tilted plane's horizon.
  std::optional<double> operator()(double place) const {
    constexpr double kLeastOver = 0.1;
    const double off = place - middle_;
    const double over = 1.0 - tilt_ * (lean_ + off * per_row_), over_middle = 1.0 - tilt_ * lean_;
    if (over < kLeastOver || over_middle < kLeastOver) return std::nullopt;
    return middle_ + off * over_middle / over;
  }

 private:
  double lean_, per_row_, middle_, tilt_;
};

GroundEdges relevelled(const GroundEdges& ground, const Relevelled& place) {
  GroundEdges edges = ground;
  if (const auto left = place(ground.middle - ground.near_left)) edges.near_left = ground.middle - *left;
  if (const auto right = place(ground.middle + ground.near_right)) edges.near_right = *right - ground.middle;
  return edges;
}

/// What lies beyond the neighbour's near edge; every `stride`-th bin.
Trendless without_trend(const LightSide& side, const GroundEdges& ground, const Relevelled& place,
                        int stride) {
  Trendless light;
  double away_sum = 0.0, sum = 0.0, squares = 0.0, slope = 0.0;
  for (int i = 0; i < kLightBins; i += stride) {
    const double bin = place_of(i - 0.5);
    if (!side.there[static_cast<std::size_t>(i)] || side.direction * (bin - ground.middle) <= 0.0) continue;
    const double away = side.direction * (place(bin).value_or(ground.middle) - ground.middle);
    if (away < ground.near() + 0.05) continue;
    light.away.push_back(away);
    light.rest.push_back(static_cast<double>(side.mean[static_cast<std::size_t>(i)]));
    away_sum += away, sum += light.rest.back();
  }
  const double count = static_cast<double>(light.away.size());
  for (const double away : light.away) light.trend.push_back(away - away_sum / count);
  for (const double t : light.trend) squares += t * t;
  if (!(squares > 0.0)) return {};
  for (std::size_t i = 0; i < light.trend.size(); ++i) {
    light.trend[i] /= std::sqrt(squares);
    slope += light.trend[i] * light.rest[i];
  }
  for (std::size_t i = 0; i < light.trend.size(); ++i) {
    light.rest[i] -= sum / count + slope * light.trend[i];
    light.total += light.rest[i] * light.rest[i];
  }
  return light;
}

/// How much of the rest's squares a comb of that spacing explains. From one far edge to the next the light
/// runs so: dark at the foot of the wall, lighter up to the near edge of the top, level over the top.
double explained(const Trendless& light, const GroundEdges& ground, double spacing) {
  const double per_wall = 1.0 / (1.0 - 2.0 * ground.half_width / spacing);
  double sum = 0.0, squares = 0.0, trend = 0.0, common = 0.0;
  for (std::size_t i = 0; i < light.away.size(); ++i) {
    const double periods = (light.away[i] - ground.half_width) * (1.0 / spacing);
    const double saw = std::min(1.0, (periods - static_cast<int>(periods)) * per_wall);
    sum += saw, squares += saw * saw, trend += saw * light.trend[i], common += saw * light.rest[i];
  }
  const double own = squares - sum * sum / static_cast<double>(light.away.size()) - trend * trend;
  return common > 0.0 && own > 0.0 ? common * common / own : 0.0;
}

/// A saw of tops: spacing in row numbers, and how much of the light's squares it explains.
struct Saw {
  double spacing = 0.0, squares = 0.0, total = 0.0;

  double part() const { return total > 0.0 ? squares / total : 0.0; }
};

/// Sums over the bins of one face of the rows: of 1, t (the trend), x (the place on the face, -1/2 to 1/2)
/// and r (the light's rest), and of their products.
struct FaceSums {
  double count = 0.0, t = 0.0, x = 0.0, r = 0.0, tt = 0.0, tx = 0.0, tr = 0.0, xx = 0.0, xr = 0.0;

  void add(double trend, double place, double rest) {
    count += 1.0, t += trend, x += place, r += rest;
    tt += trend * trend, tx += trend * place, tr += trend * rest, xx += place * place, xr += place * rest;
  }
};

struct FaceLight {
  double squares = 0.0;  ///< of the rest's that the faces explain
  double drop = 0.0;     ///< of the light at the tops' far edges; 0 where they are not seen
};

/// How much of the rest's squares walls and tops of any light explain, each with a slope of its own from side
/// to side, as surfaces without leaves have them: the sun may stand on either side.
FaceLight faces(const Trendless& light, const GroundEdges& ground, double spacing) {
  const double wall_part = 1.0 - 2.0 * ground.half_width / spacing;
  FaceSums wall, top;
  for (std::size_t i = 0; i < light.away.size(); ++i) {
    const double periods = (light.away[i] - ground.half_width) * (1.0 / spacing);
    const double phase = periods - static_cast<int>(periods);
    if (phase < wall_part) {
      wall.add(light.trend[i], phase / wall_part - 0.5, light.rest[i]);
    } else {
      top.add(light.trend[i], (phase - wall_part) / (1.0 - wall_part) - 0.5, light.rest[i]);
    }
  }
  // Unknowns: light of walls, of tops over walls, the trend, slopes of walls and tops.
  Eigen::Matrix<double, 5, 5> normal = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 1> right;
  normal.row(0) << wall.count + top.count, top.count, wall.t + top.t, wall.x, top.x;
  normal.row(1).tail<4>() << top.count, top.t, 0.0, top.x;
  normal.row(2).tail<3>() << wall.tt + top.tt, wall.tx, top.tx;
  normal(3, 3) = wall.xx, normal(4, 4) = top.xx;
  right << wall.r + top.r, top.r, wall.tr + top.tr, wall.xr, top.xr;
  constexpr double kSteady = 1e-6;  // bins: where no wall or no top is seen
  normal.diagonal().array() += kSteady;
  const Eigen::Matrix<double, 5, 5> full = normal.selfadjointView<Eigen::Upper>();
  const Eigen::Matrix<double, 5, 1> x = full.ldlt().solve(right);
  if (!x.allFinite()) return {};
  constexpr double kLeastBins = 8.0;
  const double drop = std::min(wall.count, top.count) < kLeastBins ? 0.0 : x(1) + 0.5 * x(3) + 0.5 * x(4);
  return {std::clamp(x.dot(right), 0.0, light.total), drop};
}

/// Spacings that tops may have, in row numbers of the model. A neighbour's near edge, at the top or at the
/// foot of a wall, lies at least a width before the top's far edge; and at least as far as the foot of a wall
/// a little deeper than the camera is high. Where the far edge itself shows, it lies half the top's width
/// beyond its axis, less where tops are round.
struct SpacingRange {
  static constexpr double kStep = 0.01;
  double from = 0.0, to = 0.0;

  SpacingRange(const GroundEdges& ground, bool by_far_edge) {
    constexpr double kDeepestWall = 1.3, kMostStretch = 2.2, kMost = 1.1;
    from = ground.near() + 0.8 * ground.half_width;
    to = std::min((1.0 + kDeepestWall) * ground.near() + ground.half_width, kMostStretch);
    if (!by_far_edge || !ground.far) return;
    from = std::max(from, *ground.far - kMost * ground.half_width);
    to = std::min(to, *ground.far);
  }
};

/// The saw that explains most.
Saw best_saw(const std::array<Trendless, 2>& light, const GroundEdges& ground, const SpacingRange& range,
             int stride) {
  Saw best;
  best.total = light[0].total + light[1].total;
  for (double s = range.from; s <= range.to; s += stride * SpacingRange::kStep) {
    const double squares = explained(light[0], ground, s) + explained(light[1], ground, s);
    if (squares > best.squares) best.squares = squares, best.spacing = s;
  }
  return best;
}

/// Walls and tops of any light at some spacing, and the part of the light's squares that they explain.
struct Faces {
  TopLight tops;
  double part = 0.0;
};

/// The spacing at which they explain most.
Faces best_faces(const std::array<Trendless, 2>& light, const GroundEdges& ground,
                 const SpacingRange& range) {
  const double total = light[0].total + light[1].total;
  Faces best;
  for (double s = range.from; s <= range.to && total > 0.0; s += SpacingRange::kStep) {
    const std::array both = {faces(light[0], ground, s), faces(light[1], ground, s)};
    const double part = (both[0].squares + both[1].squares) / total;
    if (part > best.part) best = {{s, {both[0].drop < 0.0, both[1].drop < 0.0}}, part};
  }
  return best;
}

/// Whether the far edges against the ground lie where tops of that spacing end.
bool half_width_before_far_edge(double spacing, const GroundEdges& ground) {
  constexpr double kLeast = 0.5, kMost = 1.25;  // half widths: less where tops are round
  if (!ground.far) return false;
  const double widths = (*ground.far - spacing) / ground.half_width;
  return widths > kLeast && widths < kMost;
}

/// The saw that explains most under a tilt of the rows' plane that the fan does not count with; every
/// `stride`-th bin.
Saw saw_under(const std::array<LightSide, 2>& sides, const GroundEdges& level, const Relevelled& place,
              int stride) {
  const GroundEdges ground = relevelled(level, place);
  return best_saw(
      {without_trend(sides[0], ground, place, stride), without_trend(sides[1], ground, place, stride)},
      ground, SpacingRange(ground, false), stride);
}

}  // namespace

std::optional<GroundEdges> ground_edges(const std::vector<RowLine>& rows, const CommonModel& model) {
  std::optional<double> left, right, near_left, near_right, far_left, far_right;
  for (const RowLine& row : rows) {
    if (row.index == 0) {
      left = median_place(row, model, &RowSample::left_u_px);
      right = median_place(row, model, &RowSample::right_u_px);
    }
    if (row.index == -1) {
      near_left = median_place(row, model, &RowSample::right_u_px);
      far_left = median_place(row, model, &RowSample::left_u_px);
    }
    if (row.index == 1) {
      near_right = median_place(row, model, &RowSample::left_u_px);
      far_right = median_place(row, model, &RowSample::right_u_px);
    }
  }
  if (!left || !right || !(near_left || near_right)) return std::nullopt;
  GroundEdges edges;
  edges.middle = 0.5 * (*left + *right);
  edges.half_width = 0.5 * (*right - *left);
  edges.near_left = near_left ? edges.middle - *near_left : *near_right - edges.middle;
  edges.near_right = near_right ? *near_right - edges.middle : edges.near_left;
  if (far_left && far_right) edges.far = 0.5 * (*far_right - *far_left);
  if (!(edges.half_width > 0.0 && edges.near() > edges.half_width)) return std::nullopt;
  return edges;
}

/// Leaves shade each other towards the foot of a wall: the saw is right where it tells the same spacing with
/// and without the ground, or one that the far edges against the ground bear out. Elsewhere walls and tops of
/// any light are tried, among what is not ground. The saw alone counts only where too little of the leaves is
/// in view for that, or far edges bound it.
TopsByLight tops_by_light(const std::array<LightSide, 2>& sides, const std::array<LightSide, 2>& leaf_sides,
                          const GroundEdges& ground, const Fan& fan) {
  constexpr double kLeastOfAll = 0.2, kLeastOfLeaves = 0.4, kLeastOfFaces = 0.3;
  constexpr double kSame = 0.1, kPeriods = 2.0;
  const Relevelled level(fan, ground.middle, 0.0);
  const std::array all = {without_trend(sides[0], ground, level, 1),
                          without_trend(sides[1], ground, level, 1)};
  const std::array leaves = {without_trend(leaf_sides[0], ground, level, 1),
                             without_trend(leaf_sides[1], ground, level, 1)};
  const SpacingRange wide(ground, false), narrow(ground, true);
  const Saw saw = best_saw(all, ground, wide, 1), leaf_saw = best_saw(leaves, ground, wide, 1);
  TopsByLight found;
  found.by_saw = saw.part();
  const bool agree =
      leaf_saw.part() > kLeastOfLeaves && std::abs(saw.spacing - leaf_saw.spacing) < kSame * saw.spacing;
  if (saw.part() > kLeastOfAll && (agree || half_width_before_far_edge(saw.spacing, ground))) {
    found.tops = TopLight{saw.spacing, {false, false}};
    return found;
  }
  const double seen = kLightBin * static_cast<double>(leaves[0].away.size() + leaves[1].away.size());
  const Faces solid = best_faces(leaves, ground, narrow);
  found.by_faces = solid.part;
  if (solid.part > kLeastOfFaces && (ground.far || seen > kPeriods * solid.tops.spacing)) {
    found.tops = solid.tops;
    return found;
  }
  const Saw other = best_saw(all, ground, narrow, 1);
  if (other.part() > kLeastOfAll && (ground.far || seen < kPeriods * other.spacing))
    found.tops = TopLight{other.spacing, {false, false}};
  return found;
}

TiltByLight tilt_by_light(const std::array<LightSide, 2>& sides, const GroundEdges& ground, const Fan& fan) {
  // One sigma: rows along a slope stand on up to 10 % without terraces, and steeper ones are left to others.
  constexpr double kTiltSigma = 0.1, kMostTilt = 0.16, kStep = 0.02;
  constexpr double kIndependent = 30.0;  // pieces of light, of a quarter of a row number
  constexpr double kLeastGain = 3.0;     // of log likelihood: twenty to one
  constexpr int kStride = 2;             // bins: a step of tilt moves outer rows by more
  constexpr int kSteps = static_cast<int>(kMostTilt / kStep + 0.5);
  const auto tilt_of = [](std::size_t i) { return (static_cast<int>(i) - kSteps) * kStep; };
  std::array<Saw, 2 * kSteps + 1> saws;
  for (std::size_t i = 0; i < saws.size(); ++i)
    saws[i] = saw_under(sides, ground, Relevelled(fan, ground.middle, tilt_of(i)), kStride);
  const double total = saws[kSteps].total;
  if (!(total > 0.0)) return {};
  std::array<double, saws.size()> scores{}, parts{};
  for (std::size_t i = 0; i < saws.size(); ++i) {
    parts[i] = saws[i].squares / total;
    const double left = std::max(1.0 - parts[i], 0.05), tilt = tilt_of(i);
    scores[i] = -0.5 * kIndependent * std::log(left) - 0.5 * tilt * tilt / (kTiltSigma * kTiltSigma);
  }
  const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  if (!(scores[best] - scores[kSteps] > kLeastGain)) return {0.0, parts[kSteps]};
  double steps = static_cast<double>(best) - kSteps;
  if (best > 0 && best + 1 < scores.size()) {
    const double bow = scores[best - 1] - 2.0 * scores[best] + scores[best + 1];
    if (bow < 0.0) steps += std::clamp(0.5 * (scores[best - 1] - scores[best + 1]) / bow, -0.5, 0.5);
  }
  return {steps * kStep, parts[best]};
}

}  // namespace furrow::rows
