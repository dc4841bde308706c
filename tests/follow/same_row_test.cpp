#include "furrow/follow/same_row.h"

#include <gtest/gtest.h>

#include <cmath>

namespace furrow::follow {
namespace {

/// Rows `spacing` apart, one at `place`; index 0 nearest the middle column, as rows::detect numbers them.
rows::RowLines rows_at(double place, double spacing) {
  rows::RowLines lines;
  lines.status = "ok", lines.width = 640, lines.height = 360;
  const double zero = place + spacing * std::round((319.5 - place) / spacing);
  for (int index = -2; index <= 2; ++index) {
    rows::RowLine row;
    row.index = index;
    for (double v = 0.0; v < 360.0; v += 9.0)
      row.samples.push_back({.centre_px = {zero + index * spacing, v}});
    lines.rows.push_back(row);
  }
  return lines;
}

TEST(SameRow, AHeldRowKeepsItsNumber) {
  EXPECT_EQ(index_shift(rows_at(310.0, 100.0), rows_at(335.0, 104.0)), 0);
}

TEST(SameRow, ANeighbourThatComesToTheMiddleIsNamed) {
  // The row at 280 moves left to 265; its right neighbour, 380 before, is nearest now.
  EXPECT_EQ(index_shift(rows_at(280.0, 100.0), rows_at(265.0, 100.0)), 1);
  EXPECT_EQ(index_shift(rows_at(360.0, 100.0), rows_at(375.0, 100.0)), -1);
}

TEST(SameRow, DoubtIsSaid) {
  EXPECT_FALSE(index_shift(rows_at(300.0, 100.0), rows_at(350.0, 100.0)).has_value());  // half a spacing
  EXPECT_FALSE(index_shift(rows_at(300.0, 100.0), rows_at(300.0, 200.0)).has_value());  // another spacing
  EXPECT_FALSE(index_shift(rows_at(300.0, 100.0), rows::RowLines{}).has_value());
}

/// The same with row 0 only.
rows::RowLines alone_at(double place) {
  rows::RowLines lines = rows_at(place, 1000.0);
  std::erase_if(lines.rows, [](const rows::RowLine& row) { return row.index != 0; });
  return lines;
}

TEST(SameRow, ARowAloneGoesByTheSpacingOfTheOther) {
  EXPECT_EQ(index_shift(alone_at(300.0), alone_at(500.0)), 0);
  EXPECT_EQ(index_shift(rows_at(300.0, 100.0), alone_at(310.0)), 0);
  EXPECT_EQ(index_shift(rows_at(300.0, 100.0), alone_at(395.0)), 1);
  EXPECT_EQ(index_shift(alone_at(395.0), rows_at(300.0, 100.0)), -1);
  EXPECT_FALSE(index_shift(rows_at(300.0, 100.0), alone_at(350.0)).has_value());
}

TEST(SameRow, NeighboursOutOfViewAreRemembered) {
  const auto numbers =
      followed_rows({rows_at(300.0, 100.0), alone_at(305.0), alone_at(310.0), alone_at(400.0)});
  EXPECT_EQ(numbers[2], 0);
  EXPECT_EQ(numbers[3], 1);  // 90 px farther: the neighbour
}

TEST(SameRow, NumbersThroughASidewardFlight) {
  // The rows wander left by 15 px a picture; one picture without rows is bridged.
  std::vector<rows::RowLines> sequence;
  for (int i = 0; i < 21; ++i) sequence.push_back(rows_at(319.5 - 15.0 * i, 100.0));
  sequence[7] = rows::RowLines{};
  const auto numbers = followed_rows(sequence);
  for (int i = 0; i < 21; ++i) {
    if (i == 7) {
      EXPECT_FALSE(numbers[7].has_value());
      continue;
    }
    ASSERT_TRUE(numbers[static_cast<std::size_t>(i)].has_value()) << i;
    EXPECT_EQ(*numbers[static_cast<std::size_t>(i)], static_cast<int>(std::lround(15.0 * i / 100.0))) << i;
  }
}

TEST(SameRow, LostStaysLost) {
  const auto numbers = followed_rows({rows_at(300.0, 100.0), rows_at(350.0, 100.0), rows_at(350.0, 100.0)});
  EXPECT_EQ(numbers[0], 0);
  EXPECT_FALSE(numbers[1].has_value());
  EXPECT_FALSE(numbers[2].has_value());
}

}  // namespace
}  // namespace furrow::follow
