#include "rows/field_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "rows/simplex.h"

namespace furrow::rows {
namespace {

// ---- Search: rectify for a trial horizon, shear, sum along the rows
// --------------------------------------------------------------

constexpr int kBins = 256;         // across the rectified field
constexpr int kSearchStrips = 40;  // along it
constexpr double kSearchScale =
    0.30;  // strips whose spacing is below this part of the bottom one wait for the refinement
constexpr float kLevels = 64.0F;  // grey levels of a strip's standard deviation in 16-bit sums

/// Strips rectified for one convergence: every row has the same spacing in all of them.
struct Rectified {
  double convergence = 0.0, bin_px = 1.0;
  struct Line {
    double y = 0.0, weight = 1.0;
    int first = 0, last = -1;         // bins inside the picture
    std::vector<std::int16_t> value;  // 3 * kBins: zero outside the picture
  };
  std::vector<Line> lines;
};

PlanarField anchored(const Strips& strips) {
  PlanarField field;
  field.u0 = 0.5 * (strips.width - 1);
  field.v0 = strips.height - 1.0;
  field.length = strips.height;
  return field;
}

Rectified rectify(const Strips& strips, double convergence) {
  PlanarField field = anchored(strips);
  field.convergence = convergence;
  Rectified result;
  result.convergence = convergence;
  const double half_width = 0.5 * strips.width;
  const double widening = 1.0 + 1.2 * std::clamp(convergence, 0.0, 1.0);
  result.bin_px = 2.0 * half_width * widening / kBins;
  for (std::size_t j = 0; j < strips.count(); ++j) {
    const double scale = field.scale(strips.v[j]);
    if (scale < kSearchScale) continue;
    Rectified::Line line;
    line.y = field.t(strips.v[j]) / scale;
    line.weight = scale;
    line.value.assign(3 * kBins, 0);
    line.first = 3 * kBins;
    for (int i = 0; i < 3 * kBins; ++i) {
      const double x = (i - 1.5 * kBins) * result.bin_px, half = 0.5 * result.bin_px;
      const double u = field.u0 + scale * x;
      if (u < 0.0 || u > strips.width - 1.0) continue;
      const auto mean = strips.mean(j, u - scale * half, u + scale * half);
      line.value[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(
          std::lround(std::clamp(mean.value * scale, -4.0, 4.0) * static_cast<double>(kLevels)));
      line.first = std::min(line.first, i);
      line.last = i;
    }
    if (line.last >= line.first) result.lines.push_back(std::move(line));
  }
  return result;
}

struct Aligned {
  std::array<std::int16_t, kBins> sum;
  std::array<float, kBins> weight;
};

/// Sum of all lines, each shifted by slope y + bend y^2 (px).
void align(const Rectified& rectified, double slope, double bend, Aligned& out) {
  out.sum.fill(0);
  std::array<float, kBins + 1> steps{};
  for (const auto& line : rectified.lines) {
    const double shift = line.y * (slope + line.y * bend) / rectified.bin_px;
    const int offset = std::clamp(kBins + static_cast<int>(std::lround(shift)), 0, 2 * kBins);
    const std::int16_t* value = line.value.data() + offset;
    for (int i = 0; i < kBins; ++i)
      out.sum[static_cast<std::size_t>(i)] =
          static_cast<std::int16_t>(out.sum[static_cast<std::size_t>(i)] + value[i]);
    const int first = std::clamp(line.first - offset, 0, kBins),
              last = std::clamp(line.last + 1 - offset, 0, kBins);
    steps[static_cast<std::size_t>(first)] += static_cast<float>(line.weight);
    steps[static_cast<std::size_t>(last)] -= static_cast<float>(line.weight);
  }
  float weight = 0.0F;
  for (int i = 0; i < kBins; ++i) {
    weight += steps[static_cast<std::size_t>(i)];
    out.weight[static_cast<std::size_t>(i)] = weight;
  }
}

/// Variance that columns of the aligned sum explain.
float explained(const Aligned& aligned) {
  float total = 0.0F;
  for (int i = 0; i < kBins; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const float sum = static_cast<float>(aligned.sum[at]) / kLevels;
    total += sum * sum / (aligned.weight[at] + 1.0F);
  }
  return total;
}

struct Trial {
  double convergence = 0.0, slope = 0.0, bend = 0.0, spacing = 0.0, offset = 0.0, tooth = 0.3;
  double score = 0.0;
};

constexpr int kPhases = 24;

/// Epoch folding: the spacing, phase and width of the comb that explains most of an aligned profile (best
/// few).
void fold(const Aligned& aligned, double bin_px, double least_px, double most_px, Trial base,
          std::vector<Trial>& out) {
  constexpr double kRatio = 1.025;  // successive spacings; 10 rows away that is a quarter of a spacing
  std::vector<Trial> found;
  for (double spacing = least_px; spacing <= most_px; spacing *= kRatio) {
    std::array<float, 2 * kPhases> sum{}, weight{};
    float total_sum = 0.0F, total_weight = 0.0F;
    const double step = bin_px / spacing * kPhases;
    double phase = std::fmod(-0.5 * kBins * step, kPhases) + kPhases;
    for (int i = 0; i < kBins; ++i) {
      const auto bin = static_cast<std::size_t>(phase) % kPhases;
      const auto at = static_cast<std::size_t>(i);
      sum[bin] += static_cast<float>(aligned.sum[at]);
      weight[bin] += aligned.weight[at];
      phase += step;
      if (phase >= 2 * kPhases) phase -= kPhases;
    }
    for (std::size_t i = 0; i < kPhases; ++i) {
      sum[i] /= kLevels;
      sum[i + kPhases] = sum[i];
      weight[i + kPhases] = weight[i];
      total_sum += sum[i];
      total_weight += weight[i];
    }
    Trial best = base;
    best.score = 0.0;
    for (const int width : {3, 5, 8, 12}) {
      for (int first = 0; first < kPhases; ++first) {
        float in_sum = 0.0F, in_weight = 0.0F;
        for (int i = first; i < first + width; ++i) {
          in_sum += sum[static_cast<std::size_t>(i)];
          in_weight += weight[static_cast<std::size_t>(i)];
        }
        const float out_weight = total_weight - in_weight;
        if (in_weight <= 0.0F || out_weight <= 0.0F) continue;
        const float contrast = in_sum / in_weight - (total_sum - in_sum) / out_weight;
        if (contrast <= 0.0F) continue;
        const double score = static_cast<double>(contrast * contrast * in_weight * out_weight / total_weight);
        if (score <= best.score) continue;
        best.score = score;
        best.spacing = spacing;
        best.offset = (first + 0.5 * width) / kPhases * spacing;
        best.tooth = static_cast<double>(width) / kPhases;
      }
    }
    found.push_back(best);
  }
  // Local maxima over the spacing, best first.
  std::vector<Trial> peaks;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const bool is_peak = found[i].score > 0.0 && (i == 0 || found[i].score >= found[i - 1].score) &&
                         (i + 1 == found.size() || found[i].score > found[i + 1].score);
    if (is_peak) peaks.push_back(found[i]);
  }
  std::sort(peaks.begin(), peaks.end(), [](const Trial& a, const Trial& b) { return a.score > b.score; });
  constexpr std::size_t kKept = 3;
  if (peaks.size() > kKept) peaks.resize(kKept);
  out.insert(out.end(), peaks.begin(), peaks.end());
}

struct Sheared {
  float score = 0.0F;
  std::size_t rectified = 0;
  double slope = 0.0, bend = 0.0;
};

std::vector<Trial> coarse_trials(const Strips& strips) {
  static constexpr std::array kConvergences = {-0.2, 0.0,  0.15, 0.3,  0.42, 0.54, 0.64, 0.72,
                                               0.8,  0.88, 0.96, 1.06, 1.2,  1.4,  1.7,  2.1};
  std::vector<Rectified> rectified;
  std::vector<Sheared> sheared;
  Aligned aligned;
  for (const double convergence : kConvergences) {
    rectified.push_back(rectify(strips, convergence));
    const auto& lines = rectified.back().lines;
    if (lines.size() < 5) continue;
    const double depth = std::max(std::abs(lines.front().y), std::abs(lines.back().y));
    // Slopes: the vanishing point within a picture width of the picture's middle, or 60 deg from vertical in
    // a view straight down.
    const double most = std::max(std::abs(convergence) * strips.width,
                                 1.75 * strips.height * std::max(0.0, 1.0 - std::abs(convergence)));
    const double step = 3.0 * rectified.back().bin_px / depth;
    std::vector<Sheared> here;
    for (const double bend_part : {-1.0, 0.0, 1.0}) {
      const double bend = bend_part * 12.0 * rectified.back().bin_px / (depth * depth);
      const int steps = static_cast<int>(std::ceil(most / step));
      for (int i = -steps; i <= steps; ++i) {
        align(rectified.back(), i * step, bend, aligned);
        here.push_back({explained(aligned), rectified.size() - 1, i * step, bend});
      }
    }
    std::sort(here.begin(), here.end(), [](const Sheared& a, const Sheared& b) { return a.score > b.score; });
    // The best few of this convergence that differ.
    std::vector<Sheared> kept;
    for (const Sheared& one : here) {
      const bool near = std::any_of(kept.begin(), kept.end(), [&](const Sheared& other) {
        return std::abs(other.slope - one.slope) < 2.5 * step && other.bend == one.bend;
      });
      if (!near) kept.push_back(one);
      if (kept.size() >= 5) break;
    }
    sheared.insert(sheared.end(), kept.begin(), kept.end());
  }
  std::sort(sheared.begin(), sheared.end(),
            [](const Sheared& a, const Sheared& b) { return a.score > b.score; });
  constexpr std::size_t kFolded = 36;
  if (sheared.size() > kFolded) sheared.resize(kFolded);
  std::vector<Trial> trials;
  for (const Sheared& one : sheared) {
    const Rectified& source = rectified[one.rectified];
    align(source, one.slope, one.bend, aligned);
    Trial base;
    base.convergence = source.convergence;
    base.slope = one.slope;
    base.bend = one.bend;
    fold(aligned, source.bin_px, std::max(6.0, 4.0 * source.bin_px), 0.75 * strips.width, base, trials);
  }
  std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.score > b.score; });
  return trials;
}

