// Figures of a calibration.
#include <algorithm>
#include <cmath>

#include "figures/finish.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/figures/figures.h"

namespace furrow::figures {
namespace {

/// Bars of one value per view; a cross at the foot where a view was not used.
void draw_bars(Drawing& drawing, const Frame& frame, const std::vector<calib::View>& views) {
  constexpr double kBarShare = 0.7;
  const double slot_pt = frame.map(2.0, 0.0).x() - frame.map(1.0, 0.0).x();
  // Values fit over their bars only when the bars are wide enough.
  const bool with_values = slot_pt > 22.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double at = static_cast<double>(i + 1);
    const double error = views[i].mean_error_px;
    if (!views[i].used || !std::isfinite(error)) {
      add_marker(drawing, Marker::cross, frame.map(at, 0.0) - Point(0, 5.0), 5.0, kMidGrey);
      continue;
    }
    const Point top = frame.map(at - kBarShare / 2, error), foot = frame.map(at + kBarShare / 2, 0.0);
    add_rectangle(drawing, top, foot, kSkyBlue);
    add_frame(drawing, top, foot, kBlue, 0.5);
    if (with_values) {
      // Two significant digits say all that a mean of some dozens of corners can.
      drawing.items.push_back(Text{{0.5 * (top.x() + foot.x()), foot.y() - 3.0},
                                   base::format_fixed(error, 2),
                                   6.5,
                                   kInk,
                                   Align::middle});
    }
    add_marker(drawing, Marker::diamond, frame.map(at, views[i].rms_px), 4.0, kInk);
  }
}

base::CsvTable views_table(const std::vector<calib::View>& views) {
  base::CsvTable table;
  table.columns = {"view_number", "image", "used", "mean_error_px", "rms_px", "reason"};
  for (std::size_t i = 0; i < views.size(); ++i) {
    const calib::View& view = views[i];
    table.rows.push_back({std::to_string(i + 1), view.image, view.used ? "yes" : "no",
                          view.used ? cell(view.mean_error_px, 4) : "", view.used ? cell(view.rms_px, 4) : "",
                          view.reason});
  }
  return table;
}

std::size_t used_views(const calib::Calibration& calibration) {
  return static_cast<std::size_t>(std::count_if(calibration.views.begin(), calibration.views.end(),
                                                [](const calib::View& view) { return view.used; }));
}

}  // namespace

Result<Figure> reprojection_bars(const calib::Calibration& calibration, const FigureOptions& options) {
  const std::string name = "reprojection_bars";
  const std::size_t used = used_views(calibration);
  if (used == 0) return nothing_to_draw(name, "a calibration without a used view", "at least one");
  FURROW_TRY(Drawing drawing, paper(options, 66.0));
  std::vector<double> values{calibration.mean_error_px};
  for (const calib::View& view : calibration.views) {
    if (view.used) values.insert(values.end(), {view.mean_error_px, view.rms_px});
  }
  const std::string mean_text =
      "mean over all corners, " + base::format_fixed(calibration.mean_error_px, 3) + " px";
  LegendEntry bar{"mean distance per view", kSkyBlue}, rms{"RMS per view", kInk},
      mean{mean_text, kVermillion}, unused{"view not used", kMidGrey};
  bar.bar = true;
  rms.marker = Marker::diamond;
  mean.line_pt = 1.2;
  mean.dash = {5.0, 2.0};
  unused.marker = Marker::cross;
  std::vector<LegendEntry> legend{bar, rms, mean};
  if (used < calibration.views.size()) legend.push_back(unused);

  const double inner_width = drawing.width_pt - 2 * kMarginPt;
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner_width, legend);
  const Frame frame = draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                                {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt},
                                counting_axis("view number", calibration.views.size(), inner_width),
                                axis_over("reprojection error / px", values, 6, true));
  draw_bars(drawing, frame, calibration.views);
  draw_level(drawing, frame, calibration.mean_error_px, mean.colour, mean.dash, mean.line_pt);
  const std::string caption =
      "Reprojection error per view of the board: mean distance between found and projected corner, and its "
      "root mean square; " +
      std::to_string(used) + " of " + count_of(calibration.views.size(), "view") + " used, " +
      std::to_string(calibration.corners) + " corners, overall RMS " +
      base::format_fixed(calibration.rms_px, 3) + " px. View numbers are those of the data table.";
  return finish(name, caption, drawing, views_table(calibration.views), options);
}

}  // namespace furrow::figures
