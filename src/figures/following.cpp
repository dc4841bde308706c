// A row followed through a sequence: over time, against readings by hand, and as the pictures of a video.
#include "furrow/figures/following.h"

#include <algorithm>
#include <cmath>

#include "figures/finish.h"
#include "figures/looks.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "furrow/image/draw.h"

namespace furrow::figures {
namespace {

constexpr double kOffsetMm = 62.0, kSpeedMm = 36.0, kPanelMm = 54.0, kTitlePt = 12.0;

bool any_finite(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

Series over_time(Series look, const FollowingCurves& curves, const std::vector<double>& values) {
  look.x = curves.t_s;
  look.y = values;
  return look;
}

/// The axis holds the filtered curve with its band and the bulk of the others; wild ones become arrows.
Axis offset_axis(const FollowingCurves& curves, const std::string& text) {
  std::vector<double> in_range = {0.0};
  for (std::size_t i = 0; i < curves.filtered.size(); ++i) {
    in_range.push_back(curves.filtered[i] - curves.filtered_sigma[i]);
    in_range.push_back(curves.filtered[i] + curves.filtered_sigma[i]);
  }
  std::vector<double> measured = curves.measured;
  std::erase_if(measured, [](double v) { return !std::isfinite(v); });
  std::sort(measured.begin(), measured.end());
  if (!measured.empty()) {
    in_range.push_back(measured[measured.size() / 50]);
    in_range.push_back(measured[measured.size() - 1 - measured.size() / 50]);
  }
  std::erase_if(in_range, [](double v) { return !std::isfinite(v); });
  return axis_over(text, in_range, 6);
}

/// Grey ground where there was nothing to steer by.
void shade_holds(Drawing& drawing, const Frame& frame, const FollowingCurves& curves) {
  for (std::size_t i = 0; i < curves.is_hold.size(); ++i) {
    if (!curves.is_hold[i]) continue;
    const std::size_t first = i;
    while (i + 1 < curves.is_hold.size() && curves.is_hold[i + 1]) ++i;
    const double from = curves.t_s[first];
    const double to = i + 1 < curves.t_s.size() ? curves.t_s[i + 1] : curves.t_s[i];
    const Point low = frame.map(from, frame.y.high), high = frame.map(to, frame.y.low);
    add_rectangle(drawing, low, {std::max(high.x(), low.x() + 0.5), high.y()}, {0xE8, 0xE8, 0xE8});
  }
}

base::CsvTable curves_table(const FollowingCurves& curves) {
  const std::string unit = curves.is_metric ? "_m" : "_px";
  base::CsvTable table;
  table.columns = {"t_s",
                   "measured" + unit,
                   "filtered" + unit,
                   "filtered_sigma" + unit,
                   "thesis_steer" + unit,
                   "right_mps",
                   "hold"};
  for (std::size_t i = 0; i < curves.t_s.size(); ++i) {
    table.rows.push_back({cell(curves.t_s[i], 3), cell(curves.measured[i], 4), cell(curves.filtered[i], 4),
                          cell(curves.filtered_sigma[i], 4), cell(curves.thesis_steer[i], 4),
                          cell(curves.right_mps[i], 4), curves.is_hold[i] ? "yes" : "no"});
  }
  return table;
}

std::vector<Series> offset_series(const FollowingCurves& curves) {
  std::vector<Series> series = {
      over_time(look("measured in each picture", kMidGrey, 0.0, {}, Marker::circle), curves, curves.measured),
      over_time(look("thesis's rule", kVermillion, 0.9, {4.0, 2.0}, Marker::none), curves,
                curves.thesis_steer),
      over_time(look("filtered, \u00b11\u03c3", kBlue, 1.3, {}, Marker::none), curves, curves.filtered)};
  series[0].marker_pt = curves.t_s.size() > 300 ? 1.4 : 2.4;
  series[2].sigma = curves.filtered_sigma;
  std::erase_if(series, [](const Series& one) { return !any_finite(one.y); });
  return series;
}

/// One of several plots above each other.
struct Panel {
  Point corner, end;
  Axis x, y;
};

/// Draws the axes of all panels with one left border, whatever the width of their numbers.
std::vector<Frame> draw_aligned(Drawing& drawing, const std::vector<Panel>& panels) {
  std::vector<double> borders;
  for (const Panel& panel : panels) {
    Drawing aside;
    borders.push_back(draw_axes(aside, panel.corner, panel.end, panel.x, panel.y).top_left.x());
  }
  const double common = *std::max_element(borders.begin(), borders.end());
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const Point shift(common - borders[i], 0.0);
    frames.push_back(draw_axes(drawing, panels[i].corner + shift, panels[i].end, panels[i].x, panels[i].y));
  }
  return frames;
}

Axis time_axis(const std::vector<double>& t_s) {
  return axis_between("time in the source / s", t_s.front(), std::max(t_s.back(), t_s.front() + 1e-3), 10);
}

Axis speed_axis(const FollowingCurves& curves) {
  std::vector<double> finite = curves.right_mps;
  finite.push_back(0.0);
  std::erase_if(finite, [](double v) { return !std::isfinite(v); });
  return axis_over("to the right / m/s", finite, 4);
}

int fill_panel(Drawing& drawing, const Frame& frame, const FollowingCurves& curves,
               const std::vector<Series>& series) {
  shade_holds(drawing, frame, curves);
  draw_level(drawing, frame, 0.0, kMidGrey, {}, 0.6);
  if (series.empty()) draw_note(drawing, frame, "no row was seen");
  return draw_series(drawing, frame, series);
}

double draw_following_legend(Drawing& drawing, const FollowingCurves& curves,
                             const std::vector<Series>& series) {
  std::vector<LegendEntry> legend;
  legend.reserve(series.size() + 1);
  for (const Series& one : series) legend.push_back(legend_of(one));
  LegendEntry hold{"hold: nothing to steer by", {0xE8, 0xE8, 0xE8}};
  hold.bar = true;
  if (std::find(curves.is_hold.begin(), curves.is_hold.end(), true) != curves.is_hold.end())
    legend.push_back(hold);
  return draw_legend(drawing, {kMarginPt, kMarginPt}, drawing.width_pt - 2 * kMarginPt, legend);
}

std::string following_caption(const FollowingCurves& curves, int beyond, bool has_speed) {
  const auto held = std::count(curves.is_hold.begin(), curves.is_hold.end(), true);
  std::string caption = "Offset from the followed row over " + count_of(curves.t_s.size(), "picture") + ", " +
                        std::to_string(held) + " of them on hold." + beyond_text(beyond);
  if (has_speed) caption += " Below: the lateral speed that guidance asks for.";
  return caption;
}

}  // namespace

Result<Figure> following_over_time(const FollowingCurves& curves, const FigureOptions& options) {
  const std::string name = "following_over_time";
  if (curves.t_s.empty()) return nothing_to_draw(name, "no picture", "at least one");
  const bool has_speed = any_finite(curves.right_mps);
  FURROW_TRY(Drawing drawing, paper(options, kOffsetMm + (has_speed ? kSpeedMm : 0.0)));
  const std::vector<Series> series = offset_series(curves);
  const double top = kMarginPt + draw_following_legend(drawing, curves, series);
  const double right = drawing.width_pt - kMarginPt, split = kOffsetMm * kPointsPerMm;
  const Axis x = time_axis(curves.t_s);
  const Axis y = offset_axis(
      curves, curves.is_metric ? "camera left of the row / m" : "row right of the picture's middle / px");
  std::vector<Panel> panels = {{{kMarginPt, top}, {right, split}, x, y}};
  if (has_speed) {
    const double bottom = drawing.height_pt - kMarginPt;
    panels.push_back({{kMarginPt, split}, {right, bottom}, x, speed_axis(curves)});
  }
  const std::vector<Frame> frames = draw_aligned(drawing, panels);
  const int beyond = fill_panel(drawing, frames[0], curves, series);
  if (has_speed) {
    const Series speed = look("lateral speed asked for", kPurple, 1.1, {}, Marker::none);
    fill_panel(drawing, frames[1], curves, {over_time(speed, curves, curves.right_mps)});
  }
  return finish(name, following_caption(curves, beyond, has_speed), drawing, curves_table(curves), options);
}

namespace {

Series by_picture(Series look, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) look.x.push_back(static_cast<double>(i + 1));
  look.y = values;
  return look;
}

std::vector<Series> hand_series(const DeviationByHand& flight) {
  std::vector<Series> series = {
      by_picture(look("by hand", kBlack, 1.0, {5.0, 2.0}, Marker::ring), flight.by_hand),
      by_picture(look("thesis's deviation", kVermillion, 0.9, {}, Marker::triangle), flight.thesis),
      by_picture(look("filtered", kBlue, 1.2, {}, Marker::circle), flight.filtered)};
  return series;
}

base::CsvTable hand_table(const std::vector<DeviationByHand>& flights) {
  const std::string unit = "_" + flights.front().unit;
  base::CsvTable table;
  table.columns = {"flight", "picture", "by_hand" + unit, "thesis" + unit, "filtered" + unit};
  for (const DeviationByHand& flight : flights) {
    for (std::size_t i = 0; i < flight.pictures.size(); ++i)
      table.rows.push_back({flight.flight, flight.pictures[i], cell(flight.by_hand[i], 4),
                            cell(flight.thesis[i], 4), cell(flight.filtered[i], 4)});
  }
  return table;
}

Panel hand_panel(const DeviationByHand& flight, const Point& corner, const Point& end) {
  std::vector<double> values = {0.0};
  for (const Series& one : hand_series(flight)) values.insert(values.end(), one.y.begin(), one.y.end());
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return {corner + Point(0, kTitlePt), end,
          counting_axis("picture number", flight.pictures.size(), end.x() - corner.x()),
          axis_over("deviation / " + flight.unit, values, 6)};
}

void fill_hand_panel(Drawing& drawing, const Frame& frame, const DeviationByHand& flight) {
  draw_level(drawing, frame, 0.0, kMidGrey, {}, 0.6);
  const double middle = 0.5 * (frame.top_left.x() + frame.bottom_right.x());
  drawing.items.push_back(
      Text{{middle, frame.top_left.y() - 4.0}, flight.flight, kLegendTextPt, kInk, Align::middle, true});
  draw_series(drawing, frame, hand_series(flight));
}

}  // namespace

