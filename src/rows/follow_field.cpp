#include "rows/follow_field.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace furrow::rows {
namespace {

constexpr int kShifts = 15, kStretches = 6;               // states on each side
constexpr double kShiftStep = 0.05, kStretchStep = 0.04;  // spacings; relative spacing
constexpr int kShiftCount = 2 * kShifts + 1, kStretchCount = 2 * kStretches + 1;

/// From strip to strip a way steps by at most two states of shift and one of stretch.
constexpr int kMostStep = 2;

/// One number per state, with an edge of zeros so that steps need no test.
struct States {
  static constexpr std::size_t kLine = 36;  // 2 + 31 + 2, up to full vectors
  std::array<std::array<float, kLine>, kStretchCount + 2> line{};

  float* of_stretch(int stretch) { return line[static_cast<std::size_t>(stretch + kStretches + 1)].data() + kMostStep; }
  const float* of_stretch(int stretch) const {
    return line[static_cast<std::size_t>(stretch + kStretches + 1)].data() + kMostStep;
  }
};
static_assert(States::kLine >= kShiftCount + 2 * kMostStep);

using AtShifts = std::array<float, kShiftCount>;

/// Adds one row's response at all shifts that keep it in the picture, `first_u` on and `step` px apart.
void add_row(const Response& response, std::size_t j, float first_u, float step, float weight, AtShifts& sum,
             AtShifts& weights) {
  constexpr float kCount = kShiftCount;
  const float right = static_cast<float>(response.width - 1), per_step = 1.0F / step;
  const float first = std::clamp(std::ceil(-first_u * per_step), 0.0F, kCount);
  const float last = std::clamp(std::ceil((right - first_u) * per_step), first, kCount);
  const float* line = response.value.data() + j * static_cast<std::size_t>(response.width);
  for (auto d = static_cast<std::size_t>(first); d < static_cast<std::size_t>(last); ++d) {
    // Rounding may put the first a hair outside.
    const float u = std::max(0.0F, first_u + static_cast<float>(d) * step);
    const int i = std::min(static_cast<int>(u), response.width - 2);
    sum[d] += weight * (line[i] + (u - static_cast<float>(i)) * (line[i + 1] - line[i]));
    weights[d] += weight;
  }
}

/// How well every state explains one strip, as odds.
void strip_odds(const Response& response, std::size_t j, const PlanarField& field, double centre_k,
                double reach, States& odds) {
  constexpr int kRows = 2;
  // Log odds of a response of 1. A plant spans several strips and its errors with it, so that a strip tells
  // less than its own noise.
  constexpr float kPerResponse = 2.5F;
  const double v = static_cast<double>(response.v[j]);
  const float spacing0 = static_cast<float>(field.spacing_at(v)),
              centre0 = static_cast<float>(field.u_at(v, centre_k));
  const float step = static_cast<float>(kShiftStep) * spacing0;
  for (int e = -kStretches; e <= kStretches; ++e) {
    const float spacing = spacing0 * static_cast<float>(std::exp(e * kStretchStep));
    AtShifts sum{}, weights{};
    for (int k = -kRows; k <= kRows; ++k)
      add_row(response, j, centre0 + static_cast<float>(k) * spacing - kShifts * step, step,
              static_cast<float>(1.0 / (1.0 + k * k / (reach * reach))), sum, weights);
    float* out = odds.of_stretch(e);
    for (std::size_t d = 0; d < kShiftCount; ++d)
      out[d] = std::exp(weights[d] > 0.0F ? kPerResponse * sum[d] / weights[d] : 0.0F);
  }
}

/// What comes from the neighbouring strip: the sum over all steps, each lowered with its square. Their scale
/// is arbitrary, so the sum over all states is made 1.
void step_on(const States& from, double scale, States& to) {
  // Log odds against one state's step between strips at the bottom. Departures grow along the ground, and a
  // strip covers ground as 1 / scale^2.
  constexpr double kAgainstStep = 7.5;
  const auto one = static_cast<float>(std::exp(-kAgainstStep * scale * scale)), two = one * one * one * one;
  float total = 0.0F;
  std::array<float, States::kLine> middle{};
  for (int e = -kStretches; e <= kStretches; ++e) {
    const float *below = from.of_stretch(e - 1), *here = from.of_stretch(e), *above = from.of_stretch(e + 1);
    float* mid = middle.data() + kMostStep;
    for (int d = 0; d < kShiftCount; ++d) mid[d] = here[d] + one * (below[d] + above[d]);
    float* out = to.of_stretch(e);
    for (int d = 0; d < kShiftCount; ++d) {
      out[d] = mid[d] + one * (mid[d - 1] + mid[d + 1]) + two * (mid[d - 2] + mid[d + 2]);
      total += out[d];
    }
  }
  const float per_total = 1.0F / total;
  for (int e = -kStretches; e <= kStretches; ++e)
    for (int d = 0; d < kShiftCount; ++d) to.of_stretch(e)[d] *= per_total;
}

void multiply(States& states, const States& by) {
  for (std::size_t e = 0; e < states.line.size(); ++e)
    for (std::size_t i = 0; i < States::kLine; ++i) states.line[e][i] *= by.line[e][i];
}

/// Mean shift in spacings, and mean logarithm of the stretch, of two parts of the odds.
struct Departure {
  double shift = 0.0, log_stretch = 0.0;
};

Departure mean_departure(const States& below, const States& above) {
  float total = 0.0F, shift = 0.0F, stretch = 0.0F;
  for (int e = -kStretches; e <= kStretches; ++e) {
    const float *a = below.of_stretch(e), *b = above.of_stretch(e);
    float sum = 0.0F;
    for (int d = 0; d < kShiftCount; ++d) {
      const float odds = a[d] * b[d];
      sum += odds;
      shift += odds * static_cast<float>(d - kShifts);
    }
    total += sum;
    stretch += sum * static_cast<float>(e);
  }
  return {kShiftStep * static_cast<double>(shift / total),
          kStretchStep * static_cast<double>(stretch / total)};
}

/// Strips on which the rows are followed, from the bottom up.
std::vector<std::size_t> strips_of(const Response& response, const PlanarField& field) {
  constexpr double kLeastScale = 0.04;
  std::vector<std::size_t> used;
  for (std::size_t j = response.v.size(); j-- > 0;)
    if (const double v = static_cast<double>(response.v[j]);
        field.scale(v) > kLeastScale && field.spacing_at(v) > static_cast<double>(kLeastRowSpacingPx))
      used.push_back(j);
  return used;
}

}  // namespace

