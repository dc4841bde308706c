#include "rows/comb.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace furrow::rows {
namespace {

// Rows nearer than the first cannot be told apart in a map, from the second on they can: two samples a period
// and some blur.
constexpr float kLeastSpacingPx = 3.0F, kFullSpacingPx = 7.0F;

/// Peaks are limited softly at this many standard deviations, so that one weed does not outweigh a row.
constexpr float kPeakSigmas = 3.0F;

/// More rows than these on each side of the middle add nothing but the distance of far planter passes.
constexpr int kMostRows = 12;

/// Floor by truncation: without SSE 4.1 std::floor is a call, and this stands in the innermost loop.
int whole_below(float x) {
  const int whole = static_cast<int>(x);
  return whole - (static_cast<float>(whole) > x ? 1 : 0);
}

void standardise(std::vector<float>& profile, int window, std::vector<float>& running) {
  const int width = static_cast<int>(profile.size());
  running.assign(profile.size() + 1, 0.0F);
  for (std::size_t u = 0; u < profile.size(); ++u) running[u + 1] = running[u] + profile[u];
  float square = 0.0F;
  for (int u = 0; u < width; ++u) {
    const int from = std::max(0, u - window), to = std::min(width, u + window + 1);
    const float mean = (running[static_cast<std::size_t>(to)] - running[static_cast<std::size_t>(from)]) /
                       static_cast<float>(to - from);
    float& value = profile[static_cast<std::size_t>(u)];
    value -= mean;
    square += value * value;
  }
  // Below a thousandth of chroma contrast there is nothing but rounding of 8-bit levels.
  const float sigma = std::sqrt(square / static_cast<float>(width)) + 1e-3F;
  for (float& value : profile) {
    const float z = value / sigma;
    value = z / std::sqrt(1.0F + z * z / (kPeakSigmas * kPeakSigmas));
  }
}

/// out[u] = running sum at u + shift, linear between its entries.
void shifted(const float* running, int width, float shift, float* out) {
  const float limit = static_cast<float>(width - 1);
  shift = std::clamp(shift, -limit, limit);
  const float whole = std::floor(shift), part = shift - whole;
  const float* from = running + static_cast<int>(whole);
  for (int u = 0; u < width; ++u) out[u] = from[u] + part * (from[u + 1] - from[u]);
}

/// Means over [u + from, u + to] (px borders at +-0.5) and the part of them inside the picture, for every u
/// of a strip.
struct Bands {
  std::vector<float> value, part, work;
  explicit Bands(int width)
      : value(static_cast<std::size_t>(width)), part(value.size()), work(value.size()) {}
  void make(const float* running, const float* ramp, int width, float from, float to) {
    const float per_length = 1.0F / (to - from);
    shifted(running, width, to + 0.5F, value.data());
    shifted(running, width, from + 0.5F, work.data());
    for (std::size_t i = 0; i < value.size(); ++i) value[i] -= work[i];
    shifted(ramp, width, to + 0.5F, part.data());
    shifted(ramp, width, from + 0.5F, work.data());
    for (std::size_t i = 0; i < value.size(); ++i) {
      const float inside = part[i] - work[i];
      value[i] /= inside + 1e-3F;
      part[i] = inside * per_length;
    }
  }
};

}  // namespace

Strips make_strips(const GreenMap& map, int strip_height) {
  Strips strips;
  strips.width = map.width;
  strips.height = map.height;
  strip_height = std::clamp(strip_height, 1, map.height);
  const int window = std::max(4, map.width / 4);  // half the window of the local mean: half a picture in all
  const auto width = static_cast<std::size_t>(map.width);
  const auto count = static_cast<std::size_t>(map.height / strip_height);
  strips.sum.reserve(count * strips.stride());
  std::vector<float> profile, running;
  for (int top = 0; top + strip_height <= map.height; top += strip_height) {
    profile.assign(width, 0.0F);
    for (int v = top; v < top + strip_height; ++v) {
      const float* line = map.row(v);
      for (std::size_t u = 0; u < width; ++u) profile[u] += line[u];
    }
    for (float& value : profile) value /= static_cast<float>(strip_height);
    standardise(profile, window, running);
    strips.v.push_back(static_cast<float>(top) + 0.5F * static_cast<float>(strip_height - 1));
    strips.sum.insert(strips.sum.end(), width, 0.0F);
    float sum = 0.0F;
    strips.sum.push_back(sum);
    for (const float value : profile) strips.sum.push_back(sum += value);
    strips.sum.insert(strips.sum.end(), width, sum);
  }
  return strips;
}