// ---- Refinement: a smooth comb on the picture itself
// ---------------------------------------------------------------------------

constexpr double kLeastSpacingPx = 3.0,
                 kFullSpacingPx = 7.0;  // of the map: below the first rows cannot be told apart

PlanarField field_of(const PlanarField& anchor, const std::array<double, 6>& x) {
  PlanarField field = anchor;
  field.convergence = x[0];
  field.spacing = x[1];
  field.offset = x[2];
  field.slope = x[3];
  field.bend = x[4];
  field.bend2 = x[5];
  return field;
}

std::array<double, 6> parameters(const PlanarField& field) {
  return {field.convergence, field.spacing, field.offset, field.slope, field.bend, field.bend2};
}

PlanarField refine(const Strips& strips, const PlanarField& start, double tooth, double least_scale,
                   double size, bool bends, int calls, const SearchPriors& priors) {
  const auto cost = [&](const std::array<double, 6>& x) {
    const PlanarField field = field_of(start, x);
    if (field.spacing < 4.0 || field.spacing > strips.width) return 1.0;
    double penalty = 0.0;
    if (priors.horizon_v && priors.horizon_sigma) {
      const double horizon = field.horizon_v().value_or(-1e9);
      const double off = std::min(std::abs(horizon - *priors.horizon_v) / *priors.horizon_sigma, 5.0);
      penalty = 0.005 * off * off;
    }
    return penalty - comb_score(strips, field, tooth, least_scale);
  };
  // Steps that move a row by about size x spacing at the far end of the strips used.
  const double far = 1.0 / std::max(least_scale, 0.05), s = start.spacing * size;
  const double depth = std::max(1.0, (far - 1.0) / std::max(std::abs(start.convergence), 0.3));
  const std::array<double, 6> step = {0.08 * size,
                                      0.25 * s,
                                      s,
                                      1.5 * s / depth,
                                      bends ? 1.5 * s / (depth * depth) : 0.0,
                                      bends ? 1.0 * s / (depth * depth * depth) : 0.0};
  return field_of(start, minimise_simplex(cost, parameters(start), step, calls, 1e-6));
}

}  // namespace

