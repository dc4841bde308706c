#include "rows/comb.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace furrow::rows {
namespace {

/// From here on rows are told apart in full.
constexpr float kFullSpacingPx = 7.0F;

/// Peaks are limited softly at this many standard deviations, so that one weed does not outweigh a row.
constexpr float kPeakSigmas = 3.0F;

/// More rows than these on each side of the middle add nothing but the distance of far planter passes.
constexpr int kMostRows = 12;

/// Floor by truncation: without SSE 4.1 std::floor is a call, and this stands in the innermost loop.
int whole_below(float x) {
  const int whole = static_cast<int>(x);
  return whole - (static_cast<float>(whole) > x ? 1 : 0);
}

float fade_at(float spacing) {
  return std::min(1.0F, (spacing - kLeastRowSpacingPx) / (kFullSpacingPx - kLeastRowSpacingPx));
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

/// How much greener a row at u is than what lies beside it, as a sum over the strip's running sum at
/// u + from[i] with factor[i]; linear between entries, so every border of a band gives two places.
///
/// Half against the middles of both alleys (a trend cancels), half against all of the rest of the period (a
/// comb of every second or third row does not pass). Outside the picture is the local mean, zero. Rows too
/// close to be told apart fade away.
struct Kernel {
  static constexpr std::size_t kPlaces = 16;
  std::array<int, kPlaces> from{};
  std::array<float, kPlaces> factor{};
};

Kernel kernel_of(float spacing, float tooth, int width) {
  Kernel kernel;
  std::size_t n = 0;
  const float farthest = static_cast<float>(width - 1);
  const auto add = [&](float border, float factor) {
    const float place = std::clamp(border + 0.5F, -farthest, farthest);  // the strip's padding ends there
    const float whole = std::floor(place), part = place - whole;
    kernel.from[n] = static_cast<int>(whole), kernel.factor[n++] = factor * (1.0F - part);
    kernel.from[n] = static_cast<int>(whole) + 1, kernel.factor[n++] = factor * part;
  };
  const auto add_mean = [&](float middle, float half, float factor) {
    add(middle + half, 0.5F * factor / half);
    add(middle - half, -0.5F * factor / half);
  };
  const float gain = 0.5F * fade_at(spacing) * std::sqrt(tooth * (1.0F - tooth)),
              per_rest = 1.0F / (1.0F - tooth);
  const float apart = 0.5F * spacing, alley = std::min(tooth, 1.0F - tooth) * apart;
  add_mean(0.0F, tooth * apart, gain * (1.0F + per_rest));
  add_mean(0.0F, apart, -gain * per_rest);
  add_mean(apart, alley, -0.5F * gain);
  add_mean(-apart, alley, -0.5F * gain);
  return kernel;
}

/// The kernel at every u of a strip; in blocks that stay in registers, the last one overlapping.
void convolve(const float* running, const Kernel& kernel, int width, float* out) {
  using Lanes [[gnu::vector_size(16)]] = float;
  constexpr int kBlock = 16;
  for (int u = 0; u < width; u += kBlock) {
    const int at = std::min(u, width - kBlock);
    std::array<Lanes, 4> sum{};
    for (std::size_t i = 0; i < Kernel::kPlaces; ++i) {
      std::array<Lanes, 4> in;
      std::memcpy(in.data(), running + at + kernel.from[i], sizeof in);
      for (std::size_t k = 0; k < 4; ++k) sum[k] += kernel.factor[i] * in[k];
    }
    std::memcpy(out + at, sum.data(), sizeof sum);
  }
}

/// The same at one place between px.
float convolve_at(const float* running, const Kernel& kernel, float u) {
  const int i = static_cast<int>(u);
  float here = 0.0F, next = 0.0F;
  for (std::size_t n = 0; n < Kernel::kPlaces; ++n) {
    const float* from = running + i + kernel.from[n];
    here += kernel.factor[n] * from[0];
    next += kernel.factor[n] * from[1];
  }
  return here + (u - static_cast<float>(i)) * (next - here);
}

/// Mean over strips of the weighted mean over the field's rows of what `on_strip(strip, spacing)` gives at
/// them: a function of u in px, asked inside the picture only.
template <class OnStrip>
double mean_over_rows(const std::vector<float>& strip_v, int width, const PlanarField& field,
                      const Emphasis& emphasis, const OnStrip& on_strip) {
  const int middle = static_cast<int>(std::lround(field.k_at(field.u0, field.v0)));
  std::array<float, 2 * kMostRows + 1> weight{};
  for (int i = -kMostRows; i <= kMostRows; ++i) {
    const double off = (middle + i - emphasis.centre_k) / emphasis.reach;
    weight[static_cast<std::size_t>(i + kMostRows)] = static_cast<float>(1.0 / (1.0 + off * off));
  }
  float total = 0.0F;
  const float tilt = static_cast<float>(emphasis.tilt);
  const float right = static_cast<float>(width - 1), least = static_cast<float>(emphasis.least_scale);
  const float g = static_cast<float>(field.convergence), spacing0 = static_cast<float>(field.spacing);
  const float offset = static_cast<float>(field.offset + middle * field.spacing),
              slope = static_cast<float>(field.slope);
  const float bend = static_cast<float>(field.bend), bend2 = static_cast<float>(field.bend2),
              u0 = static_cast<float>(field.u0);
  const float v0 = static_cast<float>(field.v0), per_length = static_cast<float>(1.0 / field.length);
  for (std::size_t j = 0; j < strip_v.size(); ++j) {
    // PlanarField::u_at in single precision: this is the innermost loop of the search.
    const float t = (strip_v[j] - v0) * per_length, scale = 1.0F + g * t;
    const float spacing = spacing0 * scale;
    if (scale < least || spacing <= kLeastRowSpacingPx) continue;
    const float y = t / scale, centre = u0 + scale * (offset + y * (slope + y * (bend + y * bend2)));
    const float per_spacing = 1.0F / spacing;
    const int first = std::max(-kMostRows, -whole_below(centre * per_spacing));
    const int last = std::min(kMostRows, whole_below((right - centre) * per_spacing));
    const auto at = on_strip(j, spacing);
    float sum = 0.0F, weights = 0.0F;
    if (tilt != 0.0F) {
      const float lean =
          per_length * (g * offset + slope + y * ((2.0F - g * y) * bend + y * (3.0F - 2.0F * g * y) * bend2));
      const float lean_step = per_length * g * spacing0;
      for (int i = -kMostRows; i <= kMostRows; ++i) {
        const float level_u = centre + static_cast<float>(i) * spacing;
        const float st = tilt * (lean + static_cast<float>(i) * lean_step);
        if (st < -0.7F) continue;
        const float u = level_u - (level_u - u0) * st / (1.0F + st);
        if (u < 0.0F || u > right) continue;
        const float w = weight[static_cast<std::size_t>(i + kMostRows)];
        sum += w * at(u);
        weights += w;
      }
      if (weights > 0.0F) total += sum / weights;
      continue;
    }
    for (int i = first; i <= last; ++i) {
      const float w = weight[static_cast<std::size_t>(i + kMostRows)];
      sum += w * at(centre + static_cast<float>(i) * spacing);
      weights += w;
    }
    if (weights > 0.0F) total += sum / weights;
  }
  return static_cast<double>(total) / static_cast<double>(std::max<std::size_t>(1, strip_v.size()));
}

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
  for (std::size_t j = 0; j < strips.count(); ++j) {
    const float spacing = static_cast<float>(field.spacing_at(static_cast<double>(strips.v[j])));
    if (spacing <= kLeastRowSpacingPx) continue;
    convolve(strips.running(j), kernel_of(spacing, static_cast<float>(tooth), width), width,
             response.value.data() + j * static_cast<std::size_t>(width));
  }
  return response;
}

double comb_score(const Response& response, const PlanarField& field, const Emphasis& emphasis) {
  return mean_over_rows(response.v, response.width, field, emphasis, [&](std::size_t j, float) {
    return [line = response.line(j), last = static_cast<float>(response.width - 1)](float u) {
      return Response::between(line, last, u);
    };
  });
}

double comb_score(const Strips& strips, const PlanarField& field, double tooth, const Emphasis& emphasis) {
  return mean_over_rows(strips.v, strips.width, field, emphasis, [&](std::size_t j, float spacing) {
    return [running = strips.running(j),
            kernel = kernel_of(spacing, static_cast<float>(tooth), strips.width)](float u) {
      return convolve_at(running, kernel, u);
    };
  });
}

double mean_row_count(const Strips& strips, const PlanarField& field) {
  double rows = 0.0, count = 0.0;
  for (const float v : strips.v) {
    const double spacing = field.spacing_at(static_cast<double>(v));
    if (spacing < static_cast<double>(kLeastRowSpacingPx)) continue;
    rows += strips.width / spacing;
    count += 1.0;
  }
  return count > 0.0 ? rows / count : 0.0;
}

}  // namespace furrow::rows