Result<Figure> deviation_by_hand(const std::vector<DeviationByHand>& flights, const FigureOptions& options) {
  const std::string name = "deviation_by_hand";
  if (flights.empty()) return nothing_to_draw(name, "no flight", "at least one");
  FURROW_TRY(Drawing drawing, paper(options, kPanelMm * static_cast<double>(flights.size()) + 8.0));
  const double right = drawing.width_pt - kMarginPt;
  std::vector<LegendEntry> legend;
  for (const Series& one : hand_series(flights.front())) legend.push_back(legend_of(one));
  const double top = kMarginPt + draw_legend(drawing, {kMarginPt, kMarginPt}, right - kMarginPt, legend);
  const double height = (drawing.height_pt - top - kMarginPt) / static_cast<double>(flights.size());
  std::vector<Panel> panels;
  std::size_t pictures = 0;
  for (const DeviationByHand& flight : flights) {
    const double from = top + height * static_cast<double>(panels.size());
    panels.push_back(hand_panel(flight, {kMarginPt, from}, {right, from + height - 4.0}));
    pictures += flight.pictures.size();
  }
  const std::vector<Frame> frames = draw_aligned(drawing, panels);
  for (std::size_t k = 0; k < flights.size(); ++k) fill_hand_panel(drawing, frames[k], flights[k]);
  return finish(name,
                "Deviation from the followed row read by hand and by the algorithms, " +
                    count_of(pictures, "picture") + " of " + count_of(flights.size(), "flight") + ".",
                drawing, hand_table(flights), options);
}

