#include "rows/row_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <optional>
#include <utility>

#include "furrow/stats/robust.h"

namespace furrow::rows {
namespace {

constexpr std::size_t kBins = 230;  // of a profile across a row
constexpr double kReach = 0.90;  // of a profile to each side, spacings: to the foot of a wall seen from low
constexpr double kBinWidth = 2.0 * kReach / static_cast<double>(kBins);
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Half the window along the row, in samples, over which levels and the smooth edges are taken: parallel
/// edges keep their place in spacings along a row, in any perspective, so averaging there does not blur them.
constexpr int kWindow = 8;

/// Least contrast of excess green between row and alley: a leaf has 0.2 to 0.6, the noise of soil about 0.02.
constexpr float kLeastContrast = 0.03F;
/// And in parts of the row against the barest ground: leaves of the next row in its shade look less green by
/// less than that.
constexpr float kLeastPart = 0.3F;

/// How far rows stray from the common model, and how well the middle of the green tells a row's middle, both
/// one-sigma in spacings (train pictures of CRBD, development half).
constexpr double kOwnSpread = 0.02, kMiddleSigma = 0.02;

double bin_of(double x) {
  return (x + kReach) / kBinWidth - 0.5;
}

using Profile =
    std::array<float, kBins>;  // greenness by distance from the row's model centre; NaN outside the picture

/// Mean over the bins' widths of what several picture rows show. Unseen bins count nothing.
class ProfileSum {
 public:
  /// Takes one row of the map in by its running sum; borders of the bins are at `first + i * width`, px from
  /// the map's left border. Bins are means over their whole width: points would lose edges between them.
  void add(const float* running, int map_width, float first, float width) {
    const float end = static_cast<float>(map_width), per_width = 1.0F / width, bins = static_cast<float>(kBins);
    const auto from = static_cast<std::size_t>(std::clamp(std::ceil(-first * per_width), 0.0F, bins));
    const auto to = static_cast<std::size_t>(std::clamp(std::floor((end - first) * per_width), 0.0F, bins));
    if (to <= from) return;
    // In loops of which the first and the last fit vector registers.
    for (std::size_t i = from; i <= to; ++i) {
      const float x = std::min(std::max(first + static_cast<float>(static_cast<int>(i)) * width, 0.0F), end);
      pixel_[i] = static_cast<int>(x);
      sum_to_[i] = x - static_cast<float>(pixel_[i]);
    }
    for (std::size_t i = from; i <= to; ++i) {
      const float* at = running + pixel_[i];
      sum_to_[i] = at[0] + sum_to_[i] * (at[1] - at[0]);
    }
    for (std::size_t i = from; i < to; ++i) sum_[i] += (sum_to_[i + 1] - sum_to_[i]) * per_width;
    ++begun_[from], --begun_[to];
  }
  Profile mean() const {
    Profile mean;
    int count = 0;
    for (std::size_t i = 0; i < kBins; ++i) {
      count += begun_[i];
      mean[i] = count > 0 ? sum_[i] / static_cast<float>(count) : kNone;
    }
    return mean;
  }

