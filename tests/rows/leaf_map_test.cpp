// Edges of leaves, where grass beside them is green too.
#include "rows/leaf_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/rows/detect.h"
#include "rows/drawn_field.h"

namespace furrow::rows {
namespace {

/// Relative error of the followed row's half width.
double width_error(const testing::DrawnField& drawn) {
  const RowLines lines = detect(draw(drawn));
  EXPECT_TRUE(lines.ok()) << lines.reason;
  const double truth = drawn.half_width * drawn.field.spacing_at(0.5 * (drawn.height - 1));
  for (const RowLine& row : lines.rows)
    if (row.index == 0 && row.half_width_px) return row.half_width_px->value / truth - 1.0;
  return std::nan("");
}

TEST(LeafMap, GrassAlongTheRowsIsNoLeaf) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    auto drawn = testing::oblique(1280, 720);
    drawn.seed = seed;
    drawn.half_width = 0.2;
    drawn.grass = 0.36;  // an edge of excess green lies here, 80 % too far out
    drawn.leaf_contrast = 0.5;
    EXPECT_LT(std::abs(width_error(drawn)), 0.06) << seed;
  }
}

TEST(LeafMap, LeavesOfTheSameColourStayWithTheEdgeOfGreen) {
  // Without texture and with soil alone nothing is gained, and nothing may be lost.
  auto drawn = testing::oblique(1280, 720);
  drawn.half_width = 0.2;
  EXPECT_LT(std::abs(width_error(drawn)), 0.03);
}

TEST(LeafMap, GreyMapAndClosedCanopyComeBackAsTheyAre) {
  auto drawn = testing::oblique();
  FoundField found;
  found.field = drawn.field, found.tooth = 0.4;
  drawn.half_width = 0.6;  // rows grown together
  const GreenMap closed = green_map(draw(drawn), 1e9);
  EXPECT_EQ(leaf_map(closed, CommonModel(found, closed), 0.4).value, closed.value);
  GreenMap grey = closed;
  grey.chroma.clear();
  EXPECT_EQ(leaf_map(grey, CommonModel(found, grey), 0.4).value, grey.value);
}

TEST(LeafMap, AModelOfNoSpacingTellsNothing) {
  auto drawn = testing::oblique();
  const GreenMap map = green_map(draw(drawn), 1e9);
  for (const double spacing : {0.0, 1e-300, 1e-12, -1e-12, std::nan("")}) {
    PlanarField field = drawn.field;
    field.spacing = spacing;
    EXPECT_EQ(leaf_map(map, CommonModel(field), 0.4).value, map.value) << spacing;
  }
}

}  // namespace
}  // namespace furrow::rows
