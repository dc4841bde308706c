// A photograph with the rows that were found in it.
#include <algorithm>
#include <cmath>

#include "figures/finish.h"
#include "figures/font.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/base/whole.h"
#include "furrow/figures/figures.h"
#include "furrow/figures/pictures.h"

namespace furrow::figures {
namespace {

constexpr Colour kFollowed = kOrange;
constexpr Colour kNeighbour = kSkyBlue;
constexpr Colour kEdge = kWhite;
/// Dark rim under every line: it stays visible on leaves, soil and sky.
constexpr Colour kRim{0x10, 0x10, 0x10, 170};

/// The photograph's place on the paper.
struct Place {
  Point top_left, bottom_right;
  double pt_per_px;

  /// Pixel (0, 0) is the centre of the top-left pixel.
  Point map(const Eigen::Vector2d& px) const {
    return top_left + pt_per_px * (px + Eigen::Vector2d(0.5, 0.5));
  }
};

void draw_rimmed(Drawing& drawing, const Place& place, const std::vector<Point>& points, Colour colour,
                 double width_pt, const Dash& dash) {
  add_rimmed(drawing, points, place.top_left, place.bottom_right,
             {{kRim, width_pt + 1.0}, {colour, width_pt}}, dash);
}

std::vector<Point> centre_line(const Place& place, const rows::RowLine& row) {
  std::vector<Point> points;
  for (const rows::RowSample& sample : row.samples) {
    if (sample.centre_px.allFinite()) points.push_back(place.map(sample.centre_px));
  }
  return points;
}

/// One side of the row, in the parts where it was seen.
void draw_edge(Drawing& drawing, const Place& place, const rows::RowLine& row,
               double rows::RowSample::*side) {
  std::vector<Point> points;
  const auto flush = [&] {
    if (points.size() > 1) draw_rimmed(drawing, place, points, kEdge, 0.5, {});
    points.clear();
  };
  for (const rows::RowSample& sample : row.samples) {
    if (std::isfinite(sample.*side) && std::isfinite(sample.centre_px.y())) {
      points.push_back(place.map({sample.*side, sample.centre_px.y()}));
    } else {
      flush();
    }
  }
  flush();
}

void draw_row(Drawing& drawing, const Place& place, const rows::RowLine& row) {
  const bool followed = row.index == 0;
  draw_edge(drawing, place, row, &rows::RowSample::left_u_px);
  draw_edge(drawing, place, row, &rows::RowSample::right_u_px);
  draw_rimmed(drawing, place, centre_line(place, row), followed ? kFollowed : kNeighbour,
              followed ? 2.0 : 1.3, row.seen ? Dash{} : Dash{4.0, 2.5});
}

/// Each row's index where its line leaves the picture at the bottom. Far rows leave it close to each other: a
/// number that would cover that of a nearer row is left out.
void draw_indices(Drawing& drawing, const Place& place, std::vector<rows::RowLine> all) {
  constexpr double kSizePt = 8.0;
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return std::abs(a.index) < std::abs(b.index); });
  std::vector<std::pair<Point, Point>> taken;  // middle and half size
  for (const rows::RowLine& row : all) {
    const auto parts = clip(centre_line(place, row), place.top_left, place.bottom_right);
    if (parts.empty()) continue;
    const std::string text = tick_text(row.index, 0);
    const Point half(0.5 * text_width_pt(text, kSizePt) + 0.4 * kSizePt, 0.8 * kSizePt);
    const Point at = parts.back().back().cwiseMax(place.top_left + half).cwiseMin(place.bottom_right - half);
    const bool covers = std::any_of(taken.begin(), taken.end(), [&](const auto& other) {
      return ((at - other.first).cwiseAbs().array() < (half + other.second).array()).all();
    });
    if (covers) continue;
    taken.push_back({at, half});
    add_label(drawing, at, text, kSizePt, kBlack, row.index == 0 ? kFollowed : kNeighbour);
  }
}

