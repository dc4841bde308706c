// A photograph with the rows that were found in it.
#include <algorithm>
#include <cmath>

#include "figures/finish.h"
#include "figures/font.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/figures/figures.h"

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
  for (const auto& part : clip(points, place.top_left, place.bottom_right)) {
    drawing.items.push_back(Stroke{part, kRim, width_pt + 1.0, dash});
    drawing.items.push_back(Stroke{part, colour, width_pt, dash});
  }
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
  const Point at = place.map(px);
  return (at.array() >= place.top_left.array()).all() && (at.array() <= place.bottom_right.array()).all();
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

}  // namespace

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
