// Heights by stretches of a flight at one height, as the thesis drew them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "figures/finish.h"
#include "figures/looks.h"
#include "furrow/audit/legs.h"
#include "furrow/figures/comparison.h"

namespace furrow::figures {

using audit::HeightLeg;
using audit::ShotRecord;

namespace {

constexpr double kPanelMm = 54.0, kTitlePt = 12.0, kBetweenPanelsPt = 6.0;

/// The curves of one leg's panel.
struct Panel {
  HeightLeg leg;
  Series log, refined, thesis;
};

Panel panel_of(const std::vector<ShotRecord>& records, const HeightLeg& leg, double row_height_m) {
  Panel panel{leg, log_look("log, above take-off"), refined_look(), thesis_look()};
  for (std::size_t i = leg.first; i <= leg.last; ++i) {
    const ShotRecord& r = records[i];
    for (Series* series : {&panel.log, &panel.refined, &panel.thesis}) {
      series->x.push_back(static_cast<double>(i + 1));
    }
    panel.log.y.push_back(r.height_takeoff_m);
    panel.refined.y.push_back(r.above_ground_refined_m.value);
    panel.refined.sigma.push_back(r.above_ground_refined_m.sigma);
    panel.thesis.y.push_back(r.above_canopy_thesis_m.value + row_height_m);
  }
  return panel;
}

/// The longest legs say most; they keep the order of the flight.
std::vector<HeightLeg> longest(std::vector<HeightLeg> legs, std::size_t most) {
  if (legs.size() <= most) return legs;
  std::stable_sort(legs.begin(), legs.end(),
                   [](const auto& a, const auto& b) { return a.last - a.first > b.last - b.first; });
  legs.resize(most);
  std::sort(legs.begin(), legs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  return legs;
}

Axis leg_axis(const HeightLeg& leg, double width_pt) {
  const double first = static_cast<double>(leg.first + 1), last = static_cast<double>(leg.last + 1);
  constexpr double kPtPerTick = 28.0;
  Axis axis{"shot number", first - 0.5, last + 0.5, {}};
  axis.ticks = nice_ticks(first, last + 1e-6,
                          std::max(1, static_cast<int>(std::min(last - first + 1.0, width_pt / kPtPerTick))));
  axis.ticks.decimals = 0;
  std::erase_if(axis.ticks.values, [](double v) { return v != std::round(v); });
  if (axis.ticks.values.empty()) axis.ticks.values = {first};
  return axis;
}

/// The same scale in every panel, set by the log and the refined heights; the thesis formula's wild values
/// become arrows.
Axis shared_axis(const std::vector<Panel>& panels) {
  std::vector<double> in_range;
  for (const Panel& panel : panels) {
    in_range.insert(in_range.end(), panel.log.y.begin(), panel.log.y.end());
    in_range.insert(in_range.end(), panel.refined.y.begin(), panel.refined.y.end());
  }
  constexpr double kAir = 0.15;
  const Axis tight = axis_over("height above ground / m", in_range, 7);
  const double air = kAir * (tight.high - tight.low);
  return axis_over(tight.text, {tight.low - air, tight.high + air}, 7);
}

base::CsvTable legs_table(const std::vector<ShotRecord>& records, const std::vector<Panel>& panels) {
  base::CsvTable table;
  table.columns = {"leg",
                   "shot_number",
                   "shot_id",
                   "height_takeoff_m",
                   "above_ground_refined_m",
                   "above_ground_refined_sigma_m",
                   "above_ground_thesis_m"};
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const Panel& panel = panels[k];
    for (std::size_t i = 0; i < panel.log.x.size(); ++i) {
      const std::size_t shot = panel.leg.first + i;
      table.rows.push_back({std::to_string(k + 1), std::to_string(shot + 1), records[shot].shot_id,
                            cell(panel.log.y[i], 4), cell(panel.refined.y[i], 4),
                            cell(panel.refined.sigma[i], 4), cell(panel.thesis.y[i], 4)});
    }
  }
  return table;
}

int draw_panel(Drawing& drawing, const Panel& panel, const Axis& y, const Point& corner, const Point& size) {
  const Frame frame = draw_axes(drawing, corner + Point(0, kTitlePt),
                                corner + size - Point(kBetweenPanelsPt, 0), leg_axis(panel.leg, size.x()), y);
  drawing.items.push_back(
      Text{{0.5 * (frame.top_left.x() + frame.bottom_right.x()), frame.top_left.y() - 4.0},
           "log at " + tick_text(panel.leg.mean_height_m, 2) + " m",
           kLegendTextPt,
           kInk,
           Align::middle,
           true});
  return draw_series(drawing, frame, {panel.thesis, panel.log, panel.refined});
}

}  // namespace

Result<Figure> heights_by_leg(const std::vector<ShotRecord>& records, double row_height_m,
                              const FigureOptions& options) {
  // More panels than this can no longer be read.
  constexpr std::size_t kMostPanels = 9;
  constexpr double kNarrowestPanelMm = 50.0, kMostColumns = 3.0;
  const std::string name = "heights_by_leg";
  const std::vector<HeightLeg> all = audit::height_legs(records), shown = longest(all, kMostPanels);
  if (shown.empty()) return nothing_to_draw(name, "no shot with a log height", "at least one");
  std::vector<Panel> panels;
  panels.reserve(shown.size());
  for (const HeightLeg& leg : shown) panels.push_back(panel_of(records, leg, row_height_m));

  // This order of max and min makes 1 of a width that is no number; paper() refuses it.
  const auto fitting =
      static_cast<std::size_t>(std::min(kMostColumns, std::max(1.0, options.width_mm / kNarrowestPanelMm)));
  const std::size_t columns = std::min(panels.size(), fitting),
                    lines = (panels.size() + columns - 1) / columns;
  FURROW_TRY(Drawing drawing, paper(options, kPanelMm * static_cast<double>(lines) + 8.0));
  const double inner = drawing.width_pt - 2 * kMarginPt;
  const double top = kMarginPt + draw_legend(drawing, {kMarginPt, kMarginPt}, inner,
                                             {legend_of(panels[0].refined), legend_of(panels[0].log),
                                              legend_of(panels[0].thesis)});
  const Point size(inner / static_cast<double>(columns),
                   (drawing.height_pt - top - kMarginPt) / static_cast<double>(lines));
  const Axis y = shared_axis(panels);
  int beyond = 0;
  for (std::size_t k = 0; k < panels.size(); ++k) {
    const std::size_t line = k / columns, column = k % columns;
    const Point corner(kMarginPt + size.x() * static_cast<double>(column),
                       top + size.y() * static_cast<double>(line));
    beyond += draw_panel(drawing, panels[k], y, corner, size);
  }
  std::string caption = "Height above ground per shot, by legs of the flight at one height of the log: " +
                        count_of(shown.size(), "leg");
  if (all.size() > shown.size()) caption += ", the longest of " + std::to_string(all.size());
  caption +=
      std::isfinite(row_height_m)
          ? ". Canopy heights are lifted by the row height of " + cell(row_height_m, 2) + " m."
          : ". The row height is unknown: only heights above the canopy are, and the log stands alone.";
  return finish(name, caption + beyond_text(beyond), drawing, legs_table(records, panels), options);
}

}  // namespace furrow::figures
