#include "rows/row_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "furrow/stats/robust.h"
#include "rows/row_profile.h"

namespace furrow::rows {
namespace {

/// Least contrast of excess green between row and alley: a leaf has 0.2 to 0.6, the noise of soil about 0.02.
constexpr float kLeastContrast = 0.03F;
/// And in parts of the row against the barest ground: leaves of the next row in its shade look less green by
/// less than that.
constexpr float kLeastPart = 0.3F;

/// How far rows stray from the common model, and how well the middle of the green tells a row's middle, both
/// one-sigma in spacings (train pictures of CRBD, development half).
constexpr double kOwnSpread = 0.02, kMiddleSigma = 0.02;

/// Light of the row's core and of the ground beside its edges.
struct Light {
  float row = 0.0F;
  std::array<float, 2> ground = {0.0F, 0.0F};
  int count = 0;
};

struct Levels {
  float row = kNone;
  std::array<float, 2> middle = {
      kNone, kNone};  // half way between row and alley, left and right; NaN: that side is not seen
};

Levels levels_of(const Profile& profile, float barest) {
  // From where rows end, at the narrowest, to past the middle of the alley: the ground may show in a part
  // only, where the wall of the next row stands behind it. And the core of the row, thin rows too.
  constexpr double kAlleyFrom = 0.26, kAlleyTo = 0.78, kAlleyPart = 0.3, kCore = 0.06, kCorePart = 0.5;
  Levels levels;
  const auto row = tail_mean(profile, -kCore, kCore, false, kCorePart);
  if (!row) return levels;
  levels.row = *row;
  const std::array alley = {tail_mean(profile, -kAlleyTo, -kAlleyFrom, true, kAlleyPart),
                            tail_mean(profile, kAlleyFrom, kAlleyTo, true, kAlleyPart)};
  for (std::size_t side = 0; side < 2; ++side) {
    // A side without a visible alley borrows nothing: its edge stays unknown.
    if (!alley[side] ||
        levels.row - *alley[side] < std::max(kLeastContrast, kLeastPart * (levels.row - barest)))
      continue;
    levels.middle[side] = 0.5F * (levels.row + *alley[side]);
  }
  return levels;
}

/// A pixel that leaf and ground share has the chroma of the brighter: with coverage a and r = I_row /
/// I_ground its greenness is not a but a r / (a r + 1 - a). Over one mixed pixel of an edge the mean of the
/// difference is this, in px; so much too narrow is the row there.
double mixing_shift(double r) {
  if (std::abs(r - 1.0) < 1e-3) return 0.0;
  return 0.5 - (r / (r - 1.0) - r * std::log(r) / ((r - 1.0) * (r - 1.0)));
}

/// Px over which an edge is mixed before a pixel's chroma is read: the pixel itself, a lens of about 0.6 px
/// one-sigma and the halved chroma of JPEG, as the box of the same variance: sqrt(12 (1/12 + 0.36 + 4/12)).
constexpr double kMixedPx = 3.0;

constexpr double kFarthest = 0.85;  // spacings from a row's centre: where its edge is looked for
constexpr int kSteps = static_cast<int>(kFarthest / kProfileBinWidth);

/// Bin `i` steps outwards from a row's centre.
float outwards(const Profile& profile, int side, int i) {
  const int half = static_cast<int>(kProfileBins) / 2;
  return profile[static_cast<std::size_t>(side == 0 ? half - 1 - i : half + i)];
}

/// Steps to the far side of the first gap beside a row. From low above, the wall of the next row stands
/// behind a narrow alley; it is green again and not this row.
int gap_end(const Profile& profile, int side, float middle) {
  constexpr int kLeast = 3;  // bins: less is a hole
  int below = 0;
  for (int i = 0; i < kSteps; ++i) {
    const bool is_below = outwards(profile, side, i) < middle;
    if (!is_below && below >= kLeast) return i;
    below = is_below ? below + 1 : 0;
  }
  return kSteps;
}

/// Where to look for an edge: between which levels, and how far out.
struct EdgeSearch {
  float middle = kNone;
  int steps = kSteps;
};

EdgeSearch search_for(const Profile& profile, int side, const Levels& levels) {
  const float middle = levels.middle[static_cast<std::size_t>(side)];
  return {middle, std::isnan(middle) ? 0 : gap_end(profile, side, middle)};
}

/// Distance of an edge from the model's centre, spacings, positive outwards: the most likely place of a step
/// between two known levels is where the running sum of (value - middle level) from the centre outwards is
/// greatest. Sub-bin by the crossing next to it.
std::optional<double> edge_of(const Profile& profile, int side, const EdgeSearch& search) {
  const auto [middle, steps] = search;
  if (std::isnan(middle)) return std::nullopt;
  float sum = 0.0F, best = 0.0F;
  int last_inside = -1;
  for (int i = 0; i < steps; ++i) {
    const float value = outwards(profile, side, i);
    if (std::isnan(value)) return std::nullopt;
    sum += value - middle;
    if (sum > best) best = sum, last_inside = i;
  }
  if (last_inside < 0 || last_inside + 1 >= steps) return std::nullopt;
  const float inside = outwards(profile, side, last_inside),
              outside = outwards(profile, side, last_inside + 1);
  const double part = inside > outside ? static_cast<double>((inside - middle) / (inside - outside)) : 0.5;
  return (last_inside + 0.5 + std::clamp(part, 0.0, 1.0)) * kProfileBinWidth;
}

/// One row's measurements, by sample, in spacings from the model's centre.
struct Measured {
  std::array<std::vector<std::optional<double>>, 2> smooth, own;
  std::array<double, 2> scatter = {0.0, 0.0};  // one-sigma of own against smooth, spacings
};

/// Light at and beside one sample's row, on the map's row nearest to it.
Light sample_light(const GreenMap& map, const Cut& cut, int k, const std::optional<double>& left,
                   const std::optional<double>& right) {
  Light light;
  if (map.light.empty() || !left || !right) return light;
  const int row =
      std::clamp(static_cast<int>(std::lround((cut.v + 0.5) / map.scale_v - 0.5)), 0, map.height - 1);
  const auto at = [&](double x) -> std::optional<float> {
    const double u = (cut.centre + (k + x) * cut.spacing + 0.5) / map.scale_u - 0.5;
    if (u < 0.0 || u > map.width - 1.0) return std::nullopt;
    return static_cast<float>(map.light[static_cast<std::size_t>(row) * static_cast<std::size_t>(map.width) +
                                        static_cast<std::size_t>(std::lround(u))]);
  };
  constexpr std::array kInside = {0.3, 0.5, 0.7};      // of the half width
  constexpr std::array kOutside = {0.04, 0.07, 0.10};  // spacings beyond the edge
  for (std::size_t i = 0; i < kInside.size(); ++i) {
    const auto a = at(-*left * kInside[i]), b = at(*right * kInside[i]);
    const auto c = at(-*left - kOutside[i]), d = at(*right + kOutside[i]);
    if (!a || !b || !c || !d) return {};
    light.row += *a + *b;
    light.ground[0] += 2.0F * *c;
    light.ground[1] += 2.0F * *d;
  }
  light.count = 1;
  return light;
}

Light window_light(const std::vector<Light>& lights, std::size_t at) {
  Light sum;
  const std::size_t from = at > kWindow ? at - kWindow : 0, to = std::min(lights.size(), at + kWindow + 1);
  for (std::size_t j = from; j < to; ++j) {
    sum.row += lights[j].row;
    sum.ground[0] += lights[j].ground[0];
    sum.ground[1] += lights[j].ground[1];
    sum.count += lights[j].count;
  }
  return sum.count > 0 ? sum : Light{};
}

/// Greenness of the barest ground below the horizon: its lowest twentieth.
float barest_ground(const GreenMap& map, const PlanarField& field) {
  constexpr std::size_t kSparse = 37;  // one pixel of so many is enough for a quantile
  std::vector<float> values;
  values.reserve(map.value.size() / kSparse + 1);
  const auto width = static_cast<std::size_t>(map.width);
  for (std::size_t row = 0, i = 0; row < static_cast<std::size_t>(map.height); ++row) {
    const bool is_below = field.scale(map.v_in_picture(static_cast<int>(row))) > 0.1;
    for (; i < (row + 1) * width; i += kSparse)
      if (is_below) values.push_back(map.value[i]);
  }
  if (values.empty()) return 0.0F;
  const auto low = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 20);
  std::nth_element(values.begin(), low, values.end());
  return *low;
}

/// `cuts` are the model's at the row's samples.
Measured measure(const GreenMap& map, const std::vector<Cut>& cuts, int k, const std::vector<Profile>& profiles,
                 float barest) {
  Measured measured;
  const std::vector<Profile> means = window_means(profiles);
  std::vector<Light> lights;
  std::vector<std::array<EdgeSearch, 2>> searches(profiles.size());
  for (std::size_t j = 0; j < profiles.size(); ++j) {
    const Levels levels = levels_of(means[j], barest);
    for (std::size_t side = 0; side < 2; ++side) {
      const int on = static_cast<int>(side);
      searches[j][side] = search_for(means[j], on, levels);
      measured.smooth[side].push_back(edge_of(means[j], on, searches[j][side]));
    }
    lights.push_back(sample_light(map, cuts[j], k, measured.smooth[0][j], measured.smooth[1][j]));
  }
  const double mixed_px = std::hypot(kMixedPx, map.scale_u);
  std::array<std::vector<double>, 2> residuals;
  for (std::size_t j = 0; j < profiles.size(); ++j) {
    const Light light = window_light(lights, j);
    for (std::size_t side = 0; side < 2; ++side) {
      auto& smooth = measured.smooth[side][j];
      auto own = smooth ? edge_of(profiles[j], static_cast<int>(side), searches[j][side]) : std::nullopt;
      if (light.row > 0.0F && light.ground[side] > 0.0F) {
        const double shift = mixing_shift(static_cast<double>(light.row / light.ground[side])) * mixed_px /
                             cuts[j].spacing;
        if (smooth) *smooth += shift;
        if (own) *own += shift;
      }
      measured.own[side].push_back(own);
      if (smooth && own) residuals[side].push_back(*own - *smooth);
    }
  }
  for (std::size_t side = 0; side < 2; ++side) {
    const double sigma = stats::mad_sigma(residuals[side]);
    measured.scatter[side] = std::isfinite(sigma) ? sigma : 0.1;
  }
  return measured;
}

void write_samples(const Measured& measured, const std::vector<Cut>& cuts, double px_floor, RowLine& row) {
  constexpr double kOutlierSigmas = 3.5;
  int edges = 0;
  for (std::size_t j = 0; j < row.samples.size(); ++j) {
    RowSample& sample = row.samples[j];
    const Cut& cut = cuts[j];
    const double model_u = cut.centre + row.index * cut.spacing;
    const auto &left = measured.smooth[0][j], &right = measured.smooth[1][j];
    if (left && right) {
      // The row's own middle against the common model, each by its variance.
      const double own_sigma =
          std::hypot(std::hypot(measured.scatter[0], measured.scatter[1]) / std::sqrt(2.0 * kWindow + 1.0) +
                         kMiddleSigma,
                     px_floor / cut.spacing);
      const double weight = kOwnSpread * kOwnSpread / (kOwnSpread * kOwnSpread + own_sigma * own_sigma);
      sample.centre_px.x() = model_u + weight * 0.5 * (*right - *left) * cut.spacing;
      sample.sigma_px = std::max(px_floor, std::sqrt(weight) * own_sigma * cut.spacing);
    }
    const auto own = [&](std::size_t side) -> std::optional<double> {
      const auto &smooth = measured.smooth[side][j], &value = measured.own[side][j];
      const double sigma = std::max(measured.scatter[side], px_floor / cut.spacing);
      if (!smooth || !value || std::abs(*value - *smooth) > kOutlierSigmas * sigma) return std::nullopt;
      return value;
    };
    if (const auto edge = own(0)) sample.left_u_px = model_u - *edge * cut.spacing;
    if (const auto edge = own(1)) sample.right_u_px = model_u + *edge * cut.spacing;
    sample.edge_sigma_px =
        std::max(px_floor, std::max(measured.scatter[0], measured.scatter[1]) * cut.spacing);
    const bool has_edge = std::isfinite(sample.left_u_px) || std::isfinite(sample.right_u_px);
    sample.seen = sample.seen && has_edge;
    edges += has_edge;
  }
  constexpr double kLeastShown = 0.1;  // part of a row's samples that must show an edge
  row.seen = edges >= kLeastShown * static_cast<double>(row.samples.size());
}

std::optional<Estimate> half_width_at(const Measured& measured, const CommonModel& model, double v_middle,
                                      double px_floor, const RowLine& row) {
  const auto nearest =
      std::min_element(row.samples.begin(), row.samples.end(), [&](const RowSample& a, const RowSample& b) {
        return std::abs(a.centre_px.y() - v_middle) < std::abs(b.centre_px.y() - v_middle);
      });
  if (nearest == row.samples.end() || std::abs(nearest->centre_px.y() - v_middle) > 10.0) return std::nullopt;
  const auto j = static_cast<std::size_t>(nearest - row.samples.begin());
  const auto &left = measured.smooth[0][j], &right = measured.smooth[1][j];
  if (!left || !right) return std::nullopt;
  const double spacing = model.at(v_middle).spacing;
  const std::size_t from = j > kWindow ? j - kWindow : 0, to = std::min(row.samples.size(), j + kWindow + 1);
  const int observations = static_cast<int>(to - from);
  const double sigma = 0.5 * std::hypot(measured.scatter[0], measured.scatter[1]) * spacing /
                       std::sqrt(static_cast<double>(observations));
  return Estimate{0.5 * (*left + *right) * spacing, std::hypot(sigma, px_floor), observations};
}

}  // namespace

void shape_rows(const SummedMap& summed, const CommonModel& model, std::vector<RowLine>& rows) {
  const GreenMap& map = summed.map();
  const double px_floor =
      0.25 * map.scale_u;  // a quarter of a map's pixel: what a step's place is worth after area averaging
  const double v_middle = 0.5 * (map.height * map.scale_v - 1.0);
  const float barest = barest_ground(map, model.field());
  const std::vector<Cut> map_cuts = cuts_of(map, model);
  std::vector<Profile> profiles;
  std::vector<Cut> cuts;
  for (RowLine& row : rows) {
    if (row.samples.size() < 2) continue;
    const double step = row.samples[1].centre_px.y() - row.samples[0].centre_px.y();
    profiles.clear();
    cuts.clear();
    for (const RowSample& sample : row.samples) {
      const double v = sample.centre_px.y();
      profiles.push_back(sample_profile(summed, map_cuts, row.index, v - 0.5 * step, v + 0.499 * step));
      cuts.push_back(model.at(v));
    }
    const Measured measured = measure(map, cuts, row.index, profiles, barest);
    row.half_width_px = half_width_at(measured, model, v_middle, px_floor, row);
    write_samples(measured, cuts, px_floor, row);
  }
}

}  // namespace furrow::rows
