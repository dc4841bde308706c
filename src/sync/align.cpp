#include "furrow/sync/align.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "furrow/base/text.h"
#include "furrow/sync/locate.h"

namespace furrow::sync {
namespace {

using base::Nanoseconds;
using telemetry::Sample;
using telemetry::Track;

constexpr Nanoseconds kStep_ns = base::kNanosecondsPerSecond / 10;
/// Rows of a clip closer than this say the same thing twice (its position is renewed 1 to 10 times a second).
constexpr Nanoseconds kRowSpacing_ns = base::kNanosecondsPerSecond / 2;
constexpr Nanoseconds kRunnerUpDistance_ns = 2 * base::kNanosecondsPerSecond;
/// A log of a day in steps of 0.1 s.
constexpr std::size_t kMostSteps = 864'000;

/// The log every kStep_ns from its first row on.
struct Grid {
  Nanoseconds start_ns = 0;
  std::vector<double> height_m, speed_mps;
};

Grid resample(const Track& log) {
  Grid grid;
  grid.start_ns = log.samples.front().t_log_ns;
  const auto steps = static_cast<std::size_t>((log.samples.back().t_log_ns - grid.start_ns) / kStep_ns) + 1;
  for (std::size_t i = 0; i < std::min(steps, kMostSteps); ++i) {
    const auto state = interpolate(log, grid.start_ns + static_cast<Nanoseconds>(i) * kStep_ns);
    grid.height_m.push_back(state ? state->height_takeoff_m : telemetry::kMissing);
    grid.speed_mps.push_back(state ? state->speed_mps : telemetry::kMissing);
  }
  return grid;
}

/// The clip's rows that are compared, each at its step from the first.
struct Row {
  std::ptrdiff_t step = 0;
  double height_m = telemetry::kMissing, speed_mps = telemetry::kMissing;
};

std::vector<Row> thin_out(const Track& clip) {
  std::vector<Row> rows;
  Nanoseconds last_ns = 0;
  for (const Sample& s : clip.samples) {
    if (!rows.empty() && s.t_log_ns - last_ns < kRowSpacing_ns) continue;
    last_ns = s.t_log_ns;
    const Nanoseconds from_first_ns = s.t_log_ns - clip.samples.front().t_log_ns;
    rows.push_back({static_cast<std::ptrdiff_t>((from_first_ns + kStep_ns / 2) / kStep_ns),
                    s.height_takeoff_m, s.speed_mps});
  }
  return rows;
}

struct Sum {
  double squares = 0.0;
  int count = 0;
  void add(double difference) {
    if (!std::isfinite(difference)) return;
    squares += difference * difference;
    ++count;
  }
  double rms() const { return count > 0 ? std::sqrt(squares / count) : telemetry::kMissing; }
};

struct Misfit {
  Sum height, speed;
  int rows = 0;  ///< with either
  /// Mean square in units of variance, times the clip's rows, so that shifts with fewer rows compare.
  double value(std::size_t all_rows, const AlignOptions& o) const {
    const int count = height.count + speed.count;
    if (2 * static_cast<std::size_t>(rows) < all_rows || count == 0)
      return std::numeric_limits<double>::infinity();
    const double sum = height.squares / (o.height_sigma_m * o.height_sigma_m) +
                       speed.squares / (o.speed_sigma_mps * o.speed_sigma_mps);
    return sum / count * static_cast<double>(all_rows);
  }
};

Misfit misfit_at(const Grid& grid, const std::vector<Row>& rows, std::ptrdiff_t start) {
  Misfit m;
  for (const Row& row : rows) {
    const std::ptrdiff_t at = start + row.step;
    if (at < 0 || at >= static_cast<std::ptrdiff_t>(grid.height_m.size())) continue;
    const int before = m.height.count + m.speed.count;
    m.height.add(row.height_m - grid.height_m[static_cast<std::size_t>(at)]);
    m.speed.add(row.speed_mps - grid.speed_mps[static_cast<std::size_t>(at)]);
    m.rows += m.height.count + m.speed.count > before;
  }
  return m;
}

}  // namespace

Result<ClipAlignment> align_clip(const Track& clip, const Track& log, const AlignOptions& options) {
  const std::string where = clip.source + " in " + log.source;
  if (clip.samples.empty() || log.samples.empty())
    return Error{"alignment_no_data", where, "an empty track", "rows in both", ""};
  const Grid grid = resample(log);
  const auto rows = thin_out(clip);
  const std::ptrdiff_t first = -rows.back().step, end = static_cast<std::ptrdiff_t>(grid.height_m.size());
  std::vector<double> misfits;
  for (std::ptrdiff_t start = first; start < end; ++start)
    misfits.push_back(misfit_at(grid, rows, start).value(rows.size(), options));
  const auto best = std::min_element(misfits.begin(), misfits.end()) - misfits.begin();
  const auto at = [&](std::ptrdiff_t i) {
    return i < 0 || i >= static_cast<std::ptrdiff_t>(misfits.size()) ? std::numeric_limits<double>::infinity()
                                                                     : misfits[static_cast<std::size_t>(i)];
  };
  if (!std::isfinite(at(best)))
    return Error{"alignment_no_data", where, "no heights or speeds that could be compared over half the clip",
                 "height or speed in both", ""};
  double runner_up = std::numeric_limits<double>::infinity();
  constexpr std::ptrdiff_t kApart = kRunnerUpDistance_ns / kStep_ns;
  for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(misfits.size()); ++i)
    if (std::abs(i - best) > kApart) runner_up = std::min(runner_up, at(i));
  ClipAlignment result;
  const Misfit misfit = misfit_at(grid, rows, first + best);
  result.rows = misfit.rows;
  result.height_rms_m = misfit.height.rms();
  result.speed_rms_mps = misfit.speed.rms();
  result.margin = runner_up - at(best);
  if (!(result.margin > options.least_margin))
    return Error{"alignment_ambiguous", where,
                 "another place in the log fits as well (misfit " + base::format_fixed(at(best), 1) +
                     " against " + base::format_fixed(runner_up, 1) + ")",
                 "a clip in which height or speed change", ""};
  const double left = at(best - 1), right = at(best + 1), curvature = left + right - 2.0 * at(best);
  double fraction = 0.0;
  if (std::isfinite(curvature) && curvature > 0.0) {
    fraction = std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5);
    // Variance of a sum of squares' minimum: 2 / second derivative, times the misfit that is left per row if
    // that is above 1.
    const double per_row = std::max(1.0, at(best) / static_cast<double>(rows.size()));
    result.sigma_s = std::sqrt(2.0 * per_row / curvature) * base::ns_to_seconds(kStep_ns);
  }
  result.shift_ns = grid.start_ns - clip.samples.front().t_log_ns + (first + best) * kStep_ns +
                    static_cast<Nanoseconds>(std::llround(fraction * static_cast<double>(kStep_ns)));
  return result;
}

}  // namespace furrow::sync
