#include "figures/drawing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "figures/font.h"

namespace furrow::figures {
namespace {

/// Share of the segment a -> b inside the box, as two parameters.
std::optional<std::pair<double, double>> inside_span(const Point& a, const Point& b, const Point& low,
                                                     const Point& high) {
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 2; ++axis) {
    const double step = b[axis] - a[axis];
    if (step == 0.0) {
      if (a[axis] < low[axis] || a[axis] > high[axis]) return std::nullopt;
      continue;
    }
    const double t1 = (low[axis] - a[axis]) / step, t2 = (high[axis] - a[axis]) / step;
    enter = std::max(enter, std::min(t1, t2));
    leave = std::min(leave, std::max(t1, t2));
  }
  if (enter > leave) return std::nullopt;
  return std::pair{enter, leave};
}

std::vector<Point> regular_polygon(const Point& centre, double radius, int corners, double first_rad) {
  std::vector<Point> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = first_rad + 2.0 * std::numbers::pi * i / corners;
    points.push_back(centre + radius * Point(std::cos(angle), std::sin(angle)));
  }
  return points;
}

}  // namespace

std::vector<std::vector<Point>> dashes(const Stroke& stroke) {
  // More dashes than any paper shows; and so few that each of them moves along the line.
  constexpr double kMostPeriods = 1e5;
  double period = 0.0, length = 0.0;
  for (const double part : stroke.dash) period += part;
  for (std::size_t i = 1; i < stroke.points.size(); ++i)
    length += (stroke.points[i] - stroke.points[i - 1]).norm();
  const bool negative =
      std::any_of(stroke.dash.begin(), stroke.dash.end(), [](double part) { return part < 0.0; });
  if (negative || stroke.points.size() < 2 || !(period > 0.0) || !(length / period <= kMostPeriods))
    return {stroke.points};

  std::vector<std::vector<Point>> ink;
  std::size_t part = 0;
  double left = stroke.dash[0];
  std::vector<Point> current{stroke.points.front()};
  for (std::size_t i = 1; i < stroke.points.size(); ++i) {
    const Point& from = stroke.points[i - 1];
    const Point step = stroke.points[i] - from;
    const double whole = step.norm();
    double along = 0.0;
    while (along + left < whole) {
      along += left;
      const Point at = from + step * (along / whole);
      if (part % 2 == 0) {
        current.push_back(at);
        ink.push_back(std::move(current));
      }
      current = {at};
      part = (part + 1) % stroke.dash.size();
      left = stroke.dash[part];
    }
    left = std::max(0.0, left - (whole - along));
    current.push_back(stroke.points[i]);
  }
  if (part % 2 == 0 && current.size() > 1) ink.push_back(std::move(current));
  return ink;
}

std::vector<std::vector<Point>> clip(const std::vector<Point>& points, const Point& low, const Point& high) {
  std::vector<std::vector<Point>> parts;
  bool joined = false;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto span = inside_span(points[i - 1], points[i], low, high);
    if (!span) {
      joined = false;
      continue;
    }
    const Point step = points[i] - points[i - 1];
    if (!joined || span->first > 0.0) parts.push_back({points[i - 1] + span->first * step});
    parts.back().push_back(points[i - 1] + span->second * step);
    joined = span->second >= 1.0;
  }
  return parts;
}

bool is_within(const Point& at, const Point& low, const Point& high) {
  return (at.array() >= low.array()).all() && (at.array() <= high.array()).all();
}

void add_rimmed(Drawing& drawing, const std::vector<Point>& points, const Point& low, const Point& high,
                const std::vector<Pen>& pens, const Dash& dash) {
  for (const auto& part : clip(points, low, high)) {
    for (const Pen& pen : pens) drawing.items.push_back(Stroke{part, pen.colour, pen.width_pt, dash});
  }
}

void add_rectangle(Drawing& drawing, const Point& top_left, const Point& bottom_right, Colour colour) {
  drawing.items.push_back(Fill{
      {top_left, {bottom_right.x(), top_left.y()}, bottom_right, {top_left.x(), bottom_right.y()}}, colour});
}

