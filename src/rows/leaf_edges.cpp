#include "rows/leaf_edges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "furrow/stats/estimate.h"
#include "furrow/stats/robust.h"

namespace furrow::rows {
namespace {

constexpr int kBlocks = 8;               // independent parts of a picture, for the sigma of a place
constexpr double kReach = 4.5;           // row numbers to each side that are looked at
constexpr double kBin = 0.02;            // row numbers
constexpr int kBins = 450;               // 2 kReach / kBin
constexpr int kArm = 6;                  // bins of light compared on each side of an edge
constexpr double kLeastScale = 0.10;     // farther off a spacing has too few pixels
constexpr double kMeetingSigmaPx = 2.0;  // how well edges of leaves tell where rows meet
constexpr int kRows = 3;                 // beside the followed one; beyond, a row's top is a few pixels
/// Log light of all that is not leaf, against the typical leaf: darker than any, so that ground beyond a top
/// counts as its end like a wall in shade.
constexpr float kGround = -0.7F;

/// Light by real-valued row number, for each block of picture rows: sums and counts. Lines parallel to the
/// rows keep their number in any perspective, whatever their height.
struct LightByRow {
  std::array<std::array<float, kBins>, kBlocks> sum{}, count{};
};

/// The field with a tilted horizon: row number k lies at u = u_vp + (v - v_vp) m / (1 + tilt m).
struct Fan {
  Eigen::Vector2d point;
  double per_row = 1.0, zero = 0.0, tilt = 0.0;

  double u_at(double v, double k) const {
    const double m = zero + k * per_row;
    return point.x() + (v - point.y()) * m / (1.0 + tilt * m);
  }
};

std::optional<Fan> fan_of(const PlanarField& field, double tilt) {
  const auto point = field.vanishing_point();
  if (!point) return std::nullopt;
  const double steepness = field.convergence / field.length;
  return Fan{*point, field.spacing * steepness, field.offset * steepness + field.slope / field.length, tilt};
}

float upper_tenth(std::vector<float>& values) {
  const auto top = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), top, values.end());
  return *top;
}

/// Log light of pixels that are green, against the median of all that are; kGround for the rest.
class LeafLight {
 public:
  explicit LeafLight(const GreenMap& map) : map_(map) {
    constexpr std::size_t kSparse = 97;  // one pixel of so many is enough for a quantile
    std::vector<float> greens;
    for (std::size_t i = 0; i < map.value.size(); i += kSparse) greens.push_back(map.value[i]);
    full_ = upper_tenth(greens);
    for (std::size_t light = 0; light < light_.size(); ++light)
      light_[light] = std::log(static_cast<float>(light) + kDarkLevel);
    std::vector<double> lights;
    for (std::size_t i = 0; i < map.value.size(); i += kSparse)
      if (map.value[i] > kLeastGreen * full_) lights.push_back(static_cast<double>(light_[map.light[i]]));
    const float typical = lights.empty() ? 0.0F : static_cast<float>(stats::median(lights));
    for (float& light : light_) light = std::clamp(light - typical, kGround, -kGround);
  }

  /// Running sum of a row: sums[u] is the sum over [0, u), and once more the last, so that places between
  /// need no test.
  void sum_row(int row, std::vector<float>& sums) const {
    const auto width = static_cast<std::size_t>(map_.width);
    const float* green = map_.row(row);
    const std::uint16_t* light = map_.light.data() + static_cast<std::size_t>(row) * width;
    sums.resize(width + 2);
    float sum = sums[0] = 0.0F;
    const float per_full = full_ > 0.0F ? 1.0F / (full_ * (kFullGreen - kLeastGreen)) : 0.0F;
    const float least = kLeastGreen * full_ * per_full;
    for (std::size_t u = 0; u < width; ++u) {
      const float leaf = std::min(std::max(green[u] * per_full - least, 0.0F), 1.0F);
      sums[u + 1] = sum += kGround + leaf * (light_[light[u]] - kGround);
    }
    sums[width + 1] = sum;
  }

