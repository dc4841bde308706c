// The parts figures are made of: no OpenGL needed but for the last test.
#include "figures/drawing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "figures/canvas.h"
#include "figures/font.h"
#include "figures/plot.h"
#include "figures/utf8.h"
#include "furrow/base/random.h"

namespace furrow::figures {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class T>
std::vector<T> all(const Drawing& drawing) {
  std::vector<T> found;
  for (const auto& item : drawing.items) {
    if (const T* one = std::get_if<T>(&item)) found.push_back(*one);
  }
  return found;
}

TEST(Ticks, AreRoundInsideAndAsManyAsWanted) {
  base::Random random(5);
  for (int trial = 0; trial < 2000; ++trial) {
    const double low = random.normal(0.0, std::pow(10.0, random.uniform(-4.0, 6.0)));
    const double high = low + std::pow(10.0, random.uniform(-4.0, 6.0));
    const int wanted = 3 + static_cast<int>(random.below(8));
    const Ticks ticks = nice_ticks(low, high, wanted);
    const double slack = 1e-6 * (high - low);
    ASSERT_GE(ticks.values.size(), 2u) << low << " " << high << " " << wanted;
    // Steps of 1, 2, 5 are at most a factor sqrt(2.5) from the wanted one.
    ASSERT_LE(ticks.values.size(), static_cast<std::size_t>(std::max(1.6 * wanted, 6.0)) + 2);
    ASSERT_GE(ticks.values.front(), low - slack);
    ASSERT_LE(ticks.values.back(), high + slack);
    const double step = ticks.values[1] - ticks.values[0];
    const double lead = step / std::pow(10.0, std::floor(std::log10(step) + 1e-6));
    ASSERT_TRUE(std::abs(lead - 1) < 1e-3 || std::abs(lead - 2) < 1e-3 || std::abs(lead - 5) < 1e-3) << step;
    for (std::size_t i = 1; i < ticks.values.size(); ++i) {
      ASSERT_NE(tick_text(ticks.values[i - 1], ticks.decimals), tick_text(ticks.values[i], ticks.decimals));
    }
  }
  EXPECT_EQ(nice_ticks(0.0, 1.0, 5).values.size(), 6u);
  EXPECT_EQ(nice_ticks(3.0, 3.0, 5).values.size(), 1u);
  EXPECT_EQ(nice_ticks(kNaN, 3.0, 5).values.size(), 1u);
}

// Counting by steps that rounding swallows never ended; a span beyond all numbers has none.
TEST(Ticks, EndOverNumbersThatNothingHas) {
  EXPECT_EQ(nice_ticks(1e17, 1e17 + 16.0, 5).values.size(), 1u);
  EXPECT_EQ(nice_ticks(-1e308, 1e308, 5).values.size(), 1u);
  EXPECT_EQ(nice_ticks(-1e17, 1e17, 4).values.size(), 5u);
  EXPECT_GE(nice_ticks(1e9, 1e9 + 0.01, 5).values.size(), 2u);
}

TEST(Ticks, ShotAxisHasWholeNumbers) {
  for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 48u, 3000u}) {
    for (const double value : counting_axis("shot number", count, 400.0).ticks.values) {
      EXPECT_EQ(value, std::round(value));
      EXPECT_GE(value, 1.0);
      EXPECT_LE(value, static_cast<double>(std::max<std::size_t>(count, 1)));
    }
  }
}

TEST(Axis, HoldsItsValuesAndNeverCollapses) {
  const Axis axis = axis_over("h / m", {2.0, kNaN, 4.0, 1e300}, 5);
  EXPECT_LT(axis.low, 2.0);
  EXPECT_GT(axis.high, 4.0);
  EXPECT_LT(axis.high, 5.0);
  for (const auto& values : {std::vector<double>{}, {kNaN}, {3.0}, {3.0, 3.0}, {1e9, 1e9}, {0.0}}) {
    const Axis flat = axis_over("h / m", values, 5);
    EXPECT_LT(flat.low, flat.high);
    EXPECT_FALSE(flat.ticks.values.empty());
  }
  EXPECT_EQ(axis_over("e / px", {0.3}, 5, true).low, 0.0);
}

TEST(Axis, BetweenTwoEndsHasNoTickBeyondThem) {
  const Axis axis = axis_between("ahead / m", 1.66, 15.7, 6);
  EXPECT_EQ(axis.low, 1.66);
  EXPECT_EQ(axis.high, 15.7);
  ASSERT_GE(axis.ticks.values.size(), 2U);
  EXPECT_GE(axis.ticks.values.front(), 1.66);
  EXPECT_LE(axis.ticks.values.back(), 15.7);
}

