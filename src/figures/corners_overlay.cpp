// A photograph of a board with its corners as found and as projected.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "figures/finish.h"
#include "figures/font.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/figures/pictures.h"

namespace furrow::figures {
namespace {

constexpr Colour kLeftOut = kVermillion;
constexpr Colour kBoardAxes = kOrange;
/// Rims under every mark: on black squares the pale one shows it, on white ones the dark one.
constexpr Colour kDarkRim{0x10, 0x10, 0x10};
constexpr Colour kPaleRim{0xF0, 0xF0, 0xF0};

/// How marks over the photograph are drawn, the same in every picture of a calibration.
struct Marks {
  double enlarged = 1.0;  ///< how many times the residuals are
  int decimals = 0;       ///< that this number needs
  double top_px = 1.0;    ///< residual of the brightest colour
  double ring_pt = 5.0;
};

Marks marks_for(const calib::TellingViews& views, double pt_per_px) {
  Marks marks;
  const double typical_px = std::isfinite(views.residual_px) ? std::max(views.residual_px, 1e-9) : 1.0;
  const double spacing_px = std::isfinite(views.spacing_px) ? views.spacing_px : 1.0;
  // Typical lines stay short of the neighbour, by a round factor.
  constexpr double kLongest = 0.7, kRing = 0.35, kSmallestPt = 3.5, kLargestPt = 9.0;
  const Ticks steps = nice_ticks(0.0, kLongest * spacing_px / typical_px, 5);
  if (steps.values.size() > 1) {
    marks.enlarged = steps.values.back();
    marks.decimals = steps.decimals;
  }
  marks.top_px = typical_px;
  marks.ring_pt = std::clamp(kRing * spacing_px * pt_per_px, kSmallestPt, kLargestPt);
  return marks;
}

/// Axes in pixels around a photograph that keeps its shape; sets the drawing's height to what they take.
Frame photograph_frame(Drawing& drawing, const calib::TellingView& view) {
  const Axis x = axis_between("u / px", view.left_px - 0.5, view.left_px + view.width_px - 0.5, 8);
  const Axis y = axis_between("v / px", view.top_px - 0.5, view.top_px + view.height_px - 0.5, 6);
  constexpr double kTallestShare = 1.1;  // of the width: an upright picture must not fill pages
  const double right = drawing.width_pt - kMarginPt, any_pt = 100.0;
  Drawing scratch = drawing;  // what the axes' texts take does not depend on the height
  const Frame trial = draw_axes(scratch, {kMarginPt, kMarginPt}, {right, any_pt}, x, flipped(y), Grid::none);
  const double above = trial.top_left.y(), below = any_pt - trial.bottom_right.y();
  const double widest = trial.bottom_right.x() - trial.top_left.x();
  const double shape = static_cast<double>(view.height_px) / view.width_px;
  const double width = std::min(widest, kTallestShare * drawing.width_pt / shape);
  drawing.height_pt = above + width * shape + below;
  return draw_axes(drawing, {kMarginPt, kMarginPt}, {right - (widest - width), drawing.height_pt}, x,
                   flipped(y), Grid::none);
}

void draw_rimmed(Drawing& drawing, const Frame& frame, const std::vector<Point>& points, Colour colour,
                 double width_pt) {
  add_rimmed(drawing, points, frame.top_left, frame.bottom_right,
             {{kPaleRim, width_pt + 1.4}, {kDarkRim, width_pt + 0.7}, {colour, width_pt}});
}

bool inside(const Frame& frame, const Point& at) {
  return is_within(at, frame.top_left, frame.bottom_right);
}

/// One axis of the board; its name stands at its end, outside the board, opposite to where the other axis
/// runs; where the picture ends there, farther along its own.
void draw_board_axis(Drawing& drawing, const Frame& frame, const std::vector<Eigen::Vector2d>& axis_px,
                     const std::vector<Eigen::Vector2d>& other_px, const std::string& name) {
  std::vector<Point> points;
  points.reserve(axis_px.size());
  for (const Eigen::Vector2d& px : axis_px) points.push_back(frame.map(px.x(), px.y()));
  draw_rimmed(drawing, frame, points, kBoardAxes, 1.5);
  if (points.size() < 2 || other_px.size() < 2) return;
  constexpr double kSizePt = 8.0;
  const Point other = frame.map(other_px.back().x(), other_px.back().y()) - points.front();
  const Point own = points.back() - points.front(), room(kSizePt, kSizePt);
  Point at = points.back() - 1.4 * kSizePt * other.normalized();
  if (!inside(frame, at - room) || !inside(frame, at + room))
    at = points.back() + 1.4 * kSizePt * own.normalized();
  if (inside(frame, at - room) && inside(frame, at + room))
    add_label(drawing, at, name, kSizePt, kBlack, kBoardAxes);
}

void draw_board_axes(Drawing& drawing, const Frame& frame, const calib::TellingView& view) {
  draw_board_axis(drawing, frame, view.x_axis_px, view.y_axis_px, "x");
  draw_board_axis(drawing, frame, view.y_axis_px, view.x_axis_px, "y");
  if (view.x_axis_px.empty()) return;
  const Point origin = frame.map(view.x_axis_px.front().x(), view.x_axis_px.front().y());
  if (!inside(frame, origin)) return;
  add_marker(drawing, Marker::square, origin, 6.5, kDarkRim);
  add_marker(drawing, Marker::square, origin, 5.0, kBoardAxes);
}

/// A ring as a closed band: lines round it would leave gaps at their joints.
Band ring(const Point& at, double radius_pt, double pen_pt, Colour colour) {
  constexpr int kSides = 20;
  Band band;
  band.colour = colour;
  for (int i = 0; i <= kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    const Point way(std::cos(angle), std::sin(angle));
    band.upper.push_back(at + (radius_pt + 0.5 * pen_pt) * way);
    band.lower.push_back(at + (radius_pt - 0.5 * pen_pt) * way);
  }
  return band;
}

void draw_mark(Drawing& drawing, bool is_cross, const Point& at, double size_pt, Colour colour) {
  const double half = 0.5 * size_pt, pen_pt = 0.5 + 0.08 * size_pt;
  for (const auto& [ink, width] :
       {std::pair{kPaleRim, pen_pt + 1.4}, std::pair{kDarkRim, pen_pt + 0.7}, std::pair{colour, pen_pt}}) {
    if (is_cross) {
      drawing.items.push_back(Stroke{{at + Point(-half, -half), at + Point(half, half)}, ink, width});
      drawing.items.push_back(Stroke{{at + Point(-half, half), at + Point(half, -half)}, ink, width});
    } else {
      drawing.items.push_back(ring(at, half, width, ink));
    }
  }
}

void draw_plus(Drawing& drawing, const Point& at, double size_pt) {
  const double half = 0.5 * size_pt;
  for (const auto& [ink, width] : {std::pair{kDarkRim, 1.2}, std::pair{kWhite, 0.6}}) {
    drawing.items.push_back(Stroke{{at - Point(half, 0), at + Point(half, 0)}, ink, width});
    drawing.items.push_back(Stroke{{at - Point(0, half), at + Point(0, half)}, ink, width});
  }
}

bool is_left_out(const calib::View& view, std::size_t corner) {
  return !view.left_out.empty() && view.left_out[corner];
}

void draw_corner(Drawing& drawing, const Frame& frame, const Marks& marks, const calib::View& view,
                 std::size_t c) {
  const Eigen::Vector2d found = view.observed_px[c], residual = view.residual_px[c];
  const Point at = frame.map(found.x(), found.y());
  if (!found.allFinite() || !inside(frame, at)) return;
  if (residual.allFinite()) {
    const Eigen::Vector2d projected = found - residual, tip = found + marks.enlarged * residual;
    const Colour colour = is_left_out(view, c) ? kLeftOut : viridis(residual.norm() / marks.top_px);
    draw_mark(drawing, is_left_out(view, c), at, marks.ring_pt, colour);
    draw_rimmed(drawing, frame, {at, frame.map(tip.x(), tip.y())}, colour, 0.9);
    const Point plus = frame.map(projected.x(), projected.y());
    if (inside(frame, plus)) draw_plus(drawing, plus, 0.7 * marks.ring_pt);
  } else {
    draw_mark(drawing, true, at, marks.ring_pt, kLeftOut);
  }
}

base::CsvTable corners_table(const calib::View& view) {
  base::CsvTable table;
  table.columns = {"corner_id",      "u_px",          "v_px",          "projected_u_px",
                   "projected_v_px", "residual_u_px", "residual_v_px", "left_out"};
  for (std::size_t c = 0; c < view.residual_px.size(); ++c) {
    const Eigen::Vector2d found = view.observed_px[c], residual = view.residual_px[c],
                          projected = found - residual;
    const int id = view.corner_ids.empty() ? static_cast<int>(c) : view.corner_ids[c];
    table.rows.push_back({std::to_string(id), cell(found.x(), 4), cell(found.y(), 4), cell(projected.x(), 4),
                          cell(projected.y(), 4), cell(residual.x(), 4), cell(residual.y(), 4),
                          is_left_out(view, c) ? "yes" : "no"});
  }
  return table;
}

std::vector<LegendEntry> legend(const calib::View& view, const calib::TellingView& shown,
                                const Marks& marks) {
  if (view.residual_px.empty()) return {};
  LegendEntry found{"corner as found", viridis(0.5)}, projected{"as projected", kMidGrey},
      left_out{"left out as an outlier", kLeftOut};
  found.marker = Marker::ring;
  projected.marker = Marker::plus;
  left_out.marker = Marker::cross;
  found.marker_pt = projected.marker_pt = left_out.marker_pt = 5.5;
  const LegendEntry line{
      "found minus projected, " + tick_text(marks.enlarged, marks.decimals) + " times enlarged", viridis(0.5),
      0.9};
  std::vector<LegendEntry> entries{found, projected, line};
  if (std::count(view.left_out.begin(), view.left_out.end(), true) > 0) entries.push_back(left_out);
  if (!shown.x_axis_px.empty()) entries.push_back({"the board's first corner, x and y", kBoardAxes, 1.5});
  return entries;
}

std::string what_is_shown(const calib::View& view, const calib::TellingView& shown) {
  const std::string first = "View " + std::to_string(shown.view + 1) + ", " + view.image + ": " + shown.why;
  if (!view.used) return first + ": " + view.reason;
  const auto left_out =
      static_cast<std::size_t>(std::count(view.left_out.begin(), view.left_out.end(), true));
  return first + "; RMS " + base::format_fixed(view.rms_px, 3) + " px over " +
         count_of(view.observed_px.size() - left_out, "corner") +
         (left_out == 0 ? "" : ", " + std::to_string(left_out) + " left out");
}

std::string caption(const calib::View& view, const calib::TellingView& shown, const Camera& camera,
                    const Marks& marks) {
  std::string text = what_is_shown(view, shown) + ".";
  if (shown.width_px != camera.width || shown.height_px != camera.height)
    text += " The part of the picture around the board.";
  if (view.residual_px.empty()) return text;
  return text +
         " Rings are the corners as found, plus signs where the solved camera puts them; lines lead from a "
         "ring the way it lies off its plus sign, " +
         tick_text(marks.enlarged, marks.decimals) +
         " times enlarged as in the other views. Of all used corners 95 % lie within " +
         cell(marks.top_px, 3) + " px, the end of the colours.";
}

}  // namespace

Result<Figure> corners_overlay(const Image& picture, const calib::Calibration& calibration,
                               const calib::TellingViews& views, std::size_t which,
                               const FigureOptions& options) {
  check(which < views.views.size() && views.views[which].view < calibration.views.size(),
        "corners_overlay: a view that is not there");
  const calib::TellingView& shown = views.views[which];
  const calib::View& view = calibration.views[shown.view];
  const std::string name = "corners_view_" + std::to_string(shown.view + 1);
  if (picture.empty() || shown.width_px < 1 || shown.height_px < 1)
    return nothing_to_draw(name, "an empty picture", "the view's picture");
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  const Frame frame = photograph_frame(drawing, shown);
  const Point size = frame.bottom_right - frame.top_left;
  drawing.pictures.push_back({picture, frame.top_left, size.x(), size.y(), false});
  const Marks marks = marks_for(views, size.x() / shown.width_px);
  draw_board_axes(drawing, frame, shown);
  for (std::size_t c = 0; c < view.residual_px.size(); ++c) draw_corner(drawing, frame, marks, view, c);

  const double inner = drawing.width_pt - 2 * kMarginPt;
  drawing.height_pt += kMarginPt;
  std::string title = what_is_shown(view, shown);
  if (text_width_pt(title, kLegendTextPt, true) > inner) title = title.substr(0, title.rfind(": "));
  drawing.items.push_back(
      Text{{kMarginPt, drawing.height_pt + kLegendTextPt}, title, kLegendTextPt, kInk, Align::start, true});
  drawing.height_pt += 1.7 * kLegendTextPt;
  const auto entries = legend(view, shown, marks);
  if (!entries.empty()) {
    drawing.height_pt += draw_legend(drawing, {kMarginPt, drawing.height_pt}, inner, entries);
    drawing.height_pt += draw_colour_bar(
        drawing, {frame.top_left.x(), drawing.height_pt}, size.x() - kTickTextPt,
        axis_between("from projected to found / px; brighter is not told apart", 0.0, marks.top_px, 6));
  }
  drawing.height_pt += kMarginPt;
  return finish(name, caption(view, shown, calibration.camera, marks), drawing, corners_table(view), options);
}

}  // namespace furrow::figures