namespace {

image::Rgb rgb(Colour colour) {
  return {colour.r, colour.g, colour.b};
}

image::InkLine upright(double u, int height, Colour colour, double width_px) {
  return {{{u, 0.0}, {u, height - 1.0}}, rgb(colour), width_px};
}

image::InkLine along(const rows::RowLine& row, Colour colour, double width_px) {
  image::InkLine line{{}, rgb(colour), width_px};
  for (const rows::RowSample& sample : row.samples) line.points_px.push_back(sample.centre_px);
  return line;
}

// Pure colours of the thesis's figure, which say more on leaves than the print palette.
constexpr Colour kThesisGreen{0x00, 0xE0, 0x30}, kThesisRed{0xFF, 0x20, 0x20}, kThesisBlue{0x30, 0x80, 0xFF};

std::string signed_fixed(double value, int decimals) {
  return (value < 0.0 ? "" : "+") + base::format_fixed(value, decimals);
}

/// What steering goes by, as a length on the picture's middle row; metres by the row spacing there, and of a
/// row alone, which has none, its deviation.
std::optional<double> steering_px(const follow::Following& f, const follow::FollowerOptions& options) {
  if (options.rule == follow::Rule::thesis) return f.thesis.steer_px;
  const double px_per_unit = f.sighting.place.spacing_px / f.sighting.spacing;
  if (!f.offset) return std::nullopt;
  return std::isfinite(px_per_unit) ? f.offset->value * px_per_unit : f.sighting.deviation_px;
}

std::vector<std::string> words(const follow::Following& f, bool is_metric) {
  std::vector<std::string> lines;
  std::string row = f.row ? "row " + std::to_string(*f.row) : "no row";
  if (f.event == follow::RowEvent::changed) row += ", changed";
  if (f.event == follow::RowEvent::started) row += ", counted anew";
  lines.push_back((f.is_hold ? "HOLD  " : "FOLLOW  ") + row);
  if (f.is_hold) lines.push_back(f.hold_reason);
  const int decimals = is_metric ? 2 : 1;
  const std::string unit = is_metric ? " m" : " px";
  if (f.offset) {
    lines.push_back("offset " + signed_fixed(f.offset->value, decimals) + " +- " +
                    base::format_fixed(f.offset->sigma, decimals) + unit);
  }
  if (f.heading_rad)
    lines.push_back("heading " + signed_fixed(geom::rad_to_deg(f.heading_rad->value), 1) + " deg");
  if (f.deviation_cm) lines.push_back("thesis " + signed_fixed(*f.deviation_cm, 1) + " cm");
  return lines;
}

}  // namespace