bool inside(const Place& place, const Eigen::Vector2d& px) {
  return is_within(place.map(px), place.top_left, place.bottom_right);
}

/// A ring at the vanishing point with thin lines towards it, or an arrow at the border that points there.
void draw_vanishing_point(Drawing& drawing, const Place& place, const Eigen::Vector2d& at_px) {
  const Point at = place.map(at_px);
  const Point inner_low = place.top_left + Point(3, 3), inner_high = place.bottom_right - Point(3, 3);
  if (inside(place, at_px)) {
    add_marker(drawing, Marker::ring, at, 11.0, kBlack);
    add_marker(drawing, Marker::ring, at, 10.0, kPurple);
    add_marker(drawing, Marker::circle, at, 2.5, kPurple);
    return;
  }
  const Point tip = at.cwiseMax(inner_low).cwiseMin(inner_high);
  const Point middle = 0.5 * (place.top_left + place.bottom_right);
  const Point back = (middle - at).normalized();
  const Point side(-back.y(), back.x());
  for (const double grow : {1.2, 0.0}) {
    const Point point = tip - grow * back;
    const double length = 10.0 + 2 * grow, half = 4.5 + grow;
    drawing.items.push_back(
        Fill{{point, point + length * back + half * side, point + length * back - half * side},
             grow > 0.0 ? kRim : kPurple});
  }
}

std::vector<LegendEntry> legend(const rows::RowLines& lines, const Place& place) {
  LegendEntry followed{"followed row (0)", kFollowed, 2.0}, other{"other rows", kNeighbour, 1.3},
      carried{"not seen, carried by the field", kNeighbour, 1.3, {4.0, 2.5}},
      edge{"row edges", kMidGrey, 0.6}, vanishing{"vanishing point", kPurple};
  vanishing.marker = Marker::ring;
  vanishing.marker_pt = 7.0;
  std::vector<LegendEntry> entries;
  const auto any = [&](auto&& test) { return std::any_of(lines.rows.begin(), lines.rows.end(), test); };
  if (any([](const auto& row) { return row.index == 0; })) entries.push_back(followed);
  if (any([](const auto& row) { return row.index != 0 && row.seen; })) entries.push_back(other);
  if (any([](const auto& row) { return !row.seen; })) entries.push_back(carried);
  if (any([](const auto& row) {
        return std::any_of(row.samples.begin(), row.samples.end(), [](const auto& s) {
          return std::isfinite(s.left_u_px) || std::isfinite(s.right_u_px);
        });
      })) {
    entries.push_back(edge);
  }
  if (lines.vanishing_point_px && lines.vanishing_point_px->allFinite()) {
    if (!inside(place, *lines.vanishing_point_px)) {
      vanishing.name = "towards the vanishing point";
      vanishing.marker = Marker::triangle;
    }
    entries.push_back(vanishing);
  }
  return entries;
}

std::string verdict(const rows::RowLines& lines) {
  if (!lines.ok()) return "no rows: " + (lines.reason.empty() ? lines.status : lines.reason);
  return count_of(lines.rows.size(), "row") + ", method " + lines.method + ", confidence " +
         base::format_fixed(lines.confidence, 2);
}

base::CsvTable rows_table(const rows::RowLines& lines) {
  base::CsvTable table;
  table.columns = {"row_index", "seen", "u_px", "v_px", "sigma_px", "left_u_px", "right_u_px"};
  for (const rows::RowLine& row : lines.rows) {
    for (const rows::RowSample& sample : row.samples) {
      table.rows.push_back({std::to_string(row.index), row.seen ? "yes" : "no", cell(sample.centre_px.x(), 3),
                            cell(sample.centre_px.y(), 3), cell(sample.sigma_px, 3),
                            cell(sample.left_u_px, 3), cell(sample.right_u_px, 3)});
    }
  }
  return table;
}