 private:
  // Part of the greenest pixels' greenness below which nothing is a leaf of the crop, and above which all is:
  // grass has about half.
  static constexpr float kLeastGreen = 0.5F, kFullGreen = 0.85F;
  const GreenMap& map_;
  float full_ = 1.0F;
  std::array<float, 3 * 255 + 1> light_;  // of each R + G + B
};

LightByRow light_by_row(const GreenMap& map, const PlanarField& field, const Fan& fan) {
  LightByRow light;
  const LeafLight leaves(map);
  const int strip = std::max(1, map.height / 45);
  std::vector<float> sums;
  std::array<float, kBins + 1> aside;  // du / dv of each bin's border
  for (int i = 0; i <= kBins; ++i)
    aside[static_cast<std::size_t>(i)] =
        static_cast<float>(fan.u_at(fan.point.y() + 1.0, i * kBin - kReach) - fan.point.x());
  for (int row = 0; row < map.height; ++row) {
    const double v = map.v_in_picture(row);
    if (field.scale(v) < kLeastScale) continue;
    leaves.sum_row(row, sums);
    const auto block = static_cast<std::size_t>((row / strip) % kBlocks);
    const float first = static_cast<float>((fan.point.x() + 0.5) / map.scale_u);
    const float per_aside = static_cast<float>((v - fan.point.y()) / map.scale_u);
    const float end = static_cast<float>(map.width);
    float before = -1.0F, sum_before = 0.0F;
    for (std::size_t i = 0; i <= kBins; ++i) {
      const float border = first + per_aside * aside[i];
      if (!(border >= 0.0F && border <= end)) {
        before = -1.0F;
        continue;
      }
      const auto pixel = static_cast<std::size_t>(static_cast<int>(border));
      const float sum = sums[pixel] + (border - static_cast<float>(pixel)) * (sums[pixel + 1] - sums[pixel]);
      // Each picture row has one vote in a bin: its mean.
      if (before >= 0.0F && border > before) {
        light.sum[block][i - 1] += (sum - sum_before) / (border - before);
        light.count[block][i - 1] += 1.0F;
      }
      before = border, sum_before = sum;
    }
  }
  return light;
}

/// How much the light drops at each bin's outer border, away from the followed row on the given side.
using Drop = std::array<float, kBins>;

struct MeanLight {
  std::array<float, kBins> mean{};
  std::array<bool, kBins> there{};
};

/// Without block `left_out` (-1: with all).
MeanLight mean_light(const LightByRow& light, int left_out) {
  MeanLight result;
  for (std::size_t i = 0; i < kBins; ++i) {
    float sum = 0.0F, count = 0.0F;
    for (int b = 0; b < kBlocks; ++b) {
      if (b == left_out) continue;
      sum += light.sum[static_cast<std::size_t>(b)][i], count += light.count[static_cast<std::size_t>(b)][i];
    }
    result.there[i] = count > 0.0F;
    result.mean[i] = count > 0.0F ? sum / count : 0.0F;
  }
  return result;
}

Drop drop_of(const MeanLight& light, int direction) {
  Drop drop{};
  for (int i = kArm; i + kArm < kBins; ++i) {
    float inner = 0.0F, outer = 0.0F;
    int n = 0;
    for (int j = 0; j < kArm; ++j) {
      const auto in = static_cast<std::size_t>(direction > 0 ? i - j : i + 1 + j);
      const auto out = static_cast<std::size_t>(direction > 0 ? i + 1 + j : i - j);
      inner += light.mean[in], outer += light.mean[out], n += light.there[in] + light.there[out];
    }
    if (n == 2 * kArm) drop[static_cast<std::size_t>(i)] = (inner - outer) / kArm;
  }
  return drop;
}

/// Row number at the outer border of bin i.
double place_of(double bin) {
  return (bin + 1.0) * kBin - kReach;
}
double bin_at(double place) {
  return (place + kReach) / kBin - 1.0;
}

