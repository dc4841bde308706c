// Figures that set an estimate against a reference.
#include "furrow/figures/comparison.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "figures/finish.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/stats/agreement.h"
#include "furrow/stats/robust.h"

namespace furrow::figures {
namespace {

using audit::ShotRecord;

/// The pairs in which both sides are known.
struct Pairs {
  std::vector<std::string> ids;
  std::vector<double> estimate, reference, error;
  std::size_t left_out = 0;
};

Pairs whole_pairs(const Comparison& comparison) {
  check(comparison.estimate.size() == comparison.reference.size(),
        "a comparison has as many estimates as references");
  Pairs pairs;
  for (std::size_t i = 0; i < comparison.estimate.size(); ++i) {
    const double error = comparison.estimate[i] - comparison.reference[i];
    if (!std::isfinite(error)) {
      ++pairs.left_out;
      continue;
    }
    pairs.ids.push_back(i < comparison.ids.size() ? comparison.ids[i] : std::to_string(i + 1));
    pairs.estimate.push_back(comparison.estimate[i]);
    pairs.reference.push_back(comparison.reference[i]);
    pairs.error.push_back(error);
  }
  return pairs;
}

base::CsvTable pairs_table(const Comparison& comparison, const Pairs& pairs) {
  base::CsvTable table;
  const std::string unit = "_" + comparison.unit;
  table.columns = {"id", "estimate" + unit, "reference" + unit, "error" + unit};
  for (std::size_t i = 0; i < pairs.error.size(); ++i) {
    table.rows.push_back(
        {pairs.ids[i], cell(pairs.estimate[i], 4), cell(pairs.reference[i], 4), cell(pairs.error[i], 4)});
  }
  return table;
}

Error no_pairs(const Comparison& comparison) {
  return nothing_to_draw(comparison.name,
                         "no pair of " + comparison.estimate_name + " and " + comparison.reference_name,
                         "at least one shot with both");
}

/// A number with its unit; millimetres, or hundredths of a degree.
std::string with_unit(double value, const std::string& unit) {
  const bool degree = unit == "deg" || unit == "\u00b0";
  return tick_text(value, degree ? 2 : 3) + (degree ? "\u00b0" : "\u00a0" + unit);
}

std::string unit_text(const std::string& unit) {
  return unit == "deg" ? "\u00b0" : unit;
}

/// Axis text of the differences, short enough for a one-column figure.
std::string error_text(const Comparison& comparison) {
  return comparison.estimate_name + " \u2212 " + comparison.reference_name + " / " +
         unit_text(comparison.unit);
}

std::string pairs_text(const Pairs& pairs) {
  std::string text = count_of(pairs.error.size(), "pair");
  if (pairs.left_out > 0)
    text += "; " + std::to_string(pairs.left_out) + " left out because one side is missing";
  return text;
}

/// Counts of errors in equal bins.
struct Histogram {
  double low = 0.0, width = 1.0;
  std::vector<int> counts;
};

/// Bins by Freedman and Diaconis (1981): 2 IQR / n^(1/3), between 5 and 40 of them over the whole range.
Histogram histogram(const std::vector<double>& errors) {
  const auto [least, most] = std::minmax_element(errors.begin(), errors.end());
  // Errors that are all one, to a share of themselves or in metres, fill one bin.
  constexpr double kOne = 1e-9;
  const double span = std::max({*most - *least, kOne, kOne * std::abs(*least), kOne * std::abs(*most)});
  const double iqr = stats::quantile(errors, 0.75) - stats::quantile(errors, 0.25);
  const double ideal = 2.0 * iqr / std::cbrt(static_cast<double>(errors.size()));
  const double wanted = ideal > 0.0 ? std::clamp(span / ideal, 5.0, 40.0) : 5.0;
  // Round borders: a bin from -0.05 to 0 can be read, one from -0.0531 cannot.
  const Ticks ticks = nice_ticks(*least, *least + span, static_cast<int>(std::lround(wanted)));
  Histogram made;
  made.width = ticks.values.size() > 1 ? ticks.values[1] - ticks.values[0] : span;
  made.low = std::floor(*least / made.width) * made.width;
  // The first border may lie over the least error by a rounding.
  const double further = std::max(0.0, std::floor((*most - made.low) / made.width));
  made.counts.resize(static_cast<std::size_t>(further) + 1, 0);
  for (const double error : errors) {
    const auto bin = static_cast<std::size_t>(std::max(0.0, (error - made.low) / made.width));
    ++made.counts[std::min(bin, made.counts.size() - 1)];
  }
  return made;
}

/// Expected counts of the Gaussian with the same mean and standard deviation; without points when there is
/// none.
Series gaussian(const Histogram& bins, const stats::Agreement& agreement, const Axis& x) {
  Series curve;
  curve.name = "Gaussian of the same mean and sd";
  curve.colour = kVermillion;
  curve.line_pt = 1.2;
  if (!(agreement.sd_error > 0.0)) return curve;
  constexpr int kSteps = 160;
  const double scale =
      agreement.pairs * bins.width / (agreement.sd_error * std::sqrt(2.0 * std::numbers::pi));
  for (int i = 0; i <= kSteps; ++i) {
    const double at = x.low + (x.high - x.low) * i / kSteps;
    const double z = (at - agreement.mean_error) / agreement.sd_error;
    curve.x.push_back(at);
    curve.y.push_back(scale * std::exp(-0.5 * z * z));
  }
  return curve;
}

}  // namespace

Comparison heights_against_log(const std::vector<ShotRecord>& records) {
  Comparison made{"height_agreement_log", "height above ground", "m", "refined", "log", {}, {}, {}};
  for (const ShotRecord& r : records) {
    made.ids.push_back(r.shot_id);
    made.estimate.push_back(r.above_ground_refined_m.value);
    made.reference.push_back(r.height_takeoff_m);
  }
  return made;
}

Comparison heights_against_truth(const std::vector<ShotRecord>& records) {
  Comparison made{"height_agreement_truth", "height above canopy", "m", "refined", "truth", {}, {}, {}};
  for (const ShotRecord& r : records) {
    made.ids.push_back(r.shot_id);
    made.estimate.push_back(r.above_canopy_refined_m.value);
    made.reference.push_back(r.truth_above_canopy_m);
  }
  return made;
}

Comparison pitch_against_log(const std::vector<ShotRecord>& records) {
  Comparison made{"pitch_agreement_log", "camera pitch", "deg", "refined", "log", {}, {}, {}};
  for (const ShotRecord& r : records) {
    made.ids.push_back(r.shot_id);
    made.estimate.push_back(r.pitch_deg.value);
    made.reference.push_back(r.pitch_log_deg);
  }
  return made;
}

Result<Figure> agreement(const Comparison& comparison, const FigureOptions& options) {
  const Pairs pairs = whole_pairs(comparison);
  if (pairs.error.empty()) return no_pairs(comparison);
  const stats::Agreement numbers = stats::agreement(pairs.estimate, pairs.reference);
  FURROW_TRY(Drawing drawing, paper(options, 72.0));

  Series points;
  points.colour = kBlue;
  points.line_pt = 0.0;
  points.marker = Marker::circle;
  points.marker_pt = 3.0;
  points.y = pairs.error;
  for (std::size_t i = 0; i < pairs.error.size(); ++i)
    points.x.push_back(0.5 * (pairs.estimate[i] + pairs.reference[i]));

  LegendEntry bias{"mean difference " + with_unit(numbers.mean_error, comparison.unit), kVermillion, 1.3};
  LegendEntry limits{"95 % limits " + with_unit(numbers.limit_low, comparison.unit) + " and " +
                         with_unit(numbers.limit_high, comparison.unit),
                     kVermillion,
                     1.0,
                     {4.0, 2.5}};
  std::vector<LegendEntry> legend{bias};
  if (std::isfinite(numbers.limit_low)) legend.push_back(limits);
  std::vector<double> in_range = pairs.error;
  in_range.insert(in_range.end(), {0.0, numbers.limit_low, numbers.limit_high});
  const double inner_width = drawing.width_pt - 2 * kMarginPt;
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner_width, legend);
  const std::string mean_text = "mean of both, " + comparison.quantity + " / " + unit_text(comparison.unit);
  const Frame frame = draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                                {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt},
                                axis_over(mean_text, points.x, static_cast<int>(inner_width / 50.0)),
                                axis_over(error_text(comparison), in_range, 7));
  draw_level(drawing, frame, 0.0, kInk, {}, 0.6);
  draw_level(drawing, frame, numbers.mean_error, bias.colour, bias.dash, bias.line_pt);
  draw_level(drawing, frame, numbers.limit_low, limits.colour, limits.dash, limits.line_pt);
  draw_level(drawing, frame, numbers.limit_high, limits.colour, limits.dash, limits.line_pt);
  draw_series(drawing, frame, {points});
  const std::string caption = "Agreement of " + comparison.estimate_name + " and " +
                              comparison.reference_name + " " + comparison.quantity +
                              " (Bland and Altman): difference over the mean of both; " + pairs_text(pairs) +
                              ". The dashed lines hold 95 % of the differences if these are Gaussian.";
  return finish(comparison.name, caption, drawing, pairs_table(comparison, pairs), options);
}

