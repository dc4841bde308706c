// Figures of a camera and of how far its calibration can be trusted.
#include "furrow/figures/camera_maps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "figures/finish.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/calib/verdict.h"
#include "furrow/figures/comparison.h"
#include "furrow/geom/angles.h"
#include "furrow/stats/robust.h"

namespace furrow::figures {
namespace {

/// Room under a map for its colour bar.
constexpr double kBarRoomPt = 44.0;

/// Axes of a picture of that size, below `top_pt`; sets the drawing's height.
Frame picture_frame(Drawing& drawing, double top_pt, int width_px, int height_px, double room_below_pt) {
  const double inner = drawing.width_pt - 2 * kMarginPt;
  // The axis texts take about this much of the width and of the height.
  constexpr double kAxesPt = 40.0;
  const double aspect = std::min(1.4, static_cast<double>(height_px) / width_px);
  drawing.height_pt = top_pt + aspect * (inner - kAxesPt) + kAxesPt + room_below_pt;
  const Axis x = axis_between("u / px", -0.5, width_px - 0.5, 8);
  const Axis y = axis_between("v / px", -0.5, height_px - 0.5, 6);
  return draw_axes(drawing, {kMarginPt, top_pt},
                   {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt - room_below_pt}, x,
                   flipped(y));
}

/// Corners of cell (i, j) of columns x rows over the picture, on paper.
std::pair<Point, Point> cell_on_paper(const Frame& frame, int i, int j, int columns, int rows) {
  const double wide = (frame.x.high - frame.x.low) / columns,
               high = (frame.bottom_right.y() - frame.top_left.y()) / rows;
  const double left = frame.map(frame.x.low + i * wide, 0.0).x(),
               right = frame.map(frame.x.low + (i + 1) * wide, 0.0).x();
  return {{left, frame.top_left.y() + j * high}, {right, frame.top_left.y() + (j + 1) * high}};
}

}  // namespace

Result<Figure> residual_histogram(const calib::Calibration& calibration, const FigureOptions& options) {
  Comparison residuals{"residual", "corner coordinates", "px", "found", "projected", {}, {}, {}};
  residuals.counted = "coordinates";
  for (const calib::View& view : calibration.views) {
    if (!view.used) continue;
    for (std::size_t c = 0; c < std::min(view.residual_px.size(), view.observed_px.size()); ++c) {
      if (!view.left_out.empty() && view.left_out[c]) continue;
      for (int axis = 0; axis < 2; ++axis) {
        residuals.estimate.push_back(view.observed_px[c][axis]);
        residuals.reference.push_back(view.observed_px[c][axis] - view.residual_px[c][axis]);
      }
    }
  }
  return error_histogram(residuals, options);
}

Result<Figure> coverage_map(const calib::Calibration& calibration, const FigureOptions& options) {
  const std::string name = "coverage_map";
  constexpr int kColumns = 6, kRows = 4;  // the cells that the verdict counts
  const std::vector<int> counts = calib::coverage(calibration, kColumns, kRows);
  const auto count_at = [&](int i, int j) {
    return counts[static_cast<std::size_t>(j) * kColumns + static_cast<std::size_t>(i)];
  };
  const int corners = std::accumulate(counts.begin(), counts.end(), 0);
  if (corners == 0) return nothing_to_draw(name, "a calibration without a used view", "at least one");
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  drawing.height_pt = 1.0;
  LegendEntry dots{"corner", kBlue}, empty{"part of the picture without a corner", kOrange};
  dots.marker = Marker::circle;
  empty.bar = true;
  const double top = kMarginPt + draw_legend(drawing, {kMarginPt, kMarginPt},
                                             drawing.width_pt - 2 * kMarginPt, {dots, empty});
  const Frame frame = picture_frame(drawing, top, calibration.camera.width, calibration.camera.height, 0.0);
  base::CsvTable table;
  table.columns = {"column", "row", "corners"};
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const int count = count_at(i, j);
      const auto [low, high] = cell_on_paper(frame, i, j, kColumns, kRows);
      if (count == 0) add_rectangle(drawing, low, high, with_alpha(kOrange, 120));
      add_frame(drawing, low, high, kGridGrey, 0.6);
      table.rows.push_back({std::to_string(i + 1), std::to_string(j + 1), std::to_string(count)});
    }
  }
  for (const calib::View& view : calibration.views) {
    if (!view.used) continue;
    for (const Eigen::Vector2d& px : view.observed_px)
      add_marker(drawing, Marker::circle, frame.map(px.x(), px.y()), 1.8, kBlue);
  }
  for (int j = 0; j < kRows; ++j) {
    for (int i = 0; i < kColumns; ++i) {
      const auto [low, high] = cell_on_paper(frame, i, j, kColumns, kRows);
      add_label(drawing, low + Point(16.0, 8.0), std::to_string(count_at(i, j)), 6.5, kInk,
                with_alpha(kWhite, 200));
    }
  }
  const auto filled = std::count_if(counts.begin(), counts.end(), [](int n) { return n > 0; });
  const std::string caption =
      "Where the boards' " + count_of(static_cast<std::size_t>(corners), "corner") + " lie in the picture; " +
      std::to_string(filled) + " of " + std::to_string(counts.size()) +
      " parts hold one. Numbers count the corners of each part. What a lens does where no corner "
      "lies is extrapolated.";
  return finish(name, caption, drawing, std::move(table), options);
}