float value_at(const Drop& drop, double place) {
  const int i = static_cast<int>(std::lround(bin_at(place)));
  return i >= 0 && i < kBins ? drop[static_cast<std::size_t>(i)] : 0.0F;
}

/// Where the drop is largest within `reach` of a place, sub-bin by a parabola; nothing where it does not
/// drop.
std::optional<double> peak_near(const Drop& drop, double place, double reach) {
  const int from = std::max(1, static_cast<int>(std::ceil(bin_at(place - reach))));
  const int to = std::min(kBins - 2, static_cast<int>(std::floor(bin_at(place + reach))));
  int best = -1;
  for (int i = from; i <= to; ++i) {
    if (drop[static_cast<std::size_t>(i)] > (best < 0 ? 0.0F : drop[static_cast<std::size_t>(best)]))
      best = i;
  }
  if (best < 0) return std::nullopt;
  const auto i = static_cast<std::size_t>(best);
  const double a = static_cast<double>(drop[i - 1]), b = static_cast<double>(drop[i]),
               c = static_cast<double>(drop[i + 1]);
  const double bow = a - 2.0 * b + c;
  return place_of(best + (bow < 0.0 ? std::clamp(0.5 * (a - c) / bow, -0.5, 0.5) : 0.0));
}

struct Side : MeanLight {
  int direction = 1;
  Drop all{};
  std::array<Drop, kBlocks> without{};

  Side(const MeanLight& light, const std::array<MeanLight, kBlocks>& light_without, int towards)
      : MeanLight(light), direction(towards), all(drop_of(light, towards)) {
    for (std::size_t b = 0; b < kBlocks; ++b) without[b] = drop_of(light_without[b], towards);
  }
  /// Standard error of the drop at a place, by leaving out each block (Tukey's jackknife).
  float sigma_at(double place) const {
    float middle = 0.0F, squares = 0.0F;
    for (const Drop& one : without) middle += value_at(one, place) / kBlocks;
    for (const Drop& one : without)
      squares += (value_at(one, place) - middle) * (value_at(one, place) - middle);
    return std::sqrt(squares * (kBlocks - 1) / kBlocks);
  }
};

/// Where edges against the ground lie, in row numbers: the followed row's, and the near edges of the rows
/// beside it.
struct GroundEdges {
  double middle = 0.0, half_width = 0.0;
  double near_left = 0.0, near_right = 0.0;  ///< distances of the neighbours' near edges from the middle

  double near() const { return 0.5 * (near_left + near_right); }
};

std::optional<double> median_place(const RowLine& row, const CommonModel& model, double RowSample::*edge) {
  constexpr std::size_t kLeast = 8;  // samples
  std::vector<double> places;
  for (const RowSample& sample : row.samples) {
    const Cut cut = model.at(sample.centre_px.y());
    if (std::isfinite(sample.*edge)) places.push_back((sample.*edge - cut.centre) / cut.spacing);
  }
  return places.size() >= kLeast ? std::optional(stats::median(places)) : std::nullopt;
}

std::optional<GroundEdges> ground_edges(const std::vector<RowLine>& rows, const CommonModel& model) {
  std::optional<double> left, right, near_left, near_right;
  for (const RowLine& row : rows) {
    if (row.index == 0) {
      left = median_place(row, model, &RowSample::left_u_px);
      right = median_place(row, model, &RowSample::right_u_px);
    }
    if (row.index == -1) near_left = median_place(row, model, &RowSample::right_u_px);
    if (row.index == 1) near_right = median_place(row, model, &RowSample::left_u_px);
  }
  if (!left || !right || !(near_left || near_right)) return std::nullopt;
  GroundEdges edges;
  edges.middle = 0.5 * (*left + *right);
  edges.half_width = 0.5 * (*right - *left);
  edges.near_left = near_left ? edges.middle - *near_left : *near_right - edges.middle;
  edges.near_right = near_right ? *near_right - edges.middle : edges.near_left;
  if (!(edges.half_width > 0.0 && edges.near() > edges.half_width)) return std::nullopt;
  return edges;
}