/// Where an axis of the fitted field runs, or its edges, through the whole bird's-eye view.
void draw_fitted(Drawing& drawing, const Place& place, const Frame& frame, double left_m, Colour colour,
                 double width_pt, const Dash& dash) {
  draw_rimmed(drawing, place, {frame.map(left_m, frame.y.low), frame.map(left_m, frame.y.high)}, colour,
              width_pt, dash);
}

/// Every row of the fitted field that the view holds, row 0 on top.
void draw_field(Drawing& drawing, const Place& place, const Frame& frame, const altitude::BirdsEye& view) {
  const double left = frame.x.low, right = frame.x.high;  // the axis is flipped: left is the higher value
  constexpr int kFarthest = 10000;                        // row numbers: more than paper has room for
  const int first = base::ceil_between((-view.cross_track_m - left) / view.spacing_m, -kFarthest, kFarthest);
  const int last = base::floor_between((-view.cross_track_m - right) / view.spacing_m, -kFarthest, kFarthest);
  for (int k = first; k <= last; ++k) {
    const double axis = -view.cross_track_m - k * view.spacing_m;
    for (const double side : {-1.0, 1.0}) {
      draw_fitted(drawing, place, frame, axis + side * view.half_width_m, kEdge, 0.6, {3.0, 2.0});
    }
    draw_fitted(drawing, place, frame, axis, k == 0 ? kFollowed : kNeighbour, k == 0 ? 1.6 : 1.1, {});
  }
}

void draw_found(Drawing& drawing, const Frame& frame, const std::vector<Eigen::Vector2d>& points_m,
                Colour colour, double size_pt) {
  for (const Eigen::Vector2d& point : points_m) {
    const Point at = frame.map(point.y(), point.x());
    if ((at.array() < frame.top_left.array()).any() || (at.array() > frame.bottom_right.array()).any())
      continue;
    add_marker(drawing, Marker::circle, at, size_pt + 0.8, kRim);
    add_marker(drawing, Marker::circle, at, size_pt, colour);
  }
}

base::CsvTable ground_table(const altitude::BirdsEye& view) {
  base::CsvTable table;
  table.columns = {"row_index", "line", "ahead_m", "left_m"};
  for (const altitude::GroundRow& row : view.rows) {
    const std::pair<const char*, const std::vector<Eigen::Vector2d>*> lines[] = {
        {"centre", &row.centre_m}, {"left edge", &row.left_m}, {"right edge", &row.right_m}};
    for (const auto& [name, points] : lines) {
      for (const Eigen::Vector2d& point : *points)
        table.rows.push_back({std::to_string(row.index), name, cell(point.x(), 3), cell(point.y(), 3)});
    }
  }
  return table;
}

}  // namespace

Result<Figure> birds_eye(const altitude::BirdsEye& view, const std::string& shot_id,
                         const FigureOptions& options) {
  const std::string name = "birds_eye_" + file_stem(shot_id);
  if (view.picture.empty() || !(view.px_per_m > 0.0)) {
    return nothing_to_draw(name, "an empty view", "a refined shot's view from above");
  }
  const double wide_m = view.picture.width / view.px_per_m, long_m = view.picture.height / view.px_per_m;
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  const double inner = drawing.width_pt - 2 * kMarginPt;
  LegendEntry axis{"fitted rows", kNeighbour, 1.1}, followed{"followed row (0)", kFollowed, 1.6},
      edges{"fitted edges", kMidGrey, 0.6, {3.0, 2.0}}, found{"edges as found", kVermillion};
  found.marker = Marker::circle;
  drawing.height_pt = 1.0;
  const double legend_pt =
      draw_legend(drawing, {kMarginPt, kMarginPt}, inner, {followed, axis, edges, found});
  const Axis x = axis_between("left of the camera / m", view.left_m - wide_m, view.left_m, 8);
  const Axis y = axis_between("ahead of the camera / m", view.ahead_m - long_m, view.ahead_m, 6);
  constexpr double kAxesPt = 40.0, kTallestShare = 1.2;
  const double scale = std::min(inner - kAxesPt, kTallestShare * inner * wide_m / long_m) / wide_m;
  drawing.height_pt = legend_pt + kMarginPt + scale * long_m + kAxesPt;
  const Frame frame =
      draw_axes(drawing, {kMarginPt, kMarginPt + legend_pt},
                {kMarginPt + kAxesPt + scale * wide_m, drawing.height_pt - kMarginPt}, flipped(x), y);
  const Point size = frame.bottom_right - frame.top_left;
  drawing.pictures.push_back({view.picture, frame.top_left, size.x(), size.y(), false});
  const Place place{frame.top_left, frame.bottom_right, size.x() / view.picture.width};
  draw_field(drawing, place, frame, view);
  for (const altitude::GroundRow& row : view.rows) {
    draw_found(drawing, frame, row.left_m, kVermillion, 1.6);
    draw_found(drawing, frame, row.right_m, kVermillion, 1.6);
  }
  const std::string caption =
      shot_id + " from straight above the plane of the row tops, with the refined field (spacing " +
      cell(view.spacing_m, 2) +
      " m) and the edges as found. Only what lies in that plane is true to scale: "
      "soil and walls lean away from the camera.";
  return finish(name, caption, drawing, ground_table(view), options);
}