TEST(Text, MinusIsAMinus) {
  EXPECT_EQ(tick_text(-1.5, 1), "\u22121.5");
  EXPECT_EQ(tick_text(-0.0001, 1), "0.0");
}

TEST(Text, WidthFollowsTheFont) {
  // DejaVu Sans: advance of a digit 1303/2048 em, of a sigma 1298/2048 em (its hmtx table).
  EXPECT_NEAR(text_width_pt("0", 2048.0), 1303.0, 0.5);
  EXPECT_NEAR(text_width_pt("\u03c3", 2048.0), 1298.0, 0.5);
  EXPECT_NEAR(text_width_pt("\u03c30", 10.0), text_width_pt("0\u03c3", 10.0), 1e-9);
  EXPECT_GT(text_width_pt("height", 10.0, true), text_width_pt("height", 10.0, false));
  EXPECT_EQ(text_width_pt("", 10.0), 0.0);
}

TEST(Utf8, KeepsTextAndReplacesWhatIsNone) {
  EXPECT_EQ(printable("\u03c3 \u00b1 \u22121 \U0001F33E"), "\u03c3 \u00b1 \u22121 \U0001F33E");
  EXPECT_EQ(printable("a\tb\nc"), "a b c");
  EXPECT_EQ(printable("\xff"), "\ufffd");
  EXPECT_EQ(printable("\xc3"), "\ufffd");                       // cut short
  EXPECT_EQ(printable("\xc0\xaf"), "\ufffd\ufffd");             // overlong
  EXPECT_EQ(printable("\xed\xa0\x80").substr(0, 3), "\ufffd");  // surrogate
  EXPECT_EQ(printable(std::string("\0x", 2)), " x");
  base::Random random(9);
  for (int trial = 0; trial < 500; ++trial) {
    std::string bytes;
    for (int i = 0; i < 20; ++i) bytes += static_cast<char>(static_cast<unsigned char>(random.below(256)));
    const std::string once = printable(bytes);
    ASSERT_EQ(printable(once), once);
  }
}

TEST(Dashes, InkAndGapsHaveTheirLengths) {
  const Stroke stroke{{{0, 0}, {7.5, 0}, {7.5, 5}}, kInk, 1.0, {3.0, 1.0}};  // 12.5 pt around a corner
  const auto ink = dashes(stroke);
  ASSERT_EQ(ink.size(), 4u);
  double total = 0.0;
  for (const auto& line : ink) {
    for (std::size_t i = 1; i < line.size(); ++i) total += (line[i] - line[i - 1]).norm();
  }
  EXPECT_NEAR(total, 9.5, 1e-12);
  EXPECT_EQ(ink[1].size(), 2u);
  EXPECT_NEAR(ink[1].front().x(), 4.0, 1e-12);
  EXPECT_NEAR(ink[2].front().y(), 0.5, 1e-12);
  EXPECT_EQ(dashes({{{0, 0}, {1, 0}}, kInk, 1.0, {}}).size(), 1u);
  EXPECT_EQ(dashes({{{0, 0}, {1, 0}}, kInk, 1.0, {0.0, 0.0}}).size(), 1u)
      << "a pattern of no length must not hang";
}

TEST(Dashes, LinesWithoutEndAreNotDashed) {
  const double infinite = std::numeric_limits<double>::infinity();
  const Dash dash{4.0, 2.0};
  EXPECT_EQ(dashes({{{0, 0}, {infinite, 0}}, kInk, 1.0, dash}).size(), 1u);
  EXPECT_EQ(dashes({{{0, 0}, {std::nan(""), 0}}, kInk, 1.0, dash}).size(), 1u);
  EXPECT_EQ(dashes({{{0, 0}, {1e15, 0}}, kInk, 1.0, dash}).size(), 1u);
  EXPECT_EQ(dashes({{{1e17, 0}, {2e17, 0}}, kInk, 1.0, dash}).size(), 1u)
      << "a dash there is shorter than the distance between two numbers";
  EXPECT_EQ(dashes({{{0, 0}, {10, 0}}, kInk, 1.0, {1e-300, 1e-300}}).size(), 1u);
  EXPECT_EQ(dashes({{{0, 0}, {10, 0}}, kInk, 1.0, {3.0, -2.0}}).size(), 1u);
  EXPECT_EQ(dashes({{{1e17, 0}, {1e17, 6}, {1e17, 12}}, kInk, 1.0, dash}).size(), 2u);
}