 private:
  std::array<float, kBins> sum_{};
  std::array<int, kBins + 1> begun_{};  // rows that show bins from here on; less those that end
  std::array<int, kBins + 1> pixel_;
  std::array<float, kBins + 1> sum_to_;  // at first the part of a pixel
};

/// Mean profile over the map's rows that belong to one sample. `cuts` are the model's at the map's rows.
Profile sample_profile(const SummedMap& summed, const std::vector<Cut>& cuts, int k, double v_from,
                       double v_to) {
  const GreenMap& map = summed.map();
  ProfileSum sum;
  const int first =
      std::clamp(static_cast<int>(std::ceil((v_from + 0.5) / map.scale_v - 0.5)), 0, map.height - 1);
  const int last =
      std::clamp(static_cast<int>(std::floor((v_to + 0.5) / map.scale_v - 0.5)), first, map.height - 1);
  const int step = last - first >= 5 ? 2 : 1;  // neighbouring rows of a fine map tell the same
  for (int row = first; row <= last; row += step) {
    const Cut& cut = cuts[static_cast<std::size_t>(row)];
    if (!(cut.spacing > 0.0)) continue;
    sum.add(summed.running(row), map.width,
            static_cast<float>((cut.centre + (k - kReach) * cut.spacing + 0.5) / map.scale_u),
            static_cast<float>(kBinWidth * cut.spacing / map.scale_u));
  }
  return sum.mean();
}

/// The model's cuts of all rows of the map; no spacing where the horizon is near or above.
std::vector<Cut> cuts_of(const GreenMap& map, const CommonModel& model) {
  std::vector<Cut> cuts(static_cast<std::size_t>(map.height));
  for (int row = 0; row < map.height; ++row) {
    const double v = map.v_in_picture(row);
    if (model.field().scale(v) > 0.02) cuts[static_cast<std::size_t>(row)] = model.at(v);
  }
  return cuts;
}

/// For every sample the mean of the profiles in its window; a running sum, so the window's length costs
/// nothing.
std::vector<Profile> window_means(const std::vector<Profile>& profiles) {
  std::vector<Profile> means(profiles.size());
  std::array<float, kBins> sum{}, count{};
  const auto add = [&](const Profile& profile, float sign) {
    for (std::size_t i = 0; i < kBins; ++i) {
      const bool is_seen = !std::isnan(profile[i]);
      sum[i] += is_seen ? sign * profile[i] : 0.0F;
      count[i] += is_seen ? sign : 0.0F;
    }
  };
  for (std::size_t j = 0; j < std::min<std::size_t>(kWindow, profiles.size()); ++j) add(profiles[j], 1.0F);
  for (std::size_t j = 0; j < profiles.size(); ++j) {
    if (j + kWindow < profiles.size()) add(profiles[j + kWindow], 1.0F);
    if (j > kWindow) add(profiles[j - kWindow - 1], -1.0F);
    for (std::size_t i = 0; i < kBins; ++i)
      means[j][i] = count[i] > 0.0F ? sum[i] / count[i] : kNone;
  }
  return means;
}

/// Mean of the lowest (or highest) `part` of the values in an interval of x.
std::optional<float> tail_mean(const Profile& profile, double x_from, double x_to, bool lower, double part) {
  std::array<float, kBins> values;
  const auto first = static_cast<std::size_t>(std::clamp(std::ceil(bin_of(x_from)), 0.0, kBins - 1.0));
  const auto last = static_cast<std::size_t>(std::clamp(std::floor(bin_of(x_to)), 0.0, kBins - 1.0));
  std::size_t seen = 0;
  for (std::size_t i = first; i <= last; ++i) {
    values[seen] = profile[i];
    seen += !std::isnan(profile[i]);
  }
  if (seen < 2 || 2 * seen < last - first + 1) return std::nullopt;
  const auto count = static_cast<std::ptrdiff_t>(std::ceil(part * static_cast<double>(seen)));
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(seen), last_counted = values.begin() + count - 1;
  if (lower) {
    std::nth_element(values.begin(), last_counted, end);
  } else {
    std::nth_element(values.begin(), last_counted, end, std::greater<>());
  }
  return std::accumulate(values.begin(), last_counted + 1, 0.0F) / static_cast<float>(count);
}

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
constexpr int kSteps = static_cast<int>(kFarthest / kBinWidth);

/// Bin `i` steps outwards from a row's centre.
float outwards(const Profile& profile, int side, int i) {
  const int half = static_cast<int>(kBins) / 2;
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
  return (last_inside + 0.5 + std::clamp(part, 0.0, 1.0)) * kBinWidth;
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
                                        static_cast<std::size_t>(u + 0.5)]);
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

CommonModel::CommonModel(const FoundField& found, const GreenMap& search_map)
    : field_(found.field), centre_k_(found.followed.centre_k) {
  field_.u0 = search_map.u_in_picture(found.field.u0);
  field_.v0 = search_map.v_in_picture(found.field.v0);
  field_.length = found.field.length * search_map.scale_v;
  for (double* px : {&field_.spacing, &field_.offset, &field_.slope, &field_.bend, &field_.bend2})
    *px *= search_map.scale_u;
  const FollowedField& followed = found.followed;
  for (std::size_t i = 0; i < followed.v.size(); ++i) {
    const double spacing = found.field.spacing_at(followed.v[i]);
    departures_.push_back({search_map.v_in_picture(followed.v[i]),
                           (followed.centre[i] - found.field.u_at(followed.v[i], centre_k_)) / spacing,
                           followed.spacing[i] / spacing});
  }
}

Cut CommonModel::at(double v) const {
  double shift = 0.0, stretch = 1.0;
  if (!departures_.empty()) {
    const auto upper = std::lower_bound(departures_.begin(), departures_.end(), v,
                                        [](const Departure& one, double at) { return one.v < at; });
    const Departure& b = upper == departures_.end() ? departures_.back() : *upper;
    const Departure& a = upper == departures_.begin() ? b : *(upper - 1);
    const double part = b.v > a.v ? std::clamp((v - a.v) / (b.v - a.v), 0.0, 1.0) : 0.0;
    shift = a.shift + part * (b.shift - a.shift);
    stretch = a.stretch + part * (b.stretch - a.stretch);
  }
  const double spacing = field_.spacing_at(v);
  return {v, field_.u_at(v, centre_k_) + shift * spacing - centre_k_ * spacing * stretch, spacing * stretch};
}

SummedMap::SummedMap(GreenMap map) : map_(std::move(map)) {
  constexpr int kTogether = 4;  // rows: one sum waits for the addition before
  const auto width = static_cast<std::size_t>(map_.width), stride = width + 2;
  sums_.resize(stride * static_cast<std::size_t>(map_.height));
  for (int top = 0; top < map_.height; top += kTogether) {
    std::array<const float*, kTogether> in{};
    std::array<float*, kTogether> out{};
    std::array<float, kTogether> sum{};
    for (int i = 0; i < kTogether; ++i) {
      const int row = std::min(top + i, map_.height - 1);
      in[static_cast<std::size_t>(i)] = map_.row(row);
      out[static_cast<std::size_t>(i)] = sums_.data() + static_cast<std::size_t>(row) * stride;
    }
    for (std::size_t u = 0; u < width; ++u)
      for (std::size_t i = 0; i < kTogether; ++i) out[i][u + 1] = sum[i] += in[i][u];
    for (std::size_t i = 0; i < kTogether; ++i) out[i][width + 1] = sum[i];
  }
}

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