/// Drop over its standard error, limited softly, so that one sharp edge does not outweigh a comb of three.
double evidence(const Side& side, double place) {
  constexpr double kLeastSigma = 0.01, kSoft = 6.0;
  const double drop = static_cast<double>(value_at(side.all, place));
  if (drop <= 0.0) return 0.0;
  const double z = drop / std::hypot(static_cast<double>(side.sigma_at(place)), kLeastSigma);
  return z / (1.0 + z / kSoft);
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
Trendless without_trend(const Side& side, const GroundEdges& ground, const Relevelled& place, int stride) {
  Trendless light;
  double away_sum = 0.0, sum = 0.0, squares = 0.0, slope = 0.0;
  for (int i = 0; i < kBins; i += stride) {
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

/// A comb of tops: spacing in row numbers, and how much of the light's squares it explains.
struct Comb {
  double spacing = 0.0, squares = 0.0, total = 0.0;

  double part() const { return total > 0.0 ? squares / total : 0.0; }
};

/// The comb that explains most, under a tilt of the rows' plane that the fan does not count with. A
/// neighbour's near edge, at the top or at the foot of a wall, lies at least a width before the top's far
/// edge; and at least as far as the foot of a wall a little deeper than the camera is high.
Comb best_comb(const std::array<Side, 2>& sides, const GroundEdges& level, const Relevelled& place,
               int stride) {
  const double step = 0.01 * stride;
  constexpr double kDeepestWall = 1.3, kMostStretch = 2.2;
  const GroundEdges ground = relevelled(level, place);
  const double from = ground.near() + 0.8 * ground.half_width;
  const double to = std::min((1.0 + kDeepestWall) * ground.near() + ground.half_width, kMostStretch);
  const std::array light = {without_trend(sides[0], ground, place, stride),
                            without_trend(sides[1], ground, place, stride)};
  Comb best;
  best.total = light[0].total + light[1].total;
  for (double s = from; s <= to; s += step) {
    const double squares = explained(light[0], ground, s) + explained(light[1], ground, s);
    if (squares > best.squares) best.squares = squares, best.spacing = s;
  }
  return best;
}

/// FoundTops::tilt.
double tilt_of_tops(const std::array<Side, 2>& sides, const GroundEdges& ground, const Fan& fan) {
  // One sigma: rows along a slope stand on up to 10 % without terraces, and steeper ones are left to others.
  constexpr double kTiltSigma = 0.1, kMostTilt = 0.16, kStep = 0.02;
  constexpr double kIndependent = 30.0;  // pieces of light, of a quarter of a row number
  constexpr double kLeastGain = 3.0;     // of log likelihood: twenty to one
  constexpr int kStride = 2;             // bins: a step of tilt moves outer rows by more
  constexpr int kSteps = static_cast<int>(kMostTilt / kStep + 0.5);
  const auto comb_at = [&](double tilt) {
    return best_comb(sides, ground, Relevelled(fan, ground.middle, tilt), kStride);
  };
  const double total = comb_at(0.0).total;
  if (!(total > 0.0)) return 0.0;
  std::array<double, 2 * kSteps + 1> scores{};
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const double tilt = (static_cast<int>(i) - kSteps) * kStep;
    const double left = std::max(1.0 - comb_at(tilt).squares / total, 0.05);
    scores[i] = -0.5 * kIndependent * std::log(left) - 0.5 * tilt * tilt / (kTiltSigma * kTiltSigma);
  }
  const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  if (!(scores[best] - scores[kSteps] > kLeastGain)) return 0.0;
  double steps = static_cast<double>(best) - kSteps;
  if (best > 0 && best + 1 < scores.size()) {
    const double bow = scores[best - 1] - 2.0 * scores[best] + scores[best + 1];
    if (bow < 0.0) steps += std::clamp(0.5 * (scores[best - 1] - scores[best + 1]) / bow, -0.5, 0.5);
  }
  return steps * kStep;
}

std::array<Side, 2> sides_of(const LightByRow& light) {
  const MeanLight mean = mean_light(light, -1);
  std::array<MeanLight, kBlocks> without;
  for (int b = 0; b < kBlocks; ++b) without[static_cast<std::size_t>(b)] = mean_light(light, b);
  return {Side(mean, without, -1), Side(mean, without, 1)};
}

std::optional<Estimate> edge_near(const Side& side, double place, double reach) {
  constexpr double kLeastEvidence = 2.4;  // a drop of four sigmas
  constexpr double kFinest = 0.01;        // row numbers: a leaf
  const auto peak = peak_near(side.all, place, reach);
  if (!peak || evidence(side, *peak) < kLeastEvidence) return std::nullopt;
  double mean = 0.0, squares = 0.0;
  std::array<double, kBlocks> places{};
  for (std::size_t b = 0; b < kBlocks; ++b) {
    places[b] = peak_near(side.without[b], place, reach).value_or(place);
    mean += places[b] / kBlocks;
  }
  for (const double one : places) squares += (one - mean) * (one - mean);
  const double sigma = std::sqrt(squares * (kBlocks - 1) / kBlocks);
  if (sigma > 0.5 * reach) return std::nullopt;
  return Estimate{*peak, std::hypot(sigma, kFinest), kBlocks};
}

/// The far edges near their places in a comb of that spacing.
TopComb comb_of(const std::array<Side, 2>& sides, const GroundEdges& ground, double spacing) {
  TopComb comb;
  comb.middle = ground.middle;
  comb.spacing = spacing;
  for (const Side& side : sides) {
    for (int k = 1; k <= kRows; ++k) {
      const double place = ground.middle + side.direction * (k * spacing + ground.half_width);
      const double reach = std::min(0.8 * ground.half_width, 0.2 * spacing);
      if (const auto edge = edge_near(side, place, reach)) comb.edges.push_back({side.direction * k, *edge});
    }
  }
  return comb;
}

}  // namespace

FoundTops find_tops(const GreenMap& map, const CommonModel& model, double tilt,
                    const std::vector<RowLine>& rows) {
  FoundTops found;
  if (map.light.empty()) return found;
  const auto fan = fan_of(model.field(), tilt);
  const auto ground = ground_edges(rows, model);
  if (!fan || !ground) return found;
  const LightByRow light = light_by_row(map, model.field(), *fan);
  const std::array sides = sides_of(light);
  constexpr double kLeastExplained = 0.2;
  const Comb level = best_comb(sides, *ground, Relevelled(*fan, ground->middle, 0.0), 1);
  found.explained = level.part();
  found.tilt = tilt_of_tops(sides, *ground, *fan);
  if (found.explained > kLeastExplained) found.comb = comb_of(sides, *ground, level.spacing);
  return found;
}

void write_tops(const TopComb& comb, const PlanarField& field, double tilt, std::vector<RowLine>& rows) {
  const auto fan = fan_of(field, tilt);
  if (!fan) return;
  for (const TopEdge& edge : comb.edges) {
    for (RowLine& row : rows) {
      if (row.index != edge.row) continue;
      const auto top = edge.row < 0 ? &RowSample::top_left_u_px : &RowSample::top_right_u_px;
      for (RowSample& sample : row.samples) {
        const double v = sample.centre_px.y();
        if (field.scale(v) < kLeastScale) continue;
        const double place = (edge.place.value - comb.middle) / comb.spacing;
        sample.*top = fan->u_at(v, place);
        sample.top_sigma_px =
            std::hypot(edge.place.sigma / comb.spacing * field.spacing_at(v), kMeetingSigmaPx);
      }
    }
  }
}

}  // namespace furrow::rows
