#include "rows/levelled.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/rows/detect.h"
#include "furrow/stats/robust.h"
#include "rows/drawn_field.h"

namespace furrow::rows {
namespace {

using testing::DrawnField;

constexpr int kMargin = 200;  // px above and below, so that the tilted picture shows the field everywhere

/// v of the level field, drawn with a margin, of a place in the tilted picture.
double level_v(const Image& tilted, double slope, double u, double v) {
  return v - slope * (u - 0.5 * (tilted.width - 1)) + kMargin;
}

/// The drawn field as a camera with roll shows it.
Image tilted(const DrawnField& drawn, double slope) {
  const Image level = testing::draw(drawn);
  Image out = image::make_image(drawn.width, drawn.height - 2 * kMargin, 3);
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      const double from = level_v(out, slope, u, v), part = from - std::floor(from);
      const int row = static_cast<int>(std::floor(from));
      for (int i = 0; i < 3; ++i)
        out.at(u, v)[i] = static_cast<std::uint8_t>(
            std::lround((1.0 - part) * level.at(u, row)[i] + part * level.at(u, row + 1)[i]));
    }
  }
  return out;
}

DrawnField with_margin() {
  DrawnField drawn = testing::oblique(640, 480);
  drawn.height += 2 * kMargin;
  drawn.field.v0 += kMargin;
  return drawn;
}

struct Errors {
  std::vector<double> centres, edges;  ///< spacings, px
};

/// Distances of rows -2 to 2 and of their edges from the drawn ones.
Errors errors_of(const DrawnField& drawn, const RowLines& lines, const Image& picture, double slope) {
  Errors errors;
  for (const RowLine& row : lines.rows) {
    if (std::abs(row.index) > 2) continue;
    for (const RowSample& sample : row.samples) {
      const auto k_at = [&](double u) {
        return drawn.field.k_at(u, level_v(picture, slope, u, sample.centre_px.y()));
      };
      if (sample.centre_px.y() < 0.2 * picture.height) continue;
      const double k = k_at(sample.centre_px.x());
      errors.centres.push_back(std::abs(k - std::round(k)));
      const double width_k = k_at(sample.right_u_px) - k_at(sample.left_u_px);
      const double spacing =
          drawn.field.spacing_at(level_v(picture, slope, sample.centre_px.x(), sample.centre_px.y()));
      if (std::isfinite(width_k)) errors.edges.push_back((width_k - 2.0 * drawn.half_width) * spacing);
    }
  }
  return errors;
}

TEST(Levelled, ATiltedHorizonThatIsToldCostsNothing) {
  const DrawnField drawn = with_margin();
  for (const double slope : {-0.3, 0.15}) {
    const Image picture = tilted(drawn, slope);
    DetectOptions options;
    options.priors.horizon_slope = slope;
    const RowLines lines = detect(picture, options);
    ASSERT_TRUE(lines.ok()) << slope;
    EXPECT_EQ(lines.horizon_slope, slope);
    DetectOptions wrong;
    wrong.priors.horizon_slope = 0.0;
    EXPECT_GT(lines.score, 1.2 * detect(picture, wrong).score) << slope;
    const Errors errors = errors_of(drawn, lines, picture, slope);
    ASSERT_GT(errors.centres.size(), 100U);
    EXPECT_LT(stats::median(errors.centres), 0.015) << slope;
    ASSERT_GT(errors.edges.size(), 100U);
    EXPECT_LT(std::abs(stats::median(errors.edges)), 0.7) << slope;
  }
}

// A roll of 20 deg is far beyond what the search without roll survives.
TEST(Levelled, ATiltThatIsNotToldIsFound) {
  DrawnField drawn = with_margin();
  drawn.field.spacing *= 0.5;  // three rows tell no tilt
  for (const double slope : {-0.36, -0.15, 0.15, 0.36}) {
    const Image picture = tilted(drawn, slope);
    const RowLines lines = detect(picture);
    ASSERT_TRUE(lines.ok()) << slope;
    EXPECT_NEAR(lines.horizon_slope, slope, 0.03);
    const Errors errors = errors_of(drawn, lines, picture, slope);
    ASSERT_GT(errors.centres.size(), 100U);
    EXPECT_LT(stats::median(errors.centres), 0.03) << slope;
  }
}