TEST(Dashes, PointsThatRepeatAndGapsOfNoLengthEnd) {
  const auto ink = dashes({{{0, 0}, {3, 0}, {3, 0}, {3, 0}, {7, 0}}, kInk, 1.0, {3.0, 0.0}});
  ASSERT_EQ(ink.size(), 3u);
  for (const auto& line : ink) {
    for (const Point& at : line) EXPECT_TRUE(at.allFinite());
  }
}

TEST(Clip, CutsAtTheBorder) {
  const Point low(0, 0), high(10, 10);
  const auto parts = clip({{-5, 5}, {5, 5}, {5, 15}, {6, 15}, {6, 5}}, low, high);
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].front(), Point(0, 5));
  EXPECT_EQ(parts[0].back(), Point(5, 10));
  EXPECT_EQ(parts[1].front(), Point(6, 10));
  EXPECT_TRUE(clip({{-5, -5}, {-1, 20}}, low, high).empty());
  EXPECT_TRUE(clip({{3, 3}}, low, high).empty());
  for (const auto& part : clip({{-1e9, 3}, {1e9, 4}}, low, high)) {
    for (const Point& point : part) EXPECT_TRUE(point.x() >= -1e-6 && point.x() <= 10 + 1e-6);
  }
}

TEST(Viridis, HasThePublishedEndsAndGrowsLighter) {
  EXPECT_EQ(viridis(0.0), (Colour{68, 1, 84, 255}));
  EXPECT_EQ(viridis(1.0), (Colour{253, 231, 37, 255}));
  EXPECT_EQ(viridis(kNaN), viridis(0.0));
  double last = -1.0;
  for (int i = 0; i <= 50; ++i) {
    const Colour c = viridis(i / 50.0);
    const double luma = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    EXPECT_GT(luma, last);
    last = luma;
  }
}

Frame plain_frame() {
  return {{0, 0}, {100, 100}, axis_over("x", {0.0, 10.0}, 5), axis_over("y", {0.0, 10.0}, 5)};
}

TEST(Series, NaNMakesAGapAndALoneValueStaysVisible) {
  Drawing drawing;
  Series series;
  series.x = {1, 2, 3, 4, 5, 6};
  series.y = {1, 2, kNaN, 4, kNaN, 6};
  series.sigma = {0.5, 0.5, 0.5, 0.5, 0.5, kNaN};
  EXPECT_EQ(draw_series(drawing, plain_frame(), {series}), 0);
  std::size_t lines = 0, bars = 0;
  for (const Stroke& stroke : all<Stroke>(drawing)) (stroke.width_pt > 1.0 ? lines : bars) += 1;
  EXPECT_EQ(lines, 1u) << "1-2 is the only pair of neighbours";
  EXPECT_EQ(bars, 1u) << "the lone value with a sigma has its bar";
  EXPECT_EQ(all<Band>(drawing).size(), 1u);
  EXPECT_EQ(all<Fill>(drawing).size(), 2u) << "both lone values have a marker though the series has none";
}

TEST(Series, BeyondTheAxisIsCountedAndStaysInside) {
  Drawing drawing;
  Series series;
  series.x = {1, 2, 3};
  series.y = {5, 500, -500};
  series.sigma = {1, 1, 1};
  series.marker = Marker::circle;
  EXPECT_EQ(draw_series(drawing, plain_frame(), {series}), 2);
  for (const Stroke& stroke : all<Stroke>(drawing)) {
    for (const Point& point : stroke.points) EXPECT_TRUE(point.y() >= -1e-9 && point.y() <= 100.0 + 1e-9);
  }
}

TEST(Legend, WrapsInsideItsWidthAndStandsAboveThePlot) {
  Drawing drawing;
  std::vector<LegendEntry> entries;
  for (const char* name : {"refined from rows", "truth", "log, above take-off", "VPS, above surface below"}) {
    entries.push_back({name, kBlue, 1.0});
  }
  const double height = draw_legend(drawing, {4, 4}, 200.0, entries);
  for (const Text& text : all<Text>(drawing)) {
    EXPECT_LE(text.anchor.x() + text_width_pt(text.text, text.size_pt), 204.0);
    EXPECT_LT(text.anchor.y(), 4.0 + height);
  }
  Drawing wide;
  EXPECT_LT(draw_legend(wide, {4, 4}, 2000.0, entries), height);
  EXPECT_EQ(draw_legend(wide, {4, 4}, 2000.0, {}), 0.0);
}

