#include "rows/row_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "furrow/base/whole.h"
#include "furrow/stats/robust.h"

namespace furrow::rows {
namespace {

constexpr int kArm = 6;  // bins of light compared on each side of an edge
/// Log light of all that is not leaf, against the typical leaf (Bare::dark).
constexpr float kGround = -0.7F;

float upper_tenth(std::vector<float>& values) {
  const auto top = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), top, values.end());
  return *top;
}

/// Log light of pixels that are green, against the median of all that are.
class LeafLight {
 public:
  struct Sum {
    float leaf = 0.0F, lit = 0.0F;  ///< parts that are leaf, and their light
  };

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

  /// Running sums of a row: sums[u] is the sum over [0, u), and once more the last, so that places between
  /// need no test.
  void sum_row(int row, std::vector<Sum>& sums) const {
    const auto width = static_cast<std::size_t>(map_.width);
    const float* green = map_.row(row);
    const std::uint16_t* light = map_.light.data() + static_cast<std::size_t>(row) * width;
    sums.resize(width + 2);
    Sum sum = sums[0] = {};
    const float per_full = full_ > 0.0F ? 1.0F / (full_ * (kFullGreen - kLeastGreen)) : 0.0F;
    const float least = kLeastGreen * full_ * per_full;
    for (std::size_t u = 0; u < width; ++u) {
      const float leaf = std::min(std::max(green[u] * per_full - least, 0.0F), 1.0F);
      sum.leaf += leaf, sum.lit += leaf * light_[light[u]];
      sums[u + 1] = sum;
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

/// Without block `left_out` (-1: with all).
MeanLight mean_light(const LightByRow& light, Bare bare, int left_out) {
  constexpr float kMostlyLeaf = 0.7F;  // part of a place that is there without ground: beyond, edges mix
  MeanLight result;
  for (std::size_t i = 0; i < kLightBins; ++i) {
    float lit = 0.0F, leaf = 0.0F, count = 0.0F;
    for (int b = 0; b < kLightBlocks; ++b) {
      if (b == left_out) continue;
      const auto block = static_cast<std::size_t>(b);
      lit += light.lit[block][i], leaf += light.leaf[block][i], count += light.count[block][i];
    }
    if (bare == Bare::dark) {
      result.there[i] = count > 0.0F;
      result.mean[i] = count > 0.0F ? (lit + kGround * (count - leaf)) / count : 0.0F;
    } else {
      result.there[i] = leaf > kMostlyLeaf * count;
      result.mean[i] = result.there[i] ? lit / leaf : 0.0F;
    }
  }
  return result;
}

LightDrop drop_of(const MeanLight& light, int direction) {
  LightDrop drop{};
  for (int i = kArm; i + kArm < kLightBins; ++i) {
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

}  // namespace

std::optional<Fan> fan_of(const PlanarField& field, double tilt) {
  const auto point = field.vanishing_point();
  if (!point) return std::nullopt;
  const double steepness = field.convergence / field.length;
  return Fan{*point, field.spacing * steepness, field.offset * steepness + field.slope / field.length, tilt};
}

LightByRow light_by_row(const GreenMap& map, const PlanarField& field, const Fan& fan) {
  LightByRow light;
  const LeafLight leaves(map);
  const int strip = std::max(1, map.height / 45);
  std::vector<LeafLight::Sum> sums;
  std::array<float, kLightBins + 1> aside;  // du / dv of each bin's border
  for (int i = 0; i <= kLightBins; ++i)
    aside[static_cast<std::size_t>(i)] =
        static_cast<float>(fan.u_at(fan.point.y() + 1.0, i * kLightBin - kLightReach) - fan.point.x());
  for (int row = 0; row < map.height; ++row) {
    const double v = map.v_in_picture(row);
    if (field.scale(v) < kLeastScale) continue;
    leaves.sum_row(row, sums);
    const auto block = static_cast<std::size_t>((row / strip) % kLightBlocks);
    const float first = static_cast<float>((fan.point.x() + 0.5) / map.scale_u);
    const float per_aside = static_cast<float>((v - fan.point.y()) / map.scale_u);
    const float end = static_cast<float>(map.width);
    float before = -1.0F;
    LeafLight::Sum sum_before;
    for (std::size_t i = 0; i <= kLightBins; ++i) {
      const float border = first + per_aside * aside[i];
      if (!(border >= 0.0F && border <= end)) {
        before = -1.0F;
        continue;
      }
      const auto pixel = static_cast<std::size_t>(static_cast<int>(border));
      const float part = border - static_cast<float>(pixel);
      const LeafLight::Sum &from = sums[pixel], &to = sums[pixel + 1];
      const LeafLight::Sum sum = {from.leaf + part * (to.leaf - from.leaf),
                                  from.lit + part * (to.lit - from.lit)};
      // Each picture row has one vote in a bin: its mean.
      if (before >= 0.0F && border > before) {
        light.leaf[block][i - 1] += (sum.leaf - sum_before.leaf) / (border - before);
        light.lit[block][i - 1] += (sum.lit - sum_before.lit) / (border - before);
        light.count[block][i - 1] += 1.0F;
      }
      before = border, sum_before = sum;
    }
  }
  return light;
}

LightSide::LightSide(const MeanLight& light, const std::array<MeanLight, kLightBlocks>& light_without,
                     int towards)
    : MeanLight(light), direction(towards), all(drop_of(light, towards)) {
  for (std::size_t b = 0; b < kLightBlocks; ++b) without[b] = drop_of(light_without[b], towards);
}

float LightSide::sigma_at(double place) const {
  float middle = 0.0F, squares = 0.0F;
  for (const LightDrop& one : without) middle += value_at(one, place) / kLightBlocks;
  for (const LightDrop& one : without)
    squares += (value_at(one, place) - middle) * (value_at(one, place) - middle);
  return std::sqrt(squares * (kLightBlocks - 1) / kLightBlocks);
}

std::array<LightSide, 2> sides_of(const LightByRow& light, Bare bare) {
  const MeanLight mean = mean_light(light, bare, -1);
  std::array<MeanLight, kLightBlocks> without;
  for (int b = 0; b < kLightBlocks; ++b) without[static_cast<std::size_t>(b)] = mean_light(light, bare, b);
  return {LightSide(mean, without, -1), LightSide(mean, without, 1)};
}

float value_at(const LightDrop& drop, double place) {
  const int i = static_cast<int>(std::lround(bin_at(place)));
  return i >= 0 && i < kLightBins ? drop[static_cast<std::size_t>(i)] : 0.0F;
}

std::optional<double> peak_near(const LightDrop& drop, float sign, double place, double reach) {
  const int from = base::ceil_between(bin_at(place - reach), 1, kLightBins - 1);
  const int to = base::floor_between(bin_at(place + reach), 0, kLightBins - 2);
  int best = -1;
  for (int i = from; i <= to; ++i) {
    if (sign * drop[static_cast<std::size_t>(i)] >
        (best < 0 ? 0.0F : sign * drop[static_cast<std::size_t>(best)]))
      best = i;
  }
  if (best < 0) return std::nullopt;
  const auto i = static_cast<std::size_t>(best);
  const double a = static_cast<double>(sign * drop[i - 1]), b = static_cast<double>(sign * drop[i]),
               c = static_cast<double>(sign * drop[i + 1]);
  const double bow = a - 2.0 * b + c;
  return place_of(best + (bow < 0.0 ? std::clamp(0.5 * (a - c) / bow, -0.5, 0.5) : 0.0));
}

}  // namespace furrow::rows
