#include "rows/coarse_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "furrow/base/whole.h"

namespace furrow::rows {
namespace {

constexpr std::size_t kBins = 224;  // across the rectified field
/// Strips whose spacing is below this part of the bottom one wait for the refinement: small errors of the
/// horizon tear them apart.
constexpr double kLeastScale = 0.30;
constexpr float kLevels = 64.0F;  // levels of a strip's standard deviation in the 16-bit sums

/// Horizons tried, as convergences: denser where the horizon is near the picture's top, since there it
/// matters most.
constexpr std::array kConvergences = {-0.15, 0.0, 0.2, 0.38, 0.54, 0.67, 0.78, 0.88, 0.98, 1.12, 1.4, 1.9};

constexpr double kSteepestTan = 1.75;  // rows up to 60 deg from vertical in a view straight down

/// One strip as seen when every row has the spacing of the bottom one.
struct Line {
  double y = 0.0;
  float weight = 1.0F;                          // px of the picture per bin, relative
  int first = 0, last = -1;                     // bins inside the picture
  std::array<std::int16_t, 3 * kBins> value{};  // zero outside
};

struct Rectified {
  double convergence = 0.0, bin_px = 1.0, rows_times_spacing = 1.0;
  std::vector<Line> lines;
};

Line rectified_line(const Strips& strips, std::size_t j, const PlanarField& field, double bin_px) {
  const double v = static_cast<double>(strips.v[j]), scale = field.scale(v);
  Line line;
  line.y = field.t(v) / scale;
  line.weight = static_cast<float>(scale);
  // Bin i covers u0 + scale (i - 1.5 kBins +- 0.5) bin_px.
  const double u_per_bin = scale * bin_px, u_of_zero = field.u0 - 1.5 * kBins * u_per_bin;
  constexpr int kAll = static_cast<int>(3 * kBins);
  line.first = base::ceil_between(-u_of_zero / u_per_bin, 0, kAll);
  line.last = base::floor_between((strips.width - 1.0 - u_of_zero) / u_per_bin, -1, kAll - 1);
  const float* running = strips.running(j);
  const float levels = kLevels * static_cast<float>(1.0 / bin_px), step = static_cast<float>(u_per_bin);
  const auto sum_at = [&](float x) {
    const float whole = std::floor(x);
    const float* from = running + static_cast<int>(whole);
    return from[0] + (x - whole) * (from[1] - from[0]);
  };
  float border = static_cast<float>(u_of_zero + (line.first - 0.5) * u_per_bin) + 0.5F,
        before = sum_at(border);
  for (int i = line.first; i <= line.last; ++i) {
    border += step;
    const float after = sum_at(border);
    line.value[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(levels * (after - before));
    before = after;
  }
  return line;
}

Rectified rectify(const Strips& strips, double convergence) {
  PlanarField field = anchored(strips);
  field.convergence = convergence;
  Rectified result;
  result.convergence = convergence;
  result.bin_px = strips.width * (1.0 + 1.2 * std::clamp(convergence, 0.0, 1.0)) / static_cast<double>(kBins);
  double inverse = 0.0;
  for (std::size_t j = 0; j < strips.count(); ++j) {
    const double scale = field.scale(static_cast<double>(strips.v[j]));
    if (scale < kLeastScale) continue;
    result.lines.push_back(rectified_line(strips, j, field, result.bin_px));
    inverse += 1.0 / scale;
  }
  result.rows_times_spacing =
      strips.width * inverse / std::max(1.0, static_cast<double>(result.lines.size()));
  return result;
}

/// Sum of all lines, each shifted by slope y.
struct Aligned {
  std::array<float, kBins> sum;  // in levels
  std::array<float, kBins> weight;
};

void align(const Rectified& rectified, double slope, Aligned& out) {
  std::array<float, kBins + 1> steps{};
  constexpr int bins = static_cast<int>(kBins);
  constexpr std::size_t kMostLines = 80;  // make_strips at a fortieth of the height gives at most 79
  std::array<const std::int16_t*, kMostLines> values{};
  const std::size_t lines = std::min(rectified.lines.size(), kMostLines);
  for (std::size_t j = 0; j < lines; ++j) {
    const Line& line = rectified.lines[j];
    const double shift = line.y * slope / rectified.bin_px;
    const int offset = static_cast<int>(std::clamp(shift + bins + 0.5, 0.0, 2.0 * bins));
    values[j] = line.value.data() + offset;
    steps[static_cast<std::size_t>(std::clamp(line.first - offset, 0, bins))] += line.weight;
    steps[static_cast<std::size_t>(std::clamp(line.last + 1 - offset, 0, bins))] -= line.weight;
  }
  // In blocks that stay in registers: this is the most of the search.
  constexpr std::size_t kLanes = 8, kBlock = 4 * kLanes;
  using Lanes [[gnu::vector_size(16)]] = std::int16_t;
  static_assert(kBins % kBlock == 0 && sizeof(Lanes) == kLanes * sizeof(std::int16_t));
  for (std::size_t from = 0; from < kBins; from += kBlock) {
    Lanes a{}, b{}, c{}, d{};
    for (std::size_t j = 0; j < lines; ++j) {
      std::array<Lanes, 4> in;
      std::memcpy(in.data(), values[j] + from, sizeof in);
      a += in[0], b += in[1], c += in[2], d += in[3];
    }
    const std::array<Lanes, 4> sums = {a, b, c, d};
    std::array<std::int16_t, kBlock> whole;
    std::memcpy(whole.data(), sums.data(), sizeof sums);
    for (std::size_t i = 0; i < kBlock; ++i) out.sum[from + i] = static_cast<float>(whole[i]) / kLevels;
  }
  float weight = 0.0F;
  for (std::size_t i = 0; i < kBins; ++i) out.weight[i] = weight += steps[i];
}

/// Variance that the columns of the aligned sum explain.
float explained(const Aligned& aligned) {
  std::array<float, 8> total{};
  for (std::size_t i = 0; i < kBins; i += total.size()) {
    for (std::size_t k = 0; k < total.size(); ++k)
      total[k] += aligned.sum[i + k] * aligned.sum[i + k] / (aligned.weight[i + k] + 1.0F);
  }
  float all = 0.0F;
  for (const float part : total) all += part;
  return all;
}

struct Sheared {
  float score = 0.0F;
  std::size_t rectified = 0;
  double slope = 0.0;
};

/// The best few that differ in slope by `apart`.
std::vector<Sheared> best_of(std::vector<Sheared> all, double apart, std::size_t most) {
  std::sort(all.begin(), all.end(), [](const Sheared& a, const Sheared& b) { return a.score > b.score; });
  std::vector<Sheared> kept;
  for (const Sheared& one : all) {
    const bool is_near = std::any_of(kept.begin(), kept.end(), [&](const Sheared& other) {
      return std::abs(other.slope - one.slope) < apart;
    });
    if (!is_near) kept.push_back(one);
    if (kept.size() >= most) break;
  }
  return kept;
}

/// The best few shears of one rectification.
std::vector<Sheared> best_shears(const Strips& strips, const Rectified& rectified, std::size_t number) {
  constexpr std::size_t kKept = 4;
  const double depth = std::max(std::abs(rectified.lines.front().y), std::abs(rectified.lines.back().y));
  // Slopes: the vanishing point within a picture's width of its middle, or rows up to the steepest in a view
  // straight down.
  const double g = std::abs(rectified.convergence);
  const double most = std::max(g * strips.width, kSteepestTan * strips.height * std::max(0.0, 1.0 - g));
  const double step = 4.0 * rectified.bin_px / depth;  // the farthest strip moves by four bins
  const int steps = static_cast<int>(std::ceil(most / step));
  Aligned aligned;
  std::vector<Sheared> all;
  for (int i = -steps; i <= steps; ++i) {
    align(rectified, i * step, aligned);
    all.push_back({explained(aligned), number, i * step});
  }
  return best_of(std::move(all), 2.5 * step, kKept);
}

constexpr std::size_t kPhases = 24;

struct Folded {
  double score = 0.0, offset = 0.0, tooth = 0.3;
};

/// Sums over one period, twice over and running, so that a tooth may wrap: before[i] is the sum of all phases
/// before i.
struct Period {
  std::array<float, 2 * kPhases + 1> sum_before{}, weight_before{};
};

Period period_of(const Aligned& aligned, double bin_px, double spacing) {
  std::array<float, kPhases> sum{}, weight{};
  // Phases as 16.16 fixed point of a period: they wrap by themselves.
  const double start = -0.5 * static_cast<double>(kBins) * bin_px / spacing;
  auto phase = static_cast<std::uint32_t>(std::llround((start - std::floor(start)) * 65536.0) * 65536);
  const auto step = static_cast<std::uint32_t>(std::llround(bin_px / spacing * 4294967296.0));
  for (std::size_t i = 0; i < kBins; ++i, phase += step) {
    const std::size_t bin = (static_cast<std::uint64_t>(phase) * kPhases) >> 32U;
    sum[bin] += aligned.sum[i];
    weight[bin] += aligned.weight[i];
  }
  Period period;
  for (std::size_t i = 0; i < kPhases; ++i) {
    period.sum_before[i + 1] = period.sum_before[i] + sum[i];
    period.weight_before[i + 1] = period.weight_before[i] + weight[i];
  }
  for (std::size_t i = 1; i <= kPhases; ++i) {
    period.sum_before[kPhases + i] = period.sum_before[kPhases] + period.sum_before[i];
    period.weight_before[kPhases + i] = period.weight_before[kPhases] + period.weight_before[i];
  }
  return period;
}

/// What a tooth of `width` phases explains from each first phase on. Contrast c between tooth and rest
/// explains c^2 in out / total; written without the divisions that cancel, four phases at once.
std::array<float, kPhases> explained_by_tooth(const Period& period, std::size_t width) {
  using Lanes [[gnu::vector_size(16)]] = float;
  constexpr std::size_t kLanes = 4;
  static_assert(kPhases % kLanes == 0 && sizeof(Lanes) == kLanes * sizeof(float));
  const auto between = [&](const auto& before, std::size_t first) {
    Lanes from, to;
    std::memcpy(&from, before.data() + first, sizeof from);
    std::memcpy(&to, before.data() + first + width, sizeof to);
    return to - from;
  };
  const float total_sum = period.sum_before[kPhases], total_weight = period.weight_before[kPhases];
  std::array<float, kPhases> score;
  for (std::size_t first = 0; first < kPhases; first += kLanes) {
    const Lanes in_weight = between(period.weight_before, first);
    const Lanes contrast = between(period.sum_before, first) * total_weight - total_sum * in_weight;
    const Lanes excess = contrast > 0.0F ? contrast : Lanes{};
    const Lanes lanes = excess * excess / (in_weight * (total_weight - in_weight) * total_weight + 1e-3F);
    std::memcpy(score.data() + first, &lanes, sizeof lanes);
  }
  return score;
}

/// Folds an aligned sum over one spacing; the phase and width of the tooth that explain most.
Folded fold(const Aligned& aligned, double bin_px, double spacing) {
  const Period period = period_of(aligned, bin_px, spacing);
  Folded best;
  float best_score = 0.0F;
  for (const std::size_t width : {3, 6, 11, 17}) {
    const std::array<float, kPhases> score = explained_by_tooth(period, width);
    const auto top = std::max_element(score.begin(), score.end());
    if (*top <= best_score) continue;
    best_score = *top;
    best.offset = (static_cast<double>(top - score.begin()) + 0.5 * static_cast<double>(width)) /
                  static_cast<double>(kPhases) * spacing;
    best.tooth = static_cast<double>(width) / static_cast<double>(kPhases);
  }
  best.score = static_cast<double>(best_score);
  return best;
}

/// Spacings to try, px on the bottom row. Each moves the rows at the border by a quarter of a spacing against
/// the one before, or those six rows from the middle where there are more.
std::vector<double> spacings_to_try(double bin_px, int width) {
  constexpr double kQuarter = 0.25, kLeastStep = 0.04;
  const double half = 0.5 * static_cast<double>(kBins) * bin_px;
  const double most = 0.75 * width;
  std::vector<double> spacings;
  double spacing = std::max(6.0, 2.5 * bin_px);
  while (spacing <= most) {
    spacings.push_back(spacing);
    spacing *= 1.0 + std::max(kLeastStep, kQuarter * spacing / half);
  }
  return spacings;
}

/// The best few spacings for one shear.
void fold_all(const Strips& strips, const Rectified& rectified, const Sheared& sheared,
              std::vector<Trial>& trials) {
  Aligned aligned;
  align(rectified, sheared.slope, aligned);
  const std::vector<double> spacings = spacings_to_try(rectified.bin_px, strips.width);
  std::vector<Folded> folded;
  for (const double spacing : spacings) {
    folded.push_back(fold(aligned, rectified.bin_px, spacing));
    const double weight = evidence_part(rectified.rows_times_spacing / spacing);
    folded.back().score *= weight * weight;  // a score of squares
  }
  std::vector<Trial> peaks;
  for (std::size_t i = 0; i < folded.size(); ++i) {
    const bool is_peak = folded[i].score > 0.0 && (i == 0 || folded[i].score >= folded[i - 1].score) &&
                         (i + 1 == folded.size() || folded[i].score > folded[i + 1].score);
    if (!is_peak) continue;
    Trial trial;
    trial.field = anchored(strips);
    trial.field.convergence = rectified.convergence;
    trial.field.slope = sheared.slope;
    trial.field.spacing = spacings[i];
    trial.field.offset = folded[i].offset;
    trial.tooth = folded[i].tooth;
    trial.score = folded[i].score;
    peaks.push_back(trial);
  }
  std::sort(peaks.begin(), peaks.end(), [](const Trial& a, const Trial& b) { return a.score > b.score; });
  constexpr std::size_t kKept = 3;
  trials.insert(trials.end(), peaks.begin(),
                peaks.begin() + static_cast<std::ptrdiff_t>(std::min(kKept, peaks.size())));
}

/// Folds where columns differ most, until what is left cannot come among the best `most`: a fold explains a
/// part of what the columns do.
std::vector<Trial> best_trials(const Strips& strips, const std::vector<Rectified>& rectified,
                               const std::vector<Sheared>& sheared) {
  constexpr std::size_t kFolded = 32, kBest = 8;
  constexpr double kMostPart = 0.6;  // 0.45 on clear pictures
  std::vector<Trial> trials;
  for (std::size_t i = 0; i < std::min(kFolded, sheared.size()); ++i) {
    if (trials.size() >= kBest && trials[kBest - 1].score > kMostPart * static_cast<double>(sheared[i].score))
      break;
    fold_all(strips, rectified[sheared[i].rectified], sheared[i], trials);
    std::sort(trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.score > b.score; });
  }
  return trials;
}

}  // namespace

double evidence_part(double row_count) {
  const double rows = std::max(1.0, row_count);
  return (rows - 1.0) / rows;
}

PlanarField anchored(const Strips& strips) {
  PlanarField field;
  field.u0 = 0.5 * (strips.width - 1);
  field.v0 = strips.height - 1.0;
  field.length = strips.height;
  return field;
}

std::vector<Trial> coarse_search(const Strips& strips) {
  std::vector<Rectified> rectified;
  std::vector<Sheared> sheared;
  for (const double convergence : kConvergences) {
    Rectified one = rectify(strips, convergence);
    constexpr std::size_t kLeastLines = 5;  // fewer strips align to anything
    if (one.lines.size() < kLeastLines) continue;
    const auto best = best_shears(strips, one, rectified.size());
    sheared.insert(sheared.end(), best.begin(), best.end());
    rectified.push_back(std::move(one));
  }
  std::sort(sheared.begin(), sheared.end(),
            [](const Sheared& a, const Sheared& b) { return a.score > b.score; });
  return best_trials(strips, rectified, sheared);
}

}  // namespace furrow::rows