Result<Figure> row_overlay(const Image& picture, const rows::RowLines& lines, const std::string& shot_id,
                           const FigureOptions& options) {
  const std::string name = "rows_" + file_stem(shot_id);
  if (picture.empty() || picture.width < 1 || picture.height < 1) {
    return nothing_to_draw(name, "an empty picture", "the shot's picture");
  }
  if (lines.ok() && (lines.width != picture.width || lines.height != picture.height)) {
    return Error{
        "picture_size_differs", shot_id,
        "rows of a picture of " + std::to_string(lines.width) + "x" + std::to_string(lines.height) + " px",
        std::to_string(picture.width) + "x" + std::to_string(picture.height) + " px as the picture has", ""};
  }
  constexpr double kTallestShare = 1.4;  // of the width: a panorama turned upright must not fill pages
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  const double inner_width = drawing.width_pt;
  const double scale = std::min(inner_width / picture.width, kTallestShare * inner_width / picture.height);
  const Point size(picture.width * scale, picture.height * scale);
  const Point corner(0.5 * (drawing.width_pt - size.x()), 0.0);
  const Place place{corner, corner + size, scale};
  drawing.pictures.push_back({picture, place.top_left, size.x(), size.y(), false});

  for (const rows::RowLine& row : lines.rows) {
    if (row.index != 0) draw_row(drawing, place, row);
  }
  for (const rows::RowLine& row : lines.rows) {
    if (row.index == 0) draw_row(drawing, place, row);
  }
  draw_indices(drawing, place, lines.rows);
  if (lines.vanishing_point_px && lines.vanishing_point_px->allFinite()) {
    draw_vanishing_point(drawing, place, *lines.vanishing_point_px);
  }
  const Point below(kMarginPt, place.bottom_right.y() + kMarginPt);
  drawing.items.push_back(Text{below + Point(0, kLegendTextPt), shot_id + ": " + verdict(lines),
                               kLegendTextPt, kInk, Align::start, true});
  drawing.height_pt = below.y() + 1.7 * kLegendTextPt + kMarginPt;
  drawing.height_pt += draw_legend(drawing, {kMarginPt, below.y() + 1.7 * kLegendTextPt},
                                   drawing.width_pt - 2 * kMarginPt, legend(lines, place));

  std::string caption = "Rows found in " + shot_id + ": " + verdict(lines) + ". ";
  caption += "Rows are numbered from left to right; 0 is the followed one.";
  if (lines.vanishing_point_px && lines.vanishing_point_px->allFinite()) {
    caption += " They meet at (" + cell(lines.vanishing_point_px->x(), 0) + ", " +
               cell(lines.vanishing_point_px->y(), 0) + ") px.";
  }
  return finish(name, caption, drawing, rows_table(lines), options);
}

}  // namespace furrow::figures
