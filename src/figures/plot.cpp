#include "figures/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "figures/font.h"
#include "furrow/base/text.h"

namespace furrow::figures {
namespace {

constexpr double kTickLengthPt = 3.0;
constexpr double kAxisPenPt = 0.6;
constexpr double kGridPenPt = 0.4;
constexpr double kTextGapPt = 3.0;
constexpr double kLegendKeyPt = 20.0;

bool finite(double value) {
  return std::isfinite(value);
}

double widest_tick_pt(const Ticks& ticks) {
  double widest = 0.0;
  for (const double value : ticks.values) {
    widest = std::max(widest, text_width_pt(tick_text(value, ticks.decimals), kTickTextPt));
  }
  return widest;
}

/// Room for ticks, numbers and text under an x axis.
double below_axis_pt() {
  return kTickLengthPt + 2 * kTextGapPt + kTickTextPt + (1.0 + kDescent) * kAxisTextPt;
}

void draw_x_axis(Drawing& drawing, const Frame& frame, bool grid) {
  const double bottom = frame.bottom_right.y();
  for (const double value : frame.x.ticks.values) {
    const double x = frame.map(value, frame.y.low).x();
    if (grid) {
      drawing.items.push_back(Stroke{{{x, frame.top_left.y()}, {x, bottom}}, kGridGrey, kGridPenPt, {}});
    }
    drawing.items.push_back(Stroke{{{x, bottom}, {x, bottom + kTickLengthPt}}, kInk, kAxisPenPt, {}});
    drawing.items.push_back(Text{{x, bottom + kTickLengthPt + kTextGapPt + kCapHeight * kTickTextPt},
                                 tick_text(value, frame.x.ticks.decimals),
                                 kTickTextPt,
                                 kInk,
                                 Align::middle});
  }
  const Point middle(0.5 * (frame.top_left.x() + frame.bottom_right.x()),
                     bottom + kTickLengthPt + 2 * kTextGapPt + kTickTextPt + kCapHeight * kAxisTextPt);
  drawing.items.push_back(Text{middle, frame.x.text, kAxisTextPt, kInk, Align::middle});
}

void draw_y_axis(Drawing& drawing, const Frame& frame, double outer_left, bool grid) {
  const double left = frame.top_left.x();
  for (const double value : frame.y.ticks.values) {
    const double y = frame.map(frame.x.low, value).y();
    if (grid)
      drawing.items.push_back(Stroke{{{left, y}, {frame.bottom_right.x(), y}}, kGridGrey, kGridPenPt, {}});
    drawing.items.push_back(Stroke{{{left - kTickLengthPt, y}, {left, y}}, kInk, kAxisPenPt, {}});
    drawing.items.push_back(Text{{left - kTickLengthPt - kTextGapPt, y + kCapHeight / 2 * kTickTextPt},
                                 tick_text(value, frame.y.ticks.decimals),
                                 kTickTextPt,
                                 kInk,
                                 Align::end});
  }
  const Point at(outer_left + kCapHeight * kAxisTextPt, 0.5 * (frame.top_left.y() + frame.bottom_right.y()));
  drawing.items.push_back(Text{at, frame.y.text, kAxisTextPt, kInk, Align::middle, false, true});
}

/// Runs of neighbouring finite values, as [first, last] index pairs.
std::vector<std::pair<std::size_t, std::size_t>> runs(const Series& series) {
  std::vector<std::pair<std::size_t, std::size_t>> found;
  bool open = false;
  for (std::size_t i = 0; i < series.y.size(); ++i) {
    const bool here = finite(series.x[i]) && finite(series.y[i]);
    if (here && open) found.back().second = i;
    if (here && !open) found.push_back({i, i});
    open = here;
  }
  return found;
}

double sigma_at(const Series& series, std::size_t i) {
  return i < series.sigma.size() && finite(series.sigma[i]) ? series.sigma[i] : 0.0;
}

void draw_band(Drawing& drawing, const Frame& frame, const Series& series) {
  constexpr std::uint8_t kBandAlpha = 64;
  const auto limited = [&](std::size_t i, double sign) {
    const double value = series.y[i] + sign * sigma_at(series, i);
    return frame.map(series.x[i], std::clamp(value, frame.y.low, frame.y.high));
  };
  for (const auto& [first, last] : runs(series)) {
    if (first == last) {  // a lone value has no area: a bar shows its sigma
      if (sigma_at(series, first) > 0.0) {
        drawing.items.push_back(Stroke{{limited(first, -1.0), limited(first, 1.0)}, series.colour, 0.8, {}});
      }
      continue;
    }
    Band band{{}, {}, with_alpha(series.colour, kBandAlpha)};
    for (std::size_t i = first; i <= last; ++i) {
      band.upper.push_back(limited(i, 1.0));
      band.lower.push_back(limited(i, -1.0));
    }
    drawing.items.push_back(std::move(band));
  }
}

/// Room on the paper for each value of a series.
double spacing_pt(const Frame& frame, const Series& series) {
  return (frame.bottom_right.x() - frame.top_left.x()) /
         static_cast<double>(std::max<std::size_t>(series.x.size(), 1));
}

void draw_line(Drawing& drawing, const Frame& frame, const Series& series) {
  if (!(series.line_pt > 0.0)) return;
  // Where values stand closer than a dash is long, a thinner solid line says more.
  constexpr double kDensePt = 1.5;
  const bool dense = spacing_pt(frame, series) < kDensePt;
  const double width_pt = dense ? 0.5 * series.line_pt : series.line_pt;
  for (const auto& [first, last] : runs(series)) {
    std::vector<Point> points;
    for (std::size_t i = first; i <= last; ++i) points.push_back(frame.map(series.x[i], series.y[i]));
    for (auto& part : clip(points, frame.top_left, frame.bottom_right)) {
      drawing.items.push_back(Stroke{std::move(part), series.colour, width_pt, dense ? Dash{} : series.dash});
    }
  }
}

/// An arrow at the end of the axis for a value beyond it.
void draw_beyond(Drawing& drawing, const Frame& frame, double x, bool above, Colour colour) {
  constexpr double kLengthPt = 8.0, kHeadPt = 2.6, kPenPt = 1.1;
  const double inwards = above ? 1.0 : -1.0;
  const Point tip = frame.map(x, above ? frame.y.high : frame.y.low) + Point(0, inwards);
  const Point wing(kHeadPt, inwards * kHeadPt * 1.2), other_wing(-wing.x(), wing.y());
  drawing.items.push_back(Stroke{{tip, tip + Point(0, inwards * kLengthPt)}, colour, kPenPt});
  drawing.items.push_back(Stroke{{tip + wing, tip, tip + other_wing}, colour, kPenPt});
}

int draw_markers(Drawing& drawing, const Frame& frame, const Series& series) {
  // On a line every k-th value gets a marker, so that they stay apart; loose values all get one, smaller
  // where they crowd.
  constexpr double kApartPt = 7.0, kSmallestPt = 1.2, kArrowApartPt = 5.0;
  const double room_pt = spacing_pt(frame, series);
  const bool on_line = series.line_pt > 0.0;
  const auto step =
      on_line ? static_cast<std::size_t>(std::ceil(kApartPt / std::max(room_pt, 1e-3))) : std::size_t{1};
  const double size_pt =
      on_line ? series.marker_pt : std::clamp(2.0 * room_pt, kSmallestPt, series.marker_pt);
  int beyond = 0;
  double last_arrow_x = -std::numeric_limits<double>::infinity();
  for (const auto& [first, last] : runs(series)) {
    for (std::size_t i = first; i <= last; ++i) {
      const Point at = frame.map(series.x[i], series.y[i]);
      if (!frame.holds(series.y[i])) {
        ++beyond;
        if (std::abs(at.x() - last_arrow_x) < kArrowApartPt) continue;
        draw_beyond(drawing, frame, series.x[i], series.y[i] > frame.y.high, series.colour);
        last_arrow_x = at.x();
      } else if (i % step == 0 || first == last) {
        const Marker marker = series.marker == Marker::none && first == last ? Marker::circle : series.marker;
        add_marker(drawing, marker, at, size_pt, series.colour);
      }
    }
  }
  return beyond;
}

void draw_key(Drawing& drawing, const LegendEntry& entry, const Point& left_middle) {
  const Point right = left_middle + Point(kLegendKeyPt, 0), middle = 0.5 * (left_middle + right);
  if (entry.band) {
    add_rectangle(drawing, left_middle - Point(0, 3.5), right + Point(0, 3.5), with_alpha(entry.colour, 64));
  }
  if (entry.bar) {
    add_rectangle(drawing, middle - Point(5.0, 3.5), middle + Point(5.0, 3.5), entry.colour);
  }
  if (entry.line_pt > 0.0) {
    drawing.items.push_back(Stroke{{left_middle, right}, entry.colour, entry.line_pt, entry.dash});
  }
  add_marker(drawing, entry.marker, middle, entry.marker_pt, entry.colour);
}

}  // namespace

Ticks nice_ticks(double low, double high, int wanted) {
  // Among numbers so large that steps of their span are lost in rounding, no tick is next to another.
  constexpr double kLeastShare = 1e-12;
  const double span = high - low;
  if (!finite(span) || !(span > kLeastShare * std::max(std::abs(low), std::abs(high)))) return {{low}, 0};
  const double rough = span / std::max(wanted, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double part = rough / power;
  // Borders half-way (geometrically) between the steps.
  const double step = power * (part < std::sqrt(2.0)    ? 1.0
                               : part < std::sqrt(10.0) ? 2.0
                               : part < std::sqrt(50.0) ? 5.0
                                                        : 10.0);
  Ticks ticks;
  ticks.decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  // Whole multiples of the step, so that no rounding adds up; the slack keeps ticks at the very ends.
  const double slack = 1e-9;
  const auto first = static_cast<std::int64_t>(std::ceil(low / step - slack));
  const auto last = static_cast<std::int64_t>(std::floor(high / step + slack));
  for (std::int64_t i = first; i <= last; ++i) ticks.values.push_back(static_cast<double>(i) * step);
  // One tick shows no scale: a span that holds only one multiple needs the next finer step.
  if (ticks.values.size() < 2) return nice_ticks(low, high, 2 * std::max(wanted, 1));
  return ticks;
}

std::string tick_text(double value, int decimals) {
  std::string text = base::format_fixed(value, decimals);
  if (!text.empty() && text[0] == '-') text.replace(0, 1, "\u2212");
  return text;
}

Axis axis_over(const std::string& text, const std::vector<double>& values, int wanted_ticks,
               bool include_zero) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  // No quantity of a flight comes near; a stray 1e300 must not overflow the arithmetic of the axis.
  constexpr double kAbsurd = 1e12;
  for (const double value : values) {
    if (!(std::abs(value) < kAbsurd)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low > high) low = 0.0, high = 1.0;
  if (include_zero) low = std::min(low, 0.0), high = std::max(high, 0.0);
  // A span too small for its own numbers would give ticks that read the same.
  const double least = std::max(1e-6, 1e-6 * std::max(std::abs(low), std::abs(high)));
  if (high - low < least) low -= 0.5 * std::max(least, 0.1), high += 0.5 * std::max(least, 0.1);
  constexpr double kAir = 0.05;
  const double air = kAir * (high - low);
  Axis axis{text, low - air, high + air, {}};
  if (include_zero && low == 0.0) axis.low = 0.0;
  if (include_zero && high == 0.0) axis.high = 0.0;
  axis.ticks = nice_ticks(axis.low, axis.high, wanted_ticks);
  return axis;
}

Axis axis_between(const std::string& text, double low, double high, int wanted_ticks) {
  return {text, low, high, nice_ticks(low, high, wanted_ticks)};
}

Axis counting_axis(const std::string& text, std::size_t count, double width_pt) {
  const double last = static_cast<double>(std::max<std::size_t>(count, 1));
  constexpr double kPtPerTick = 32.0;
  Axis axis{text, 0.5, last + 0.5, {}};
  const int wanted = static_cast<int>(std::min(last, width_pt / kPtPerTick));
  Ticks ticks = nice_ticks(1.0, last + 1e-6, std::max(wanted, 1));
  ticks.decimals = 0;
  std::erase_if(ticks.values, [](double v) { return v != std::round(v); });
  // The first shot gets its number where the next tick leaves room for it.
  const bool room_for_one = ticks.values.empty() || ticks.values.front() > 2.5;
  if (room_for_one) ticks.values.insert(ticks.values.begin(), 1.0);
  axis.ticks = std::move(ticks);
  return axis;
}

Axis flipped(Axis axis) {
  std::swap(axis.low, axis.high);
  return axis;
}

Frame draw_axes(Drawing& drawing, const Point& outer_top_left, const Point& outer_bottom_right, const Axis& x,
                const Axis& y, Grid grid) {
  Frame frame{outer_top_left, outer_bottom_right, x, y};
  frame.top_left.x() += kAxisTextPt + 2 * kTextGapPt + widest_tick_pt(y.ticks) + kTickLengthPt;
  frame.top_left.y() += 0.5 * kTickTextPt;
  // Half of the last number on the x axis stands beyond the frame.
  const double last_tick_pt =
      x.ticks.values.empty() ? 0.0
                             : text_width_pt(tick_text(x.ticks.values.back(), x.ticks.decimals), kTickTextPt);
  const double over = x.ticks.values.empty() ? 0.0 : (x.high - x.ticks.values.back()) / (x.high - x.low);
  frame.bottom_right.x() -=
      std::max(1.0, 0.5 * last_tick_pt - over * (frame.bottom_right.x() - frame.top_left.x()));
  frame.bottom_right.y() -= below_axis_pt();
  draw_x_axis(drawing, frame, grid == Grid::both);
  draw_y_axis(drawing, frame, outer_top_left.x(), grid != Grid::none);
  add_frame(drawing, frame.top_left, frame.bottom_right, kInk, kAxisPenPt);
  return frame;
}

int draw_series(Drawing& drawing, const Frame& frame, const std::vector<Series>& series) {
  for (const Series& one : series) {
    check(one.x.size() == one.y.size(), "a series has as many x as y");
    if (!one.sigma.empty()) draw_band(drawing, frame, one);
  }
  for (const Series& one : series) draw_line(drawing, frame, one);
  int beyond = 0;
  for (const Series& one : series) beyond += draw_markers(drawing, frame, one);
  return beyond;
}

LegendEntry legend_of(const Series& series) {
  return {series.name,   series.colour,    series.line_pt,       series.dash,
          series.marker, series.marker_pt, !series.sigma.empty()};
}

double draw_legend(Drawing& drawing, const Point& top_left, double width_pt,
                   const std::vector<LegendEntry>& entries) {
  constexpr double kLinePt = 1.45 * kLegendTextPt, kGapPt = 9.0, kKeyGapPt = 4.0;
  if (entries.empty()) return 0.0;
  Point at = top_left;
  for (const LegendEntry& entry : entries) {
    const double width = kLegendKeyPt + kKeyGapPt + text_width_pt(entry.name, kLegendTextPt);
    if (at.x() > top_left.x() && at.x() + width > top_left.x() + width_pt) {
      at = Point(top_left.x(), at.y() + kLinePt);
    }
    const double base_line = at.y() + 0.5 * kLinePt + kCapHeight / 2 * kLegendTextPt;
    draw_key(drawing, entry, at + Point(0, 0.5 * kLinePt));
    drawing.items.push_back(
        Text{{at.x() + kLegendKeyPt + kKeyGapPt, base_line}, entry.name, kLegendTextPt, kInk});
    at.x() += width + kGapPt;
  }
  return at.y() - top_left.y() + kLinePt + 3.0;
}

void draw_level(Drawing& drawing, const Frame& frame, double value_y, Colour colour, const Dash& dash,
                double width_pt) {
  if (!frame.holds(value_y)) return;
  drawing.items.push_back(
      Stroke{{frame.map(frame.x.low, value_y), frame.map(frame.x.high, value_y)}, colour, width_pt, dash});
}

void draw_note(Drawing& drawing, const Frame& frame, const std::string& text) {
  drawing.items.push_back(
      Text{0.5 * (frame.top_left + frame.bottom_right), text, kAxisTextPt, kMidGrey, Align::middle});
}

double draw_colour_bar(Drawing& drawing, const Point& top_left, double width_pt, const Axis& axis) {
  constexpr int kSteps = 64;
  constexpr double kBarPt = 7.0;
  const Frame frame{top_left, top_left + Point(width_pt, kBarPt), axis, {"", 0.0, 1.0, {}}};
  // From the right, each back to the left end: rectangles that only touch would leave hairlines between them.
  for (int i = kSteps; i > 0; --i) {
    const double right = top_left.x() + width_pt * i / kSteps;
    add_rectangle(drawing, top_left, {right, frame.bottom_right.y()}, viridis((i - 0.5) / kSteps));
  }
  add_frame(drawing, frame.top_left, frame.bottom_right, kInk, kAxisPenPt);
  draw_x_axis(drawing, frame, false);
  return kBarPt + below_axis_pt();
}

}  // namespace furrow::figures