FollowedField follow(const Response& response, const PlanarField& field, double centre_k, double reach) {
  FollowedField result;
  result.centre_k = centre_k;
  const std::vector<std::size_t> used = strips_of(response, field);
  const auto scale = [&](std::size_t i) { return field.scale(static_cast<double>(response.v[used[i]])); };
  std::vector<States> odds(used.size()), below(used.size());  // of the strip; with all that is below it
  for (std::size_t i = 0; i < used.size(); ++i) {
    strip_odds(response, used[i], field, centre_k, reach, odds[i]);
    if (i == 0) {
      below[i] = odds[i];
      continue;
    }
    step_on(below[i - 1], scale(i), below[i]);
    multiply(below[i], odds[i]);
  }
  States above, with_strip;
  for (int e = -kStretches; e <= kStretches; ++e) std::fill_n(above.of_stretch(e), kShiftCount, 1.0F);
  for (std::size_t i = used.size(); i-- > 0;) {
    const Departure mean = mean_departure(below[i], above);
    const double v = static_cast<double>(response.v[used[i]]), spacing = field.spacing_at(v);
    result.v.push_back(v);
    result.centre.push_back(field.u_at(v, centre_k) + mean.shift * spacing);
    result.spacing.push_back(spacing * std::exp(mean.log_stretch));
    if (i == 0) break;
    with_strip = odds[i];
    multiply(with_strip, above);
    step_on(with_strip, scale(i), above);
  }
  return result;
}

}  // namespace furrow::rows
