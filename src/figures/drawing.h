#pragma once
#include <array>
#include <cstdint>
#include <Eigen/Core>
#include <string>
#include <variant>
#include <vector>

#include "furrow/image/image.h"

namespace furrow::figures {

struct Colour {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;

  bool operator==(const Colour&) const = default;
};

/// Okabe and Ito's colours (jfly.uni-koeln.de/color, 2008), told apart by every common kind of colour vision.
inline constexpr Colour kBlack{0x00, 0x00, 0x00};
inline constexpr Colour kOrange{0xE6, 0x9F, 0x00};
inline constexpr Colour kSkyBlue{0x56, 0xB4, 0xE9};
inline constexpr Colour kGreen{0x00, 0x9E, 0x73};
inline constexpr Colour kBlue{0x00, 0x72, 0xB2};
inline constexpr Colour kVermillion{0xD5, 0x5E, 0x00};
inline constexpr Colour kPurple{0xCC, 0x79, 0xA7};
inline constexpr Colour kWhite{0xFF, 0xFF, 0xFF};
inline constexpr Colour kInk{0x20, 0x20, 0x20};       ///< text and axes
inline constexpr Colour kGridGrey{0xDC, 0xDC, 0xDC};  ///< grid lines, well below the data
inline constexpr Colour kMidGrey{0x6E, 0x6E, 0x6E};   ///< secondary text; 5:1 on white

inline constexpr Colour with_alpha(Colour colour, std::uint8_t alpha) {
  return {colour.r, colour.g, colour.b, alpha};
}

/// x to the right, y down, in points (1/72 inch) from the top-left corner of the paper.
using Point = Eigen::Vector2d;

/// Lengths of ink and gap in points; empty for a solid line.
using Dash = std::vector<double>;

struct Stroke {
  std::vector<Point> points;
  Colour colour = kInk;
  double width_pt = 1.0;
  Dash dash = {};
};

/// A convex polygon.
struct Fill {
  std::vector<Point> corners;
  Colour colour = kInk;
};

/// The area between two lines that have the same number of points.
struct Band {
  std::vector<Point> upper, lower;
  Colour colour = kInk;
};

enum class Align { start, middle, end };

/// One line of UTF-8 text in DejaVu Sans.
struct Text {
  Point anchor = Point::Zero();  ///< on the base line, at the start, middle or end of the text
  std::string text;
  double size_pt = 8.0;
  Colour colour = kInk;
  Align align = Align::start;
  bool bold = false;
  bool upward = false;  ///< turned to read from bottom to top
};

/// A photograph; always lies under all other items.
struct Picture {
  Image image;
  Point top_left = Point::Zero();
  double width_pt = 0.0, height_pt = 0.0;
  bool lossless = false;  ///< PNG in the SVG instead of JPEG: for masks and line work
};

/// Paper with ink on it: all that a figure is before it becomes PNG or SVG.
struct Drawing {
  double width_pt = 0.0, height_pt = 0.0;
  std::vector<std::variant<Stroke, Fill, Band, Text>> items;
  std::vector<Picture> pictures;
};

/// The ink of a dashed line, one polyline per dash. A solid stroke gives its own points, and so does one
/// whose dashes cannot be told: of no or of negative length, or on a line that is no number long or has more
/// of them than any paper shows.
std::vector<std::vector<Point>> dashes(const Stroke& stroke);

/// The part of a polyline inside [low, high], cut at the border (Liang and Barsky 1984).
std::vector<std::vector<Point>> clip(const std::vector<Point>& points, const Point& low, const Point& high);

/// Whether the point lies inside [low, high], the border included.
bool is_within(const Point& at, const Point& low, const Point& high);

struct Pen {
  Colour colour = kInk;
  double width_pt = 1.0;
};

/// The part of a line inside [low, high], drawn with each pen in turn: rims, which come first, are wider.
void add_rimmed(Drawing& drawing, const std::vector<Point>& points, const Point& low, const Point& high,
                const std::vector<Pen>& pens, const Dash& dash = {});

enum class Marker { none, circle, square, diamond, triangle, plus, cross, ring };

/// A marker of about `size_pt` across, same visual weight for all shapes.
void add_marker(Drawing& drawing, Marker marker, const Point& at, double size_pt, Colour colour);
void add_rectangle(Drawing& drawing, const Point& top_left, const Point& bottom_right, Colour colour);
void add_frame(Drawing& drawing, const Point& top_left, const Point& bottom_right, Colour colour,
               double width_pt);
/// Text on a box with that background; `anchor` is the middle of the box.
void add_label(Drawing& drawing, const Point& anchor, const std::string& text, double size_pt, Colour colour,
               Colour background);

/// The viridis colour map (van der Walt and Smith 2015) at t in [0, 1], linear between 11 stops.
Colour viridis(double t);

}  // namespace furrow::figures
