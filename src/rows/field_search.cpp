#include "rows/field_search.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rows/coarse_search.h"
#include "rows/simplex.h"

namespace furrow::rows {
namespace {

using Parameters = std::array<double, 6>;

PlanarField field_of(const PlanarField& anchor, const Parameters& x) {
  PlanarField field = anchor;
  field.convergence = x[0];
  field.spacing = x[1];
  field.offset = x[2];
  field.slope = x[3];
  field.bend = x[4];
  field.bend2 = x[5];
  return field;
}

Parameters parameters(const PlanarField& field) {
  return {field.convergence, field.spacing, field.offset, field.slope, field.bend, field.bend2};
}

/// Rows bend gently. With depth along the rows measured in spacings, z = y L / spacing, a row departs from
/// its tangent by c2 z^2 + c3 z^3 spacings; these are the one-sigma of c2 and c3 (c2 = 0.012: a radius of 40
/// spacings). The weight is in units of the score.
constexpr double kBendSigma = 0.012, kBend2Sigma = 6e-4, kBendWeight = 0.008;

double bend_cost(const PlanarField& field) {
  const double depth = field.length / field.spacing;
  const double c2 = field.bend / (field.spacing * depth * depth),
               c3 = field.bend2 / (field.spacing * depth * depth * depth);
  return kBendWeight * (c2 * c2 / (kBendSigma * kBendSigma) + c3 * c3 / (kBend2Sigma * kBend2Sigma));
}

/// A horizon that is known pulls softly: at most as much as a tenth of a clear picture's score.
double horizon_cost(const PlanarField& field, const SearchPriors& priors) {
  if (!priors.horizon_v || !priors.horizon_sigma) return 0.0;
  constexpr double kWeight = 0.005, kMostSigmas = 3.0;
  const double horizon = field.horizon_v().value_or(-1e9);
  const double off = std::min(std::abs(horizon - *priors.horizon_v) / *priors.horizon_sigma, kMostSigmas);
  return kWeight * off * off;
}

/// A simplex whose scores differ by less has arrived; trials that decide differ by 0.01.
constexpr double kScoreTolerance = 1e-4;

bool is_allowed(const PlanarField& field, int width) {
  constexpr double kLeastSpacingPx = 4.0;
  return field.spacing >= kLeastSpacingPx && field.spacing <= width;
}

/// Steps of a simplex of some size: they move rows by about that many spacings where the spacing is
/// `least_scale` of the bottom one.
Parameters steps_of(const PlanarField& field, double least_scale, double size) {
  const double far = 1.0 / std::max(least_scale, 0.05), s = field.spacing * size;
  const double depth = std::max(1.0, (far - 1.0) / std::max(std::abs(field.convergence), 0.3));
  return {0.08 * size, 0.25 * s, s, 1.5 * s / depth, 1.5 * s / (depth * depth), s / (depth * depth * depth)};
}

/// Better parameters near `start`. `size` is the simplex's size: it moves rows at the far end of the strips
/// by about that many spacings.
PlanarField refine(const Response& response, const PlanarField& start, const Emphasis& emphasis, double size,
                   int calls, const SearchPriors& priors) {
  const auto cost = [&](const Parameters& x) {
    const PlanarField field = field_of(start, x);
    if (!is_allowed(field, response.width)) return 1.0;
    return bend_cost(field) + horizon_cost(field, priors) - comb_score(response, field, emphasis);
  };
  const Parameters step = steps_of(start, emphasis.least_scale, size);
  return field_of(start, minimise_simplex(cost, parameters(start), step, calls, kScoreTolerance));
}

// ---- The whole search
// ------------------------------------------------------------------------------------------------------------

constexpr int kCoarseStrips = 40, kFineStrips = 80;  // of a picture, for trials and for the end
constexpr int kTrialCalls = 90;                      // of the score, per refined trial

bool is_too_small(const GreenMap& map) {
  constexpr int kLeastWidth = 24, kLeastHeight = 16;  // px: fewer hold no pattern
  return map.width < kLeastWidth || map.height < kLeastHeight;
}

double best_tooth(const Strips& strips, const PlanarField& field) {
  double tooth = 0.3, score = -1.0;
  for (const double width : {0.12, 0.2, 0.3, 0.42, 0.55, 0.72}) {
    const double one = comb_score(strips, field, width, {});
    if (one > score) score = one, tooth = width;
  }
  return tooth;
}

/// Coarse trials refined on coarse strips; the best few that differ.
std::vector<FoundField> refine_trials(const Strips& strips, const std::vector<Trial>& trials,
                                      const SearchPriors& priors) {
  constexpr std::size_t kTried = 8, kKept = 2;
  std::vector<FoundField> found;
  for (std::size_t i = 0; i < std::min(kTried, trials.size()); ++i) {
    FoundField one;
    one.tooth = std::clamp(trials[i].tooth, 0.2, 0.72);
    one.field = refine(respond(strips, trials[i].field, one.tooth), trials[i].field, {.least_scale = 0.3},
                       0.25, kTrialCalls, priors);
    one.score = comb_score(strips, one.field, one.tooth, {.least_scale = 0.1}) *
                evidence_part(mean_row_count(strips, one.field));
    found.push_back(one);
  }
  std::sort(found.begin(), found.end(),
            [](const FoundField& a, const FoundField& b) { return a.score > b.score; });
  if (found.size() > kKept) found.resize(kKept);
  return found;
}

/// From the near part of the field to the far one.
void grow(const Strips& coarse, const Strips& strips, const SearchPriors& priors, FoundField& found) {
  constexpr int kCalls = 110;
  for (const double least_scale : {0.2, 0.05}) {
    const Response response = respond(strips, found.field, found.tooth);
    found.field = refine(response, found.field, {.least_scale = least_scale}, 0.12, kCalls, priors);
  }
  found.tooth = best_tooth(coarse, found.field);
  found.field = refine(respond(strips, found.field, found.tooth), found.field, {}, 0.05, kCalls, priors);
  found.score =
      comb_score(strips, found.field, found.tooth, {}) * evidence_part(mean_row_count(strips, found.field));
}

/// Two fields of twice the spacing whose places, together, are those of `field` moved by `moved` spacings.
std::array<PlanarField, 2> every_second(const PlanarField& field, double moved) {
  std::array<PlanarField, 2> halves = {field, field};
  for (PlanarField& half : halves) half.spacing = 2.0 * field.spacing, half.offset += moved * field.spacing;
  halves[1].offset += field.spacing;
  return halves;
}

/// Near rows decide: of far ones the alleys are not seen.
Emphasis near_rows(const Strips& strips, const PlanarField& field, double reach) {
  return {.centre_k = field.k_at(field.u0, 0.7 * strips.height), .reach = reach};
}

void double_spacing(const Strips& strips, const PlanarField& doubled, double tooth, FoundField& found) {
  if (doubled.spacing_at(0.5 * strips.height) > 0.6 * strips.width) return;
  found.field = doubled;
  found.tooth = tooth;
  found.score = comb_score(strips, doubled, tooth, {}) * evidence_part(mean_row_count(strips, doubled));
}

/// A field has half the true spacing when it shows rows at every second of its places only, or when
/// every second pair of its rows has hardly an alley between: these are the two sides of one row, where grass
/// is greener than its leaves. The doubled field must then explain more near the middle.
void undo_half_spacing(const Strips& strips, FoundField& found) {
  constexpr double kAbsent = 0.2;  // of the response of the rows, or alleys, that are there
  const Response response = respond(strips, found.field, found.tooth);
  const auto rows = every_second(found.field, 0.0), alleys = every_second(found.field, 0.5);
  const std::array row = {comb_score(response, rows[0], {}), comb_score(response, rows[1], {})};
  if (std::min(row[0], row[1]) <= kAbsent * std::max(row[0], row[1]))
    return double_spacing(strips, rows[row[0] > row[1] ? 0 : 1], std::max(0.12, 0.5 * found.tooth), found);
  constexpr double kWeak = 0.5;   // between two strips of grass the leaves are less green, but no alley
  constexpr double kReach = 1.0;  // rows
  std::array<double, 2> alley{};  // how much less green they are
  for (std::size_t i = 0; i < 2; ++i)
    alley[i] = -comb_score(response, alleys[i], near_rows(strips, alleys[i], kReach));
  if (std::max(alley[0], alley[1]) <= 0.0 ||
      std::min(alley[0], alley[1]) > kWeak * std::max(alley[0], alley[1]))
    return;
  const PlanarField& doubled = alleys[alley[0] < alley[1] ? 0 : 1];
  const double tooth = 0.5 * (1.0 + found.tooth);  // from side to side
  if (comb_score(strips, doubled, tooth, near_rows(strips, doubled, kReach)) >
      comb_score(strips, found.field, found.tooth, near_rows(strips, found.field, 2.0 * kReach)))
    double_spacing(strips, doubled, tooth, found);
}

// ---- Is it right?
// ----------------------------------------------------------------------------------------------

/// dv/du of the horizon with which the field explains clearly more, else 0. Rows to the left and right of the
/// middle fan out unevenly under a roll.
double tilt_of(const Strips& strips, const FoundField& found) {
  constexpr double kTiltSigma = 0.15, kTiltWeight = 0.002;  // of the score: few rows tell no tilt
  constexpr double kLeastTilt = 0.02;                       // a degree
  constexpr double kPromising = 0.03, kLeastGain = 0.13;    // of the score
  constexpr int kRounds = 2, kCalls = 150;                  // a simplex that has shrunk too early starts anew
  const Response response = respond(strips, found.field, found.tooth);
  const auto cost = [&](const std::array<double, 7>& x) {
    const PlanarField field = field_of(found.field, {x[0], x[1], x[2], x[3], x[4], x[5]});
    if (!is_allowed(field, response.width)) return 1.0;
    return bend_cost(field) + kTiltWeight * x[6] * x[6] / (kTiltSigma * kTiltSigma) -
           comb_score(response, field, {.tilt = x[6]});
  };
  const Parameters x = parameters(found.field), step = steps_of(found.field, 0.05, 0.08);
  std::array<double, 7> start{}, steps{};
  std::copy(x.begin(), x.end(), start.begin());
  std::copy(step.begin(), step.end(), steps.begin());
  steps[6] = 0.06;
  const double before = cost(start);
  auto tilted = start;
  double gain = 0.0;
  for (int round = 0; round < kRounds && gain >= round * kPromising * found.score; ++round) {
    tilted = minimise_simplex(cost, tilted, steps, kCalls, kScoreTolerance);
    gain = before - cost(tilted);
  }
  return std::abs(tilted[6]) > kLeastTilt && gain > kLeastGain * found.score ? tilted[6] : 0.0;
}

/// Mean response over a window of one strip at `first` and every `spacing` on, lowered where few rows carry
/// it.
double window_response(const Response& response, std::size_t j, double first, double spacing, double to) {
  double sum = 0.0;
  int count = 0;
  for (double u = first; u <= to; u += spacing, ++count)
    sum += static_cast<double>(response.at(j, static_cast<float>(u)));
  return count > 0 ? sum / count * evidence_part(0.5 * response.width / spacing) : 0.0;
}

/// FoundField::explained: what the field's rows respond in half strips, over what equally spaced rows of any
/// spacing and phase would respond there.
double explained_part(const Strips& all, const FoundField& found) {
  constexpr std::size_t kEvery = 4;  // strips
  constexpr double kClear = 0.3;     // noise finds itself a comb of 0.2 to 0.27
  constexpr double kRatio = 1.08, kPhases = 10.0;
  constexpr double kLeastScale = 0.15, kLeastPx = 4.0;
  Strips strips;
  strips.width = all.width, strips.height = all.height;
  for (std::size_t j = 0; j < all.count(); j += kEvery) {
    const double v = static_cast<double>(all.v[j]);
    if (found.field.scale(v) < kLeastScale || found.field.spacing_at(v) < kLeastPx) continue;
    strips.v.push_back(all.v[j]);
    const auto from = all.sum.begin() + static_cast<std::ptrdiff_t>(j * all.stride());
    strips.sum.insert(strips.sum.end(), from, from + static_cast<std::ptrdiff_t>(all.stride()));
  }
  constexpr std::array kWindows = {0.0, 0.25, 0.5};  // where half strips begin
  std::vector<std::array<double, kWindows.size()>> best(strips.count());
  PlanarField level = anchored(strips);
  for (level.spacing = kLeastPx; level.spacing < 0.25 * strips.width; level.spacing *= kRatio) {
    const Response response = respond(strips, level, found.tooth);
    for (std::size_t j = 0; j < strips.count(); ++j) {
      for (std::size_t w = 0; w < kWindows.size(); ++w) {
        const double from = kWindows[w] * strips.width, to = from + 0.5 * strips.width;
        for (double phase = 0.0; phase < 1.0; phase += 1.0 / kPhases)
          best[j][w] = std::max(
              best[j][w], window_response(response, j, from + phase * level.spacing, level.spacing, to));
      }
    }
  }
  const Response response = respond(strips, found.field, found.tooth);
  double free_sum = 0.0, sum = 0.0;
  for (std::size_t j = 0; j < strips.count(); ++j) {
    const double v = static_cast<double>(strips.v[j]), spacing = found.field.spacing_at(v),
                 zero = found.field.u_at(v, 0.0);
    for (std::size_t w = 0; w < kWindows.size(); ++w) {
      const double from = kWindows[w] * strips.width,
                   first = zero + std::ceil((from - zero) / spacing) * spacing;
      sum += window_response(response, j, first, spacing, from + 0.5 * strips.width);
      free_sum += best[j][w];
    }
  }
  const double windows = static_cast<double>(strips.count() * kWindows.size());
  return free_sum > kClear * windows ? std::clamp(sum / free_sum, 0.0, 1.0) : 1.0;
}

/// The rows nearest the picture's middle decide at the end: passes of the planter lie apart by a little more
/// or less than a spacing, so far rows pull the model off the near ones.
void settle(const Strips& strips, const SearchPriors& priors, FoundField& found) {
  constexpr double kReach = 2.0;  // rows
  constexpr int kCalls = 100;
  const Emphasis near = near_rows(strips, found.field, kReach);
  const auto settled = [&](const PlanarField& field) {
    return refine(respond(strips, field, found.tooth), field, near, 0.05, kCalls, priors);
  };
  const auto score = [&](const PlanarField& field) {
    return comb_score(strips, field, found.tooth, near) - bend_cost(field);
  };
  found.field = settled(found.field);
  // Bends that a slip by half a row at the far end brought about go away when the rows start straight.
  PlanarField straight = found.field;
  straight.bend = straight.bend2 = 0.0;
  straight = settled(straight);
  if (score(straight) > score(found.field)) found.field = straight;
  found.followed = follow(respond(strips, found.field, found.tooth), found.field, std::round(near.centre_k),
                          kReach);
}

}  // namespace

std::optional<FoundField> continue_field(const GreenMap& map, const FoundField& before,
                                         const SearchPriors& priors) {
  constexpr double kKeptScore =
      0.7;  // of the score before; a picture a moment later differs by a few percent
  if (is_too_small(map)) return std::nullopt;
  const Strips coarse = make_strips(map, std::max(1, map.height / kCoarseStrips));
  const Strips fine = make_strips(map, std::max(1, map.height / kFineStrips));
  FoundField best;
  best.score = -1.0;
  // Between two shots the camera moves sideways by a part of a spacing.
  for (const double moved : {0.0, -0.3, 0.3}) {
    FoundField one = before;
    one.field.offset += moved * one.field.spacing;
    one.field = refine(respond(coarse, one.field, one.tooth), one.field, {.least_scale = 0.2}, 0.1,
                       kTrialCalls, priors);
    one.score = comb_score(coarse, one.field, one.tooth, {});
    if (one.score > best.score) best = one;
  }
  grow(coarse, fine, priors, best);
  if (best.score < kKeptScore * before.score) return std::nullopt;
  settle(fine, priors, best);
  return best;
}

double promise_of(const GreenMap& map) {
  constexpr int kQuickStrips = 24;
  if (is_too_small(map)) return 0.0;
  const std::vector<Trial> trials = coarse_search(make_strips(map, std::max(1, map.height / kQuickStrips)));
  return trials.empty() ? 0.0 : trials.front().score;
}

std::optional<FoundField> search_field(const GreenMap& map, const SearchPriors& priors) {
  if (is_too_small(map)) return std::nullopt;
  const Strips coarse = make_strips(map, std::max(1, map.height / kCoarseStrips));
  const std::vector<Trial> trials = coarse_search(coarse);
  std::vector<FoundField> found = refine_trials(coarse, trials, priors);
  if (found.empty()) return std::nullopt;
  const Strips fine = make_strips(map, std::max(1, map.height / kFineStrips));
  for (FoundField& one : found) grow(coarse, fine, priors, one);
  FoundField best = *std::max_element(
      found.begin(), found.end(), [](const FoundField& a, const FoundField& b) { return a.score < b.score; });
  undo_half_spacing(fine, best);
  constexpr double kBeyondDoubt = 0.5;  // of the score: the field explains nearly all
  best.tilt = tilt_of(coarse, best);
  if (best.score < kBeyondDoubt) best.explained = explained_part(coarse, best);
  settle(fine, priors, best);
  return best;
}

}  // namespace furrow::rows
