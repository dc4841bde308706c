#pragma once
#include <limits>
#include <string>
#include <vector>

#include "figures/drawing.h"

namespace furrow::figures {

inline constexpr double kPointsPerMm = 72.0 / 25.4;

/// Type sizes on paper: readable at the print width the figure is made for.
inline constexpr double kAxisTextPt = 8.5;
inline constexpr double kTickTextPt = 7.5;
inline constexpr double kLegendTextPt = 8.0;
/// Space at the paper's edge.
inline constexpr double kMarginPt = 4.0;

/// Round numbers that span [low, high], with the decimals they need.
struct Ticks {
  std::vector<double> values;
  int decimals = 0;
};

/// Multiples of 1, 2 or 5 times a power of ten inside [low, high], about `wanted` of them.
Ticks nice_ticks(double low, double high, int wanted);

/// Tick text: fixed decimals, a true minus sign.
std::string tick_text(double value, int decimals);

struct Axis {
  std::string text;  ///< quantity, reference, unit: "height above ground / m"
  double low = 0.0, high = 1.0;
  Ticks ticks;
};

/// An axis over finite values, with a little air and round ends. `include_zero` for bars.
Axis axis_over(const std::string& text, const std::vector<double>& values, int wanted_ticks,
               bool include_zero = false);
/// An axis that ends where told, no tick beyond.
Axis axis_between(const std::string& text, double low, double high, int wanted_ticks);
/// An axis over 1 .. count with whole-numbered ticks.
Axis counting_axis(const std::string& text, std::size_t count, double width_pt);

/// The same axis with its low end at the top, for picture rows.
Axis flipped(Axis axis);

/// Values over places on the x axis. NaN makes a gap.
struct Series {
  std::string name;
  std::vector<double> x, y;
  std::vector<double> sigma;  ///< band of one sigma; empty for none
  Colour colour = kInk;
  double line_pt = 1.1;  ///< 0 for markers only
  Dash dash = {};
  Marker marker = Marker::none;
  double marker_pt = 3.4;
};

/// Rectangle of the plotting area and its axes.
struct Frame {
  Point top_left = Point::Zero(), bottom_right = Point::Zero();
  Axis x, y;

  Point map(double at_x, double at_y) const {
    return {top_left.x() + (at_x - x.low) / (x.high - x.low) * (bottom_right.x() - top_left.x()),
            bottom_right.y() - (at_y - y.low) / (y.high - y.low) * (bottom_right.y() - top_left.y())};
  }
  bool holds(double value_y) const { return value_y >= y.low && value_y <= y.high; }
};

/// Lines behind the data at the ticks; over a photograph there are none.
enum class Grid { none, across, both };

/// Draws axes, grid, ticks and their text inside the rectangle `outer`; the frame is what is left for the
/// data.
Frame draw_axes(Drawing& drawing, const Point& outer_top_left, const Point& outer_bottom_right, const Axis& x,
                const Axis& y, Grid grid = Grid::across);

/// Draws bands first, then lines, then markers. Values beyond the y axis become arrows at its end;
/// returns how many.
int draw_series(Drawing& drawing, const Frame& frame, const std::vector<Series>& series);

/// What stands in a legend beside its text.
struct LegendEntry {
  std::string name;
  Colour colour = kInk;
  double line_pt = 0.0;
  Dash dash = {};
  Marker marker = Marker::none;
  double marker_pt = 3.4;
  bool band = false;
  bool bar = false;
};
LegendEntry legend_of(const Series& series);

/// The legend stands above the plot, so it can never cover data. Returns the height it takes.
double draw_legend(Drawing& drawing, const Point& top_left, double width_pt,
                   const std::vector<LegendEntry>& entries);

/// A line across the frame at one value.
void draw_level(Drawing& drawing, const Frame& frame, double value_y, Colour colour, const Dash& dash,
                double width_pt);

/// Words in the middle of a frame that has no data: an empty plot must say that it is meant.
void draw_note(Drawing& drawing, const Frame& frame, const std::string& text);

/// Level viridis scale with ticks and text under it; returns the height of all.
double draw_colour_bar(Drawing& drawing, const Point& top_left, double width_pt, const Axis& axis);

}  // namespace furrow::figures