Image following_picture(Image picture, const rows::RowLines& lines, const follow::Following& following,
                        const follow::FollowerOptions& options) {
  const double unit = std::max(1.0, picture.height / 360.0);  // pens and type grow with the picture
  const double u_middle = 0.5 * (picture.width - 1), v_middle = 0.5 * (picture.height - 1);
  std::vector<image::InkLine> ink;
  std::optional<double> u_followed;
  const int followed = following.row && following.nearest_row ? *following.row - *following.nearest_row : 0;
  for (const rows::RowLine& row : lines.rows) {
    if (row.index != followed) ink.push_back(along(row, kSkyBlue, unit));
  }
  for (const rows::RowLine& row : lines.rows) {
    if (row.index != followed) continue;
    ink.push_back(along(row, kOrange, 1.5 * unit));
    u_followed = rows::u_at(row, v_middle);
  }
  ink.push_back(upright(u_middle, picture.height, kThesisGreen, unit));
  if (u_followed) ink.push_back(upright(*u_followed, picture.height, kThesisRed, unit));
  if (const auto steer_px = steering_px(following, options)) {
    // An arrow that points out of the picture ends at its border.
    const double tip = std::clamp(u_middle + *steer_px, 0.01 * picture.width, 0.99 * picture.width);
    image::InkLine arrow{{{u_middle, v_middle}, {tip, v_middle}}, rgb(kThesisBlue), 2.0 * unit};
    arrow.has_arrow = true;
    ink.push_back(arrow);
  }
  std::vector<image::InkText> texts;
  for (const std::string& line : words(following, options.is_metric)) {
    const double at = 18.0 + 15.0 * static_cast<double>(texts.size());
    texts.push_back({{8.0 * unit, at * unit}, line, 7.5 * unit, rgb(kWhite)});
  }
  return image::inked(std::move(picture), ink, texts);
}

}  // namespace furrow::figures