Result<Figure> error_histogram(const Comparison& comparison, const FigureOptions& options) {
  const Pairs pairs = whole_pairs(comparison);
  if (pairs.error.empty()) return no_pairs(comparison);
  const std::string name = comparison.name + "_errors";
  const stats::Agreement numbers = stats::agreement(pairs.estimate, pairs.reference);
  const Histogram bins = histogram(pairs.error);
  FURROW_TRY(Drawing drawing, paper(options, 66.0));

  const double last = bins.low + bins.width * static_cast<double>(bins.counts.size());
  const double inner_width = drawing.width_pt - 2 * kMarginPt;
  const Axis x = axis_over(error_text(comparison), {bins.low - bins.width, last + bins.width, 0.0},
                           static_cast<int>(inner_width / 50.0));
  const Series curve = gaussian(bins, numbers, x);
  std::vector<double> heights(bins.counts.begin(), bins.counts.end());
  heights.insert(heights.end(), curve.y.begin(), curve.y.end());
  Axis y = axis_over("number of " + comparison.counted, heights, 6, true);
  std::erase_if(y.ticks.values, [](double v) { return v != std::round(v); });
  y.ticks.decimals = 0;

  LegendEntry bars{"errors", kSkyBlue},
      bias{"mean error " + with_unit(numbers.mean_error, comparison.unit), kInk, 1.2, {5.0, 2.0}};
  bars.bar = true;
  std::vector<LegendEntry> legend{bars, bias};
  if (!curve.x.empty()) legend.push_back(legend_of(curve));
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner_width, legend);
  const Frame frame = draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                                {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt}, x, y);
  base::CsvTable table;
  table.columns = {"from_" + comparison.unit, "to_" + comparison.unit, "count"};
  for (std::size_t i = 0; i < bins.counts.size(); ++i) {
    const double from = bins.low + bins.width * static_cast<double>(i);
    const Point top = frame.map(from, bins.counts[i]), foot = frame.map(from + bins.width, 0.0);
    if (bins.counts[i] > 0) {
      add_rectangle(drawing, top, foot, kSkyBlue);
      add_frame(drawing, top, foot, kBlue, 0.5);
    }
    table.rows.push_back({cell(from, 4), cell(from + bins.width, 4), std::to_string(bins.counts[i])});
  }
  draw_series(drawing, frame, {curve});
  drawing.items.push_back(
      Stroke{{frame.map(numbers.mean_error, y.low), frame.map(numbers.mean_error, y.high)},
             bias.colour,
             bias.line_pt,
             bias.dash});
  const std::string caption = "Errors of the " + comparison.quantity + ", " + comparison.estimate_name +
                              " minus " + comparison.reference_name + "; " + pairs_text(pairs) + ". Mean " +
                              with_unit(numbers.mean_error, comparison.unit) + ", standard deviation " +
                              with_unit(numbers.sd_error, comparison.unit) + ", RMSE " +
                              with_unit(numbers.rmse, comparison.unit) + ".";
  return finish(name, caption, drawing, std::move(table), options);
}

}  // namespace furrow::figures
