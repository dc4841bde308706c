// Figures over the shots of a flight.
#include <algorithm>
#include <cmath>
#include <functional>

#include "figures/finish.h"
#include "figures/looks.h"
#include "figures/plot.h"
#include "furrow/figures/figures.h"
#include "furrow/figures/sources.h"

namespace furrow::figures {
namespace {

using audit::ShotRecord;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPlotHeightMm = 72.0;

/// One curve of a figure over shots: how it looks and which number it shows.
struct Curve {
  Series look;
  std::string column;  ///< heading in the data table
  std::function<Estimate(const ShotRecord&)> value;
  /// Whether all its values must fit on the axis. A curve with wild outliers would press all others flat.
  bool sets_range = true;
};

Estimate bare(double value) {
  return {value, kNaN, 0};
}

Estimate plus(const Estimate& estimate, double offset) {
  return {estimate.value + offset, estimate.sigma, estimate.observations};
}

void fill_in(Curve& curve, const std::vector<ShotRecord>& records) {
  for (std::size_t i = 0; i < records.size(); ++i) {
    const Estimate estimate = curve.value(records[i]);
    curve.look.x.push_back(static_cast<double>(i + 1));
    curve.look.y.push_back(estimate.value);
    curve.look.sigma.push_back(estimate.sigma);
  }
}

bool any_finite(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// All values that must be on the axis: those of the leading curves with their bands, and of the others what
/// lies within one span of these.
std::vector<double> values_in_range(const std::vector<Curve>& curves) {
  std::vector<double> inside;
  for (const Curve& curve : curves) {
    if (!curve.sets_range) continue;
    for (std::size_t i = 0; i < curve.look.y.size(); ++i) {
      inside.push_back(curve.look.y[i]);
      inside.push_back(curve.look.y[i] + curve.look.sigma[i]);
      inside.push_back(curve.look.y[i] - curve.look.sigma[i]);
    }
  }
  std::erase_if(inside, [](double v) { return !std::isfinite(v); });
  const bool leading = !inside.empty();
  double low = 0.0, high = 0.0;
  if (leading) {
    const auto [least, most] = std::minmax_element(inside.begin(), inside.end());
    const double span = *most - *least;
    low = *least - span;
    high = *most + span;
  }
  for (const Curve& curve : curves) {
    if (curve.sets_range) continue;
    for (const double value : curve.look.y) {
      if (!leading || (value >= low && value <= high)) inside.push_back(value);
    }
  }
  return inside;
}

base::CsvTable table_of(const std::vector<ShotRecord>& records, const std::vector<Curve>& curves) {
  base::CsvTable table;
  table.columns = {"shot_number", "shot_id"};
  for (const Curve& curve : curves) {
    table.columns.push_back(curve.column);
    if (any_finite(curve.look.sigma)) {
      const auto unit = curve.column.rfind('_');
      table.columns.push_back(curve.column.substr(0, unit) + "_sigma" + curve.column.substr(unit));
    }
  }
  constexpr int kDecimals = 4;
  for (std::size_t i = 0; i < records.size(); ++i) {
    std::vector<std::string> row{std::to_string(i + 1), records[i].shot_id};
    for (const Curve& curve : curves) {
      row.push_back(cell(curve.look.y[i], kDecimals));
      if (any_finite(curve.look.sigma)) row.push_back(cell(curve.look.sigma[i], kDecimals));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

struct OverShots {
  std::string name;
  std::string caption;
  std::string y_text;
  std::vector<Curve> curves;
  bool zero_line = false;
};

Result<Figure> draw_over_shots(OverShots wanted, const std::vector<ShotRecord>& records,
                               const FigureOptions& options) {
  for (Curve& curve : wanted.curves) fill_in(curve, records);
  std::erase_if(wanted.curves, [](const Curve& curve) { return !any_finite(curve.look.y); });
  FURROW_TRY(Drawing drawing, paper(options, kPlotHeightMm));
  std::vector<LegendEntry> legend;
  std::vector<Series> series;
  std::vector<double> in_range = values_in_range(wanted.curves);
  if (wanted.zero_line) in_range.push_back(0.0);
  for (Curve& curve : wanted.curves) {
    Series look = curve.look;
    if (!any_finite(look.sigma)) look.sigma.clear();
    legend.push_back(legend_of(look));
    series.push_back(std::move(look));
  }
  const double inner_width = drawing.width_pt - 2 * kMarginPt;
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner_width, legend);
  const Frame frame = draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                                {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt},
                                counting_axis("shot number", records.size(), inner_width),
                                axis_over(wanted.y_text, in_range, 7));
  if (series.empty()) draw_note(drawing, frame, "no shot has a value");
  if (wanted.zero_line) draw_level(drawing, frame, 0.0, kInk, {}, 0.6);
  // The first curve is the one that matters: it is painted last, over the others.
  std::reverse(series.begin(), series.end());
  wanted.caption += beyond_text(draw_series(drawing, frame, series));
  return finish(wanted.name, wanted.caption, drawing, table_of(records, wanted.curves), options);
}

std::size_t count_finite(const std::vector<ShotRecord>& records,
                         const std::function<double(const ShotRecord&)>& value) {
  return static_cast<std::size_t>(std::count_if(
      records.begin(), records.end(), [&](const ShotRecord& r) { return std::isfinite(value(r)); }));
}

}  // namespace

Result<Figure> heights_over_shots(const std::vector<ShotRecord>& records, double row_height_m,
                                  const FigureOptions& options) {
  const bool over_ground = std::isfinite(row_height_m);
  const double lift_m = over_ground ? row_height_m : 0.0;
  OverShots wanted;
  wanted.name = "heights_over_shots";
  wanted.y_text = over_ground ? "height above ground / m" : "height above canopy / m";
  wanted.curves = {{refined_look(), over_ground ? "above_ground_refined_m" : "above_canopy_refined_m",
                    [=](const ShotRecord& r) {
                      return over_ground ? r.above_ground_refined_m : r.above_canopy_refined_m;
                    }},
                   {truth_look(), over_ground ? "above_ground_truth_m" : "above_canopy_truth_m",
                    [=](const ShotRecord& r) { return bare(r.truth_above_canopy_m + lift_m); }}};
  if (over_ground) {
    wanted.curves.push_back({log_look("log, above take-off"), "height_takeoff_m",
                             [](const ShotRecord& r) { return bare(r.height_takeoff_m); }});
    wanted.curves.push_back(
        {vps_look(), "height_vps_m", [](const ShotRecord& r) { return bare(r.height_vps_m); }});
  }
  wanted.curves.push_back(
      {thesis_look(), over_ground ? "above_ground_thesis_m" : "above_canopy_thesis_m",
       [=](const ShotRecord& r) { return bare(plus(r.above_canopy_thesis_m, lift_m).value); }, false});
  const std::size_t estimated =
      count_finite(records, [](const ShotRecord& r) { return r.above_canopy_refined_m.value; });
  wanted.caption = "Height of the camera over the flight: estimated from the rows in " +
                   std::to_string(estimated) + " of " + count_of(records.size(), "shot") +
                   ", the band one sigma wide to each side.";
  if (over_ground) {
    wanted.caption += " Canopy heights are lifted by the row height of " + cell(row_height_m, 2) +
                      " m; the log counts from the take-off point, VPS from whatever surface it sees.";
  } else {
    wanted.caption += " Row height unknown: heights are above the canopy, and the log's are left out.";
  }
  return draw_over_shots(std::move(wanted), records, options);
}

Result<Figure> pitch_over_shots(const std::vector<ShotRecord>& records, const FigureOptions& options) {
  OverShots wanted;
  wanted.name = "pitch_over_shots";
  wanted.y_text = "camera pitch / \u00b0";
  wanted.curves = {
      {refined_look(), "pitch_refined_deg", [](const ShotRecord& r) { return r.pitch_deg; }},
      {log_look("log, gimbal"), "pitch_log_deg", [](const ShotRecord& r) { return bare(r.pitch_log_deg); }}};
  double sum = 0.0;
  std::size_t pairs = 0;
  for (const ShotRecord& r : records) {
    const double difference = r.pitch_deg.value - r.pitch_log_deg;
    if (!std::isfinite(difference)) continue;
    sum += difference;
    ++pairs;
  }
  wanted.caption =
      "Elevation of the optical axis, negative below the horizon: refined from the rows, and the gimbal's "
      "own reading.";
  if (pairs > 0) {
    wanted.caption += " Refined minus log: " + cell(sum / static_cast<double>(pairs), 2) +
                      "\u00b0 on average over " + count_of(pairs, "shot") + ".";
  }
  return draw_over_shots(std::move(wanted), records, options);
}

Result<Figure> cross_track_over_shots(const std::vector<ShotRecord>& records, const FigureOptions& options) {
  OverShots wanted;
  wanted.name = "cross_track_over_shots";
  wanted.y_text = "cross-track offset, left of row / m";
  wanted.zero_line = true;
  wanted.curves = {{refined_look(), "cross_track_m", [](const ShotRecord& r) { return r.cross_track_m; }}};
  wanted.caption =
      "Place of the camera across the followed row, in " +
      std::to_string(count_finite(records, [](const ShotRecord& r) { return r.cross_track_m.value; })) +
      " of " + count_of(records.size(), "shot") +
      "; positive when the camera is left of the row, seen along the flight. The band is one sigma wide to "
      "each side.";
  return draw_over_shots(std::move(wanted), records, options);
}

Result<Figure> log_heights_over_shots(const std::vector<ShotRecord>& records, bool vps,
                                      const FigureOptions& options) {
  OverShots wanted;
  wanted.name = vps ? "log_and_vps_over_shots" : "log_over_shots";
  wanted.y_text = "height / m";
  const auto log = [](const ShotRecord& r) { return r.height_takeoff_m; };
  const auto below = [](const ShotRecord& r) { return r.height_vps_m; };
  if (count_finite(records, log) == 0 || (vps && count_finite(records, below) == 0)) {
    return nothing_to_draw(wanted.name, vps ? "no shot with both a log height and VPS" : "no log height",
                           "at least one");
  }
  wanted.curves = {{log_look("log, above take-off"), "height_takeoff_m",
                    [=](const ShotRecord& r) { return bare(log(r)); }}};
  wanted.caption = "Height of the log (IMU and barometer) above the take-off point over the flight";
  if (vps) {
    wanted.curves.push_back(
        {vps_look(), "height_vps_m", [=](const ShotRecord& r) { return bare(below(r)); }});
    wanted.caption += ", and height of the downward sensor (VPS) above whatever surface it saw";
  }
  wanted.caption += ".";
  return draw_over_shots(std::move(wanted), records, options);
}

}  // namespace furrow::figures
