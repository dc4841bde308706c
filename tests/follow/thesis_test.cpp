#include "furrow/follow/thesis.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "furrow/base/result.h"

namespace furrow::follow {
namespace {

// Worked examples of the thesis, section 4: half width 40 px.
TEST(ThesisFollow, WorkedExamplesInCentimetres) {
  EXPECT_NEAR(deviation_cm(5.59998, 40.0), 8.40, 5e-4);
  EXPECT_NEAR(deviation_cm(3.20001, 40.0), 4.80, 5e-4);
  EXPECT_NEAR(deviation_cm(5.5999755859375, 40.0), 8.39996337890625, 1e-12);
  EXPECT_NEAR(deviation_cm(15.0), 60.0, 1e-12);  // the default half width is 15 px
}

TEST(ThesisFollow, AHalfWidthMustBePositive) {
  EXPECT_THROW((void)deviation_cm(1.0, 0.0), base::CheckFailure);
}

rows::RowLines straight_rows(std::initializer_list<double> at) {
  rows::RowLines lines;
  lines.status = "ok";
  lines.width = 320, lines.height = 180;
  int index = -1;
  for (const double u : at) {
    rows::RowLine row;
    row.index = index++;
    for (double v = 0.0; v < 180.0; v += 9.0) row.samples.push_back({.centre_px = {u, v}});
    lines.rows.push_back(row);
  }
  return lines;
}

TEST(ThesisFollow, DeviationIsOfTheFollowedRowAgainstTheMiddleColumn) {
  const auto lines = straight_rows({60.0, 165.1, 270.0});
  ASSERT_TRUE(deviation_px(lines).has_value());
  EXPECT_NEAR(*deviation_px(lines), 165.1 - 159.5, 1e-12);
}

TEST(ThesisFollow, NoRowsNoDeviation) {
  rows::RowLines lines;
  EXPECT_FALSE(deviation_px(lines).has_value());
  lines.status = "ok", lines.width = 320, lines.height = 180;
  EXPECT_FALSE(deviation_px(lines).has_value());
}

// By hand: means of the last five 1, 1.5, 2, 2.5, 3, then (2 + 3 + 4 + 5 - 14) / 5 = 0 and (3 + 4 + 5 - 14 +
// 7) / 5 = 1.
TEST(ThesisFollow, FivePointMeanAndSmallerMagnitude) {
  const auto steering = thesis_steering({1.0, 2.0, 3.0, 4.0, 5.0, -14.0, 7.0});
  const double mean[] = {1.0, 1.5, 2.0, 2.5, 3.0, 0.0, 1.0};
  const double steer[] = {1.0, 1.5, 2.0, 2.5, 3.0, 0.0, 1.0};
  ASSERT_EQ(steering.size(), 7U);
  for (std::size_t i = 0; i < steering.size(); ++i) {
    EXPECT_NEAR(*steering[i].average_px, mean[i], 1e-12) << i;
    EXPECT_NEAR(*steering[i].steer_px, steer[i], 1e-12) << i;
  }
}

TEST(ThesisFollow, MagnitudesAreCompared) {
  // -1 is smaller than the mean 3 in magnitude: steer by the new one. -9 is not, though it is smaller without
  // the bars.
  const auto near = thesis_steering({4.0, 4.0, 4.0, 4.0, -1.0});
  EXPECT_NEAR(*near.back().steer_px, -1.0, 1e-12);
  const auto far = thesis_steering({4.0, 4.0, 4.0, 4.0, -9.0});
  EXPECT_NEAR(*far.back().steer_px, 1.4, 1e-12);
}

TEST(ThesisFollow, NothingSeenMeansHold) {
  const auto steering = thesis_steering({2.0, std::nullopt, std::numeric_limits<double>::quiet_NaN(), 4.0});
  EXPECT_FALSE(steering[1].steer_px.has_value());
  EXPECT_FALSE(steering[2].deviation_px.has_value());
  EXPECT_FALSE(steering[2].steer_px.has_value());
  EXPECT_NEAR(*steering[3].average_px, 3.0, 1e-12);
}

}  // namespace
}  // namespace furrow::follow