TEST(Canvas, InkLandsWhereTheDrawingSays) {
  // 72 dpi: one point is one pixel.
  Drawing drawing;
  drawing.width_pt = 60;
  drawing.height_pt = 40;
  add_rectangle(drawing, {10, 5}, {20, 15}, kVermillion);
  drawing.items.push_back(Band{{{30, 5}, {40, 10}, {50, 5}}, {{30, 20}, {40, 20}, {50, 20}}, kBlue});
  drawing.items.push_back(Stroke{{{5, 30}, {55, 30}}, kGreen, 4.0, {}});
  const auto made = render(drawing, 72.0, "test", "a <test> & more");
  ASSERT_TRUE(made.ok()) << made.error().message();
  const Image png = image::decode_image(made->png, "test").value();
  ASSERT_EQ(png.width, 60);
  ASSERT_EQ(png.height, 40);
  const auto expect = [&](int u, int v, Colour colour) {
    const std::uint8_t* px = png.at(u, v);
    // A few levels of slack: software renderers round differently on different CPUs.
    EXPECT_NEAR(px[0], colour.r, 4) << u << "," << v;
    EXPECT_NEAR(px[1], colour.g, 4) << u << "," << v;
    EXPECT_NEAR(px[2], colour.b, 4) << u << "," << v;
  };
  expect(10, 5, kVermillion);
  expect(19, 14, kVermillion);
  expect(9, 5, kWhite);
  expect(20, 14, kWhite);
  expect(10, 4, kWhite);
  expect(40, 15, kBlue);
  expect(40, 7, kWhite);
  expect(30, 28, kGreen);
  expect(30, 31, kGreen);
  expect(30, 27, kWhite);
  expect(30, 32, kWhite);
  // 72 dots per inch are 2835 (0x0b13) per metre, just behind the header; its CRC was computed with Python's
  // zlib.
  EXPECT_EQ(made->png.substr(33, 21),
            std::string("\0\0\0\x09pHYs\0\0\x0b\x13\0\0\x0b\x13\x01\0\x9a\x9c\x18", 21));
  // The same rectangle in the SVG, 20 units to the point.
  EXPECT_NE(made->svg.find("viewBox=\"0 0 1200 800\""), std::string::npos);
  EXPECT_NE(made->svg.find("200,100"), std::string::npos);
  EXPECT_NE(made->svg.find("400,300"), std::string::npos);
  EXPECT_NE(made->svg.find("a &lt;test&gt; &amp; more"), std::string::npos);
}

TEST(Canvas, TextIsTheSameWhereverItStands) {
  // Pictures are painted strip by strip; some of these lines stand across two strips.
  constexpr int kPitchPx = 11, kLines = 30;
  Drawing drawing;
  drawing.width_pt = 60;
  drawing.height_pt = kPitchPx * (kLines + 1);
  for (int i = 1; i <= kLines; ++i)
    drawing.items.push_back(Text{{5.0, 1.0 * kPitchPx * i}, "gMj/qp", 8.0, kInk, Align::start});
  const auto made = render(drawing, 72.0, "test", "");
  ASSERT_TRUE(made.ok()) << made.error().message();
  const Image png = image::decode_image(made->png, "test").value();
  const auto line = [&](int i) {
    const int top = kPitchPx * i - 8;
    return std::vector<std::uint8_t>(png.at(0, top), png.at(0, top + kPitchPx));
  };
  for (int i = 2; i <= kLines; ++i) EXPECT_EQ(line(i), line(1)) << i;
}

/// Kilobytes of a line of /proc/self/status; 0 where there is none.
long status_kb(const std::string& name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(name + ":")) return std::strtol(line.c_str() + name.size() + 1, nullptr, 10);
  }
  return 0;
}

TEST(Canvas, ALargePageTakesLittleMemory) {
  Drawing drawing;
  drawing.width_pt = 500;
  drawing.height_pt = 400;
  drawing.items.push_back(Stroke{{{5, 30}, {455, 300}}, kGreen, 4.0, {}});
  ASSERT_TRUE(render(drawing, 72.0, "test", "").ok());  // what the renderer needs in any case
  std::ofstream("/proc/self/clear_refs") << "5";        // the peak counts from here
  const long before_kb = status_kb("VmRSS");
  if (before_kb == 0 || status_kb("VmHWM") > before_kb + 10000) GTEST_SKIP() << "no peak to be had here";
  // 2083 x 1667 px, nine times as many before they are averaged: 125 MB for one copy of four bytes a pixel.
  ASSERT_TRUE(render(drawing, 300.0, "test", "").ok());
  constexpr long kMostKb = 90000;
  EXPECT_LT(status_kb("VmHWM") - before_kb, kMostKb);
}

}  // namespace
}  // namespace furrow::figures