void add_frame(Drawing& drawing, const Point& top_left, const Point& bottom_right, Colour colour,
               double width_pt) {
  // Past the first corner again, so that the joint there is closed.
  const Point top_right(bottom_right.x(), top_left.y()), bottom_left(top_left.x(), bottom_right.y());
  const Point past = top_left + (top_right - top_left) * 0.01;
  drawing.items.push_back(
      Stroke{{top_left, top_right, bottom_right, bottom_left, top_left, past}, colour, width_pt, {}});
}

void add_marker(Drawing& drawing, Marker marker, const Point& at, double size_pt, Colour colour) {
  const double half = 0.5 * size_pt;
  const double pen_pt = 0.24 * size_pt;
  const auto stroke = [&](std::vector<Point> points) {
    drawing.items.push_back(Stroke{std::move(points), colour, pen_pt, {}});
  };
  const auto fill = [&](std::vector<Point> corners) {
    drawing.items.push_back(Fill{std::move(corners), colour});
  };
  constexpr double kUp = -std::numbers::pi / 2;
  switch (marker) {
    case Marker::none:
      break;
    case Marker::circle:
      fill(regular_polygon(at, half, 24, 0.0));
      break;
    // Radii that give squares, diamonds and triangles about the area of the circle.
    case Marker::square:
      fill(regular_polygon(at, 1.25 * half, 4, std::numbers::pi / 4));
      break;
    case Marker::diamond:
      fill(regular_polygon(at, 1.25 * half, 4, 0.0));
      break;
    case Marker::triangle:
      fill(regular_polygon(at, 1.4 * half, 3, kUp));
      break;
    case Marker::plus:
      stroke({at - Point(half, 0), at + Point(half, 0)});
      stroke({at - Point(0, half), at + Point(0, half)});
      break;
    case Marker::cross:
      stroke({at + Point(-half, -half), at + Point(half, half)});
      stroke({at + Point(-half, half), at + Point(half, -half)});
      break;
    case Marker::ring: {
      // A closed band rather than a bent line: no joints to be seen.
      Band band{regular_polygon(at, half + 0.5 * pen_pt, 32, 0.0),
                regular_polygon(at, half - 0.5 * pen_pt, 32, 0.0), colour};
      band.upper.push_back(band.upper.front());
      band.lower.push_back(band.lower.front());
      drawing.items.push_back(std::move(band));
      break;
    }
  }
}

void add_label(Drawing& drawing, const Point& anchor, const std::string& text, double size_pt, Colour colour,
               Colour background) {
  const Point half(0.5 * text_width_pt(text, size_pt) + 0.3 * size_pt, 0.65 * size_pt);
  add_rectangle(drawing, anchor - half, anchor + half, background);
  drawing.items.push_back(
      Text{anchor + Point(0, kCapHeight / 2 * size_pt), text, size_pt, colour, Align::middle});
}

Colour viridis(double t) {
  // The published table at 0, 0.1, ... 1.
  static constexpr std::array<Colour, 11> kStops{{{68, 1, 84},
                                                  {72, 36, 117},
                                                  {65, 68, 135},
                                                  {53, 95, 141},
                                                  {42, 120, 142},
                                                  {33, 145, 140},
                                                  {34, 168, 132},
                                                  {68, 191, 112},
                                                  {122, 209, 81},
                                                  {189, 223, 38},
                                                  {253, 231, 37}}};
  const double place = (std::isfinite(t) ? std::clamp(t, 0.0, 1.0) : 0.0) * (kStops.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kStops.size() - 2);
  const double part = place - static_cast<double>(low);
  const auto mix = [part](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround((1.0 - part) * a + part * b));
  };
  const Colour a = kStops[low], b = kStops[low + 1];
  return {mix(a.r, b.r), mix(a.g, b.g), mix(a.b, b.b), 255};
}

}  // namespace furrow::figures