// What was seen before levels the next picture of a sequence: a roll that is too large to be found afresh.
TEST(Levelled, ATiltThatWasFoundStartsTheNextSearch) {
  constexpr double kSlope = 0.6;
  DrawnField drawn = with_margin();
  drawn.field.spacing *= 0.5;
  const Image picture = tilted(drawn, kSlope);
  DetectOptions told, options;
  told.priors.horizon_slope = kSlope;
  options.previous = previous_of(detect(picture, told));
  ASSERT_TRUE(options.previous);
  EXPECT_NEAR(detect(picture, options).horizon_slope, kSlope, 0.03);
}

// A roll that was told, level too, is not doubted.
TEST(Levelled, ALevelHorizonThatIsToldStays) {
  DrawnField drawn = with_margin();
  drawn.field.spacing *= 0.5;  // three rows tell no tilt
  const Image picture = tilted(drawn, 0.25);
  DetectOptions options;
  options.priors.horizon_slope = 0.0;
  EXPECT_EQ(detect(picture, options).horizon_slope, 0.0);
  EXPECT_NE(detect(picture).horizon_slope, 0.0);
}

// Half strips show rows that a level field does not explain: the score alone would promise more.
TEST(Levelled, WhatIsNotExplainedLowersTheConfidence) {
  DrawnField drawn = with_margin();
  drawn.field.spacing *= 0.5;
  DetectOptions options;
  options.priors.horizon_slope = 0.0;
  const RowLines lines = detect(tilted(drawn, 0.36), options);
  ASSERT_TRUE(lines.ok());
  EXPECT_LT(lines.confidence, 0.9 / (1.0 + std::exp(-(lines.score - 0.10) / 0.035)));
}

TEST(Levelled, VanishingPointAndHalfWidthAreOfThePictureItself) {
  const DrawnField drawn = with_margin();
  constexpr double kSlope = 0.15;
  const Image picture = tilted(drawn, kSlope);
  DetectOptions options;
  options.priors.horizon_slope = kSlope;
  const RowLines lines = detect(picture, options);
  ASSERT_TRUE(lines.vanishing_point_px.has_value());
  const auto truth = *drawn.field.vanishing_point();
  EXPECT_NEAR(lines.vanishing_point_px->x(), truth.x(), 8.0);
  EXPECT_NEAR(lines.vanishing_point_px->y(), truth.y() - kMargin + kSlope * (truth.x() - 319.5), 14.0);
  for (const RowLine& row : lines.rows) {
    if (std::abs(row.index) > 1 || !row.half_width_px) continue;
    const double v = 0.5 * (picture.height - 1), u = *u_at(row, v), w = row.half_width_px->value;
    const auto k_at = [&](double at) { return drawn.field.k_at(at, level_v(picture, kSlope, at, v)); };
    EXPECT_NEAR(0.5 * (k_at(u + w) - k_at(u - w)) / drawn.half_width, 1.0, 0.03) << row.index;
  }
}

TEST(Levelled, SamplesStayCloseAndInThePicture) {
  const Image picture = tilted(with_margin(), 0.3);
  DetectOptions options;
  options.priors.horizon_slope = 0.3;
  const RowLines lines = detect(picture, options);
  ASSERT_TRUE(lines.ok());
  for (const RowLine& row : lines.rows) {
    ASSERT_GE(row.samples.size(), 2U);
    for (std::size_t i = 1; i < row.samples.size(); ++i) {
      const double step = row.samples[i].centre_px.y() - row.samples[i - 1].centre_px.y();
      EXPECT_GT(step, 0.0);
      EXPECT_LE(step, 10.0);
    }
    EXPECT_GE(row.samples.front().centre_px.y(), 0.0);
    EXPECT_LE(row.samples.back().centre_px.y(), picture.height - 1.0);
  }
}

TEST(Levelled, SlopesThatMeanNothingAreNotUsed) {
  const Image picture = testing::draw(testing::oblique());
  for (const double slope : {0.0, 0.005, 1e9, std::nan("")}) {
    DetectOptions options;
    options.priors.horizon_slope = slope;
    const RowLines lines = detect(picture, options);
    EXPECT_TRUE(lines.ok()) << slope;
    EXPECT_EQ(lines.horizon_slope, 0.0) << slope;
  }
}

}  // namespace
}  // namespace furrow::rows