Response respond(const Strips& strips, const PlanarField& field, double tooth) {
  const int width = strips.width;
  Response response;
  response.width = width;
  response.v = strips.v;
  response.value.assign(strips.count() * static_cast<std::size_t>(width), 0.0F);
  response.fade.assign(strips.count(), 0.0F);
  std::vector<float> ramp_store(strips.stride());
  for (std::size_t i = 0; i < ramp_store.size(); ++i)
    ramp_store[i] =
        std::clamp(static_cast<float>(i) - static_cast<float>(width), 0.0F, static_cast<float>(width));
  const float* ramp = ramp_store.data() + width;
  Bands row(width), left(width), right(width), period(width);
  const float part = static_cast<float>(tooth), gain = 0.5F * std::sqrt(part * (1.0F - part)),
              per_rest = 1.0F / (1.0F - part);
  for (std::size_t j = 0; j < strips.count(); ++j) {
    const float spacing = static_cast<float>(field.spacing_at(static_cast<double>(strips.v[j])));
    if (spacing <= kLeastSpacingPx) continue;
    response.fade[j] = std::min(1.0F, (spacing - kLeastSpacingPx) / (kFullSpacingPx - kLeastSpacingPx));
    const float half = 0.5F * part * spacing, apart = 0.5F * spacing;
    const float alley = 0.5F * std::min(part, 1.0F - part) * spacing;  // half the width compared on each side
    const float* running = strips.running(j);
    row.make(running, ramp, width, -half, half);
    left.make(running, ramp, width, -apart - alley, -apart + alley);
    right.make(running, ramp, width, apart - alley, apart + alley);
    period.make(running, ramp, width, -apart, apart);
    float* line = response.value.data() + j * static_cast<std::size_t>(width);
    for (std::size_t i = 0; i < static_cast<std::size_t>(width); ++i) {
      // Against the middles of both alleys (a trend cancels) and against all of the rest of the period (a
      // comb of every second or third row does not pass), half each.
      const float alleys = (left.value[i] * left.part[i] + right.value[i] * right.part[i]) /
                           (left.part[i] + right.part[i] + 1e-3F);
      line[i] = gain * ((row.value[i] - alleys) + (row.value[i] - period.value[i]) * per_rest) * row.part[i];
    }
  }
  return response;
}

double comb_score(const Response& response, const PlanarField& field, const Emphasis& emphasis) {
  const int middle = static_cast<int>(std::lround(field.k_at(field.u0, field.v0)));
  std::array<float, 2 * kMostRows + 1> weight{};
  for (int i = -kMostRows; i <= kMostRows; ++i) {
    const double off = (middle + i - emphasis.centre_k) / emphasis.reach;
    weight[static_cast<std::size_t>(i + kMostRows)] = static_cast<float>(1.0 / (1.0 + off * off));
  }
  float total = 0.0F;
  const float right = static_cast<float>(response.width - 1),
              least = static_cast<float>(emphasis.least_scale);
  const float g = static_cast<float>(field.convergence), spacing0 = static_cast<float>(field.spacing);
  const float offset = static_cast<float>(field.offset + middle * field.spacing),
              slope = static_cast<float>(field.slope);
  const float bend = static_cast<float>(field.bend), bend2 = static_cast<float>(field.bend2),
              u0 = static_cast<float>(field.u0);
  const float v0 = static_cast<float>(field.v0), per_length = static_cast<float>(1.0 / field.length);
  for (std::size_t j = 0; j < response.v.size(); ++j) {
    // PlanarField::u_at in single precision: this is the innermost loop of the search.
    const float t = (response.v[j] - v0) * per_length, scale = 1.0F + g * t;
    const float spacing = spacing0 * scale;
    if (scale < least || response.fade[j] <= 0.0F || spacing <= kLeastSpacingPx) continue;
    const float y = t / scale, centre = u0 + scale * (offset + y * (slope + y * (bend + y * bend2)));
    const float per_spacing = 1.0F / spacing;
    const int first = std::max(-kMostRows, -whole_below(centre * per_spacing));
    const int last = std::min(kMostRows, whole_below((right - centre) * per_spacing));
    float sum = 0.0F, weights = 0.0F;
    for (int i = first; i <= last; ++i) {
      const float w = weight[static_cast<std::size_t>(i + kMostRows)];
      sum += w * response.at(j, centre + static_cast<float>(i) * spacing);
      weights += w;
    }
    if (weights > 0.0F) total += response.fade[j] * sum / weights;
  }
  return static_cast<double>(total) / static_cast<double>(std::max<std::size_t>(1, response.v.size()));
}

double mean_row_count(const Strips& strips, const PlanarField& field) {
  double rows = 0.0, count = 0.0;
  for (const float v : strips.v) {
    const double spacing = field.spacing_at(static_cast<double>(v));
    if (spacing < static_cast<double>(kLeastSpacingPx)) continue;
    rows += strips.width / spacing;
    count += 1.0;
  }
  return count > 0.0 ? rows / count : 0.0;
}

}  // namespace furrow::rows