Strips::Mean Strips::mean(std::size_t strip, double from, double to) const {
  const double a = std::clamp(from + 0.5, 0.0, static_cast<double>(width)),
               b = std::clamp(to + 0.5, 0.0, static_cast<double>(width));
  if (b - a < 1e-6) return {};
  const std::vector<float>& s = sum[strip];
  const auto at = [&](double x) {
    const auto i = std::min(static_cast<std::size_t>(x), static_cast<std::size_t>(width - 1));
    return static_cast<double>(s[i]) + (x - static_cast<double>(i)) * static_cast<double>(s[i + 1] - s[i]);
  };
  return {(at(b) - at(a)) / (b - a), (b - a) / (to - from)};
}

Strips make_strips(const GreenMap& map, int strip_height) {
  Strips strips;
  strips.width = map.width;
  strips.height = map.height;
  strip_height = std::max(1, strip_height);
  strips.strip_height = strip_height;
  const int window = std::max(4, map.width / 4);  // half the window of the local mean
  std::vector<double> running(static_cast<std::size_t>(map.width) + 1);
  for (int top = 0; top + strip_height <= map.height; top += strip_height) {
    std::vector<float> profile(static_cast<std::size_t>(map.width), 0.0F);
    for (int v = top; v < top + strip_height; ++v)
      for (int u = 0; u < map.width; ++u) profile[static_cast<std::size_t>(u)] += map.row(v)[u];
    running[0] = 0.0;
    for (std::size_t u = 0; u < profile.size(); ++u)
      running[u + 1] = running[u] + static_cast<double>(profile[u]);
    double square = 0.0;
    std::vector<float> local(profile.size());
    for (int u = 0; u < map.width; ++u) {
      const int from = std::max(0, u - window), to = std::min(map.width, u + window + 1);
      const double mean =
          (running[static_cast<std::size_t>(to)] - running[static_cast<std::size_t>(from)]) / (to - from);
      const auto at = static_cast<std::size_t>(u);
      local[at] = profile[at] - static_cast<float>(mean);
      square += static_cast<double>(local[at]) * static_cast<double>(local[at]);
    }
    const double sigma = std::sqrt(square / map.width) + 1e-3 * strip_height;
    std::vector<float> sum(profile.size() + 1, 0.0F);
    for (std::size_t u = 0; u < profile.size(); ++u) {
      const double z = static_cast<double>(local[u]) / sigma;
      local[u] = static_cast<float>(z / std::sqrt(1.0 + z * z / 9.0));
      sum[u + 1] = sum[u] + local[u];
    }
    strips.v.push_back(top + 0.5 * (strip_height - 1));
    strips.profile.push_back(std::move(local));
    strips.sum.push_back(std::move(sum));
  }
  return strips;
}