Result<Figure> picture_map(const PictureMap& map, const FigureOptions& options) {
  check(map.values.size() == static_cast<std::size_t>(map.columns) * static_cast<std::size_t>(map.rows),
        "picture_map: as many values as cells");
  std::vector<double> finite;
  std::copy_if(map.values.begin(), map.values.end(), std::back_inserter(finite),
               [](double v) { return std::isfinite(v); });
  if (finite.empty() || map.width_px < 1 || map.height_px < 1)
    return nothing_to_draw(map.name, "no value in the picture", "at least one");
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  const Frame frame = picture_frame(drawing, kMarginPt, map.width_px, map.height_px, kBarRoomPt);
  // Corners that no board reached would take the whole scale for themselves.
  constexpr double kMostOverUsual = 3.0, kUsualShare = 0.9;
  const double largest = *std::max_element(finite.begin(), finite.end());
  const double cap = kMostOverUsual * stats::quantile(finite, kUsualShare);
  std::vector<double> in_scale;
  std::copy_if(finite.begin(), finite.end(), std::back_inserter(in_scale),
               [&](double v) { return v <= cap; });
  const auto over = finite.size() - in_scale.size();
  Axis scale = axis_over(map.quantity, in_scale.empty() ? finite : in_scale, 6, true);
  // A map without relief needs no more than one colour, but a scale needs a span.
  if (!(scale.high > scale.low)) scale.high = scale.low + 1.0;
  base::CsvTable table;
  table.columns = {"u_px", "v_px", "value"};
  std::size_t empty = 0;
  for (int j = 0; j < map.rows; ++j) {
    for (int i = 0; i < map.columns; ++i) {
      const double value = map.values[static_cast<std::size_t>(j) * static_cast<std::size_t>(map.columns) +
                                      static_cast<std::size_t>(i)];
      table.rows.push_back({cell((i + 0.5) * map.width_px / map.columns - 0.5, 1),
                            cell((j + 0.5) * map.height_px / map.rows - 0.5, 1), cell(value, 5)});
      empty += std::isfinite(value) ? 0 : 1;
      if (!std::isfinite(value)) continue;
      auto [low, high] = cell_on_paper(frame, i, j, map.columns, map.rows);
      // A hair over the neighbour to the right and below, which is drawn later: no seams.
      high = high + Point(i + 1 < map.columns ? 0.4 : 0.0, j + 1 < map.rows ? 0.4 : 0.0);
      add_rectangle(drawing, low, high, viridis((value - scale.low) / (scale.high - scale.low)));
    }
  }
  add_frame(drawing, frame.top_left, frame.bottom_right, kInk, 0.6);
  const double bar_width = 0.7 * (drawing.width_pt - 2 * kMarginPt);
  draw_colour_bar(drawing, {0.5 * (drawing.width_pt - bar_width), drawing.height_pt - kBarRoomPt}, bar_width,
                  scale);
  std::string rest = empty > 0 ? " White: no answer there (the lens model has no inverse)." : "";
  if (over > 0 && !in_scale.empty())
    rest += " Beyond the scale, in its last colour: " + count_of(over, "cell") + ", up to " +
            cell(largest, 2) + ".";
  return finish(map.name, map.caption + rest, drawing, std::move(table), options);
}

PictureMap difference_map(const std::string& name, const std::string& caption, const Camera& camera,
                          const camera::CameraDifference& difference) {
  PictureMap out{name,         "difference / px", caption, difference.columns, difference.rows,
                 camera.width, camera.height,     {}};
  for (const Eigen::Vector2d& d : difference.difference_px) out.values.push_back(d.norm());
  return out;
}

Result<Figure> distortion_curve(const std::vector<camera::DistortionPoint>& curve,
                                const FigureOptions& options) {
  const std::string name = "distortion_curve";
  Series shift;
  shift.name = "distortion";
  shift.colour = kBlue;
  base::CsvTable table;
  table.columns = {"radius_px", "angle_deg", "shift_px"};
  for (const camera::DistortionPoint& point : curve) {
    const double angle_deg = geom::rad_to_deg(point.angle_rad);
    table.rows.push_back({cell(point.radius_px, 2), cell(angle_deg, 3), cell(point.shift_px, 4)});
    if (!std::isfinite(point.shift_px)) continue;
    shift.x.push_back(point.radius_px);
    shift.y.push_back(point.shift_px);
  }
  if (shift.x.size() < 2) return nothing_to_draw(name, "a camera without rays", "two places at least");
  FURROW_TRY(Drawing drawing, paper(options, 62.0));
  const double inner = drawing.width_pt - 2 * kMarginPt;
  const Frame frame = draw_axes(
      drawing, {kMarginPt, kMarginPt}, {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt},
      axis_over("distance from the principal point / px", shift.x, static_cast<int>(inner / 50.0)),
      axis_over("farther out than a pinhole / px", shift.y, 6, true), Grid::both);
  draw_level(drawing, frame, 0.0, kInk, {}, 0.6);
  draw_series(drawing, frame, {shift});
  const camera::DistortionPoint& last = curve.back();
  const std::string caption =
      "How far the lens moves a pixel from where a pinhole of the same focal length has it, from the "
      "principal point to "
      "the farthest corner of the picture; there the ray lies " +
      base::format_fixed(geom::rad_to_deg(last.angle_rad), 1) + " deg off the axis." +
      (std::isfinite(last.shift_px) ? "" : " From 60 deg on a pinhole is no measure.");
  return finish(name, caption, drawing, std::move(table), options);
}

}  // namespace furrow::figures