double comb_score(const Strips& strips, const PlanarField& field, double tooth, double least_scale) {
  double total = 0.0;
  const double gain = std::sqrt(tooth * (1.0 - tooth));
  for (std::size_t j = 0; j < strips.count(); ++j) {
    const double v = strips.v[j], scale = field.scale(v);
    if (scale < least_scale) continue;
    const double spacing = field.spacing * scale;
    if (spacing <= kLeastSpacingPx) continue;
    const double fade = std::min(1.0, (spacing - kLeastSpacingPx) / (kFullSpacingPx - kLeastSpacingPx));
    const double centre = field.u_at(v, 0.0), half = 0.5 * tooth * spacing;
    const int first = static_cast<int>(std::floor(-centre / spacing)),
              last = static_cast<int>(std::ceil((strips.width - 1.0 - centre) / spacing));
    double in = 0.0, in_weight = 0.0, out = 0.0, out_weight = 0.0;
    for (int k = first; k <= last; ++k) {
      const double u = centre + k * spacing;
      const auto row = strips.mean(j, u - half, u + half);
      const auto alley = strips.mean(j, u + 0.5 * spacing - half, u + 0.5 * spacing + half);
      in += row.value * row.weight;
      in_weight += row.weight;
      out += alley.value * alley.weight;
      out_weight += alley.weight;
    }
    if (in_weight <= 0.0 || out_weight <= 0.0) continue;
    total += fade * gain * (in / in_weight - out / out_weight);
  }
  return total / static_cast<double>(strips.count());
}

std::optional<FoundField> search_field(const GreenMap& map, const SearchPriors& priors) {
  if (map.width < 24 || map.height < 16) return std::nullopt;
  const Strips coarse = make_strips(map, std::max(1, map.height / kSearchStrips));
  std::vector<Trial> trials = coarse_trials(coarse);
  if (trials.empty()) return std::nullopt;
  constexpr std::size_t kRefined = 10;
  std::vector<FoundField> found;
  const auto take = [&](const Trial& trial) {
    PlanarField field = anchored(coarse);
    field.convergence = trial.convergence;
    field.spacing = trial.spacing;
    field.offset = trial.offset;
    field.slope = trial.slope;
    field.bend = trial.bend;
    const double tooth = std::clamp(trial.tooth, 0.2, 0.5);
    field = refine(coarse, field, tooth, 0.3, 0.25, true, 120, priors);
    FoundField one{field, tooth, comb_score(coarse, field, tooth, 0.1), 0.0};
    found.push_back(one);
  };
  for (std::size_t i = 0; i < std::min(kRefined, trials.size()); ++i) take(trials[i]);
  std::sort(found.begin(), found.end(),
            [](const FoundField& a, const FoundField& b) { return a.score > b.score; });
  constexpr std::size_t kFinished = 3;
  if (found.size() > kFinished) found.resize(kFinished);
  const Strips fine = make_strips(map, 3);
  for (FoundField& one : found) {
    for (const double least_scale : {0.2, 0.12, 0.05})
      one.field = refine(fine, one.field, one.tooth, least_scale, 0.12, true, 150, priors);
    for (const double tooth : {0.12, 0.2, 0.3, 0.42, 0.55}) {
      const double score = comb_score(fine, one.field, tooth, 0.05);
      if (score > one.score || tooth == 0.12) one.score = score, one.tooth = tooth;
    }
    one.field = refine(fine, one.field, one.tooth, 0.05, 0.05, true, 200, priors);
    one.score = comb_score(fine, one.field, one.tooth, 0.05);
  }
  return *std::max_element(found.begin(), found.end(),
                           [](const FoundField& a, const FoundField& b) { return a.score < b.score; });
}

}  // namespace furrow::rows
