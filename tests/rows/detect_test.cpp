#include "furrow/rows/detect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/stats/robust.h"
#include "rows/drawn_field.h"

namespace furrow::rows {
namespace {

using testing::draw;
using testing::DrawnField;
using testing::nadir;
using testing::oblique;

/// Number of a detected row in the drawn field.
int drawn_index(const DrawnField& drawn, const RowLine& row) {
  const Eigen::Vector2d lowest = row.samples.back().centre_px;
  return static_cast<int>(std::lround(drawn.field.k_at(lowest.x(), lowest.y())));
}

/// Median distance of a row from the drawn one over the lower four fifths of the picture, spacings; a row
/// that is not there is far.
double row_error(const DrawnField& drawn, const RowLines& lines, int index) {
  for (const RowLine& row : lines.rows) {
    if (row.index != index) continue;
    const int k = drawn_index(drawn, row);
    std::vector<double> errors;
    for (double v = 0.2 * drawn.height; v < drawn.height; v += 5.0)
      if (const auto u = u_at(row, v))
        errors.push_back(std::abs(*u - drawn.field.u_at(v, k)) / drawn.field.spacing_at(v));
    return stats::median(errors);
  }
  return 9.0;
}

void expect_rows(const DrawnField& drawn, double tolerance, const char* what) {
  const RowLines lines = detect(draw(drawn));
  ASSERT_TRUE(lines.ok()) << what << ": " << lines.reason;
  EXPECT_LT(row_error(drawn, lines, 0), tolerance) << what;
  const double v = 0.7 * drawn.height;
  ASSERT_TRUE(lines.field.has_value());
  EXPECT_NEAR(lines.field->spacing_at(v) / drawn.field.spacing_at(v), 1.0, 0.03) << what;
}

TEST(FieldMethod, ObliqueRows) {
  expect_rows(oblique(), 0.02, "oblique");
}

TEST(FieldMethod, NadirRows) {
  expect_rows(nadir(), 0.02, "nadir");
  const RowLines lines = detect(draw(nadir()));
  EXPECT_FALSE(lines.vanishing_point_px.has_value());
}

TEST(FieldMethod, VanishingPoint) {
  const DrawnField drawn = oblique();
  const RowLines lines = detect(draw(drawn));
  ASSERT_TRUE(lines.vanishing_point_px.has_value());
  const auto truth = *drawn.field.vanishing_point();
  EXPECT_NEAR(lines.vanishing_point_px->x(), truth.x(), 6.0);
  EXPECT_NEAR(lines.vanishing_point_px->y(), truth.y(), 12.0);
}

TEST(FieldMethod, SlantedRowsSeenFromStraightAbove) {
  for (const double tangent : {-1.4, -0.6, 0.5, 1.2}) {
    DrawnField drawn = nadir();
    drawn.field.slope = tangent * drawn.height;
    expect_rows(drawn, 0.03, "slanted");
  }
}

TEST(FieldMethod, BendingRows) {
  DrawnField drawn = oblique();
  drawn.field.bend = 0.04 * drawn.field.spacing;
  expect_rows(drawn, 0.03, "bending");
}

TEST(FieldMethod, SkyAbove) {
  DrawnField drawn = oblique();
  drawn.field.convergence = 1.4;
  expect_rows(drawn, 0.03, "sky");
}

TEST(FieldMethod, ManyAndFewRows) {
  for (const double spacing : {0.03, 0.06, 0.25, 0.42}) {
    DrawnField drawn = nadir();
    drawn.field.spacing = spacing * drawn.width;
    expect_rows(drawn, 0.03, "row count");
  }
}

// Every second or third row, or twice as many, would fit a comb as well where rows are thin or wide.
TEST(FieldMethod, ThinAndWideRowsKeepTheirSpacing) {
  for (const double half_width : {0.04, 0.10, 0.30, 0.40}) {
    DrawnField drawn = oblique();
    drawn.half_width = half_width;
    expect_rows(drawn, 0.03, "row width");
  }
}

// Five pixels apart on the middle row.
TEST(FieldMethod, ManyRowsInASmallPicture) {
  DrawnField drawn = oblique(320, 240);
  drawn.field.spacing = 9.0;
  expect_rows(drawn, 0.05, "narrow rows");
}

// Two strips of grass that is greener than the leaves of the row between them look like two rows.
TEST(FieldMethod, GrassGreenerThanLeavesIsNotARow) {
  for (const double half_width : {0.16, 0.20, 0.24}) {
    DrawnField drawn = oblique();
    drawn.field.spacing = 0.9 * drawn.width;
    drawn.half_width = half_width, drawn.grass = 0.33, drawn.grass_colour = {100.0, 190.0, 40.0};
    expect_rows(drawn, 0.05, "bright grass");
  }
}

TEST(FieldMethod, GapsNoiseAndUnevenLight) {
  DrawnField drawn = oblique();
  drawn.gaps = 0.3, drawn.noise = 20.0, drawn.ragged = 0.03, drawn.light_gradient = 1.0;
  expect_rows(drawn, 0.03, "rough");
}

TEST(FieldMethod, SamplesRunFromTopToBottomAtMostTenPixelsApart) {
  const RowLines lines = detect(draw(oblique()));
  ASSERT_TRUE(lines.ok());
  int last_index = lines.rows.front().index - 1;
  for (const RowLine& row : lines.rows) {
    EXPECT_EQ(row.index, ++last_index);
    for (std::size_t i = 1; i < row.samples.size(); ++i) {
      const double step = row.samples[i].centre_px.y() - row.samples[i - 1].centre_px.y();
      EXPECT_GT(step, 0.0);
      EXPECT_LE(step, 10.0);
    }
  }
}

struct EdgeTally {
  std::vector<double> errors, normalised, widths;
};

/// Edges of all rows in the lower two thirds against the drawn ones.
EdgeTally edges_of(const DrawnField& drawn) {
  EdgeTally tally;
  const RowLines lines = detect(draw(drawn));
  for (const RowLine& row : lines.rows) {
    const int k = drawn_index(drawn, row);
    const double v_middle = 0.5 * (drawn.height - 1);
    const double truth_width = drawn.half_width * drawn.field.spacing_at(v_middle);
    if (row.half_width_px) tally.widths.push_back(row.half_width_px->value / truth_width - 1.0);
    for (const RowSample& sample : row.samples) {
      const double v = sample.centre_px.y(), half = drawn.half_width * drawn.field.spacing_at(v);
      if (v < 0.33 * drawn.height) continue;
      const double left = sample.left_u_px - (drawn.field.u_at(v, k) - half),
                   right = sample.right_u_px - (drawn.field.u_at(v, k) + half);
      for (const double outwards : {-left, right}) {
        if (!std::isfinite(outwards)) continue;
        tally.errors.push_back(outwards);
        tally.normalised.push_back(outwards / sample.edge_sigma_px);
      }
    }
  }
  return tally;
}

// The mean error is a bias and must be a small part of a pixel: heights hang on it.
TEST(FieldEdges, UnbiasedForThinAndWideRows) {
  for (const bool from_above : {false, true}) {
    for (const double half_width : {0.10, 0.2, 0.3}) {
      DrawnField drawn = from_above ? nadir(1280, 720) : oblique(1280, 720);
      drawn.half_width = half_width;
      const EdgeTally tally = edges_of(drawn);
      ASSERT_GT(tally.errors.size(), 100U);
      EXPECT_LT(std::abs(stats::median(tally.errors)), 0.35)
          << half_width << (from_above ? " from above" : " oblique");
      ASSERT_FALSE(tally.widths.empty());
      EXPECT_LT(std::abs(stats::median(tally.widths)), 0.02) << half_width;
    }
  }
}

TEST(FieldEdges, RaggedEdgesHaveHonestSigmas) {
  DrawnField drawn = oblique(1280, 720);
  drawn.ragged = 0.02, drawn.noise = 10.0;
  std::vector<double> errors, normalised;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    drawn.seed = seed;
    const EdgeTally tally = edges_of(drawn);
    errors.insert(errors.end(), tally.errors.begin(), tally.errors.end());
    normalised.insert(normalised.end(), tally.normalised.begin(), tally.normalised.end());
  }
  ASSERT_GT(errors.size(), 300U);
  EXPECT_LT(std::abs(stats::mean(errors)), 0.5);
  const auto inside = [&](double limit) {
    return static_cast<double>(std::count_if(normalised.begin(), normalised.end(),
                                             [&](double x) { return std::abs(x) < limit; })) /
           static_cast<double>(normalised.size());
  };
  EXPECT_GT(inside(1.0), 0.55);
  EXPECT_LT(inside(1.0), 0.85);
  EXPECT_GT(inside(2.0), 0.88);
}

TEST(FieldEdges, GapsAreNotSeen) {
  DrawnField drawn = nadir();
  drawn.gaps = 0.3, drawn.noise = 2.0;
  const RowLines lines = detect(draw(drawn));
  ASSERT_TRUE(lines.ok());
  int seen = 0, unseen = 0;
  for (const RowLine& row : lines.rows) {
    EXPECT_TRUE(row.seen) << row.index;
    for (const RowSample& sample : row.samples) ++(sample.seen ? seen : unseen);
  }
  EXPECT_GT(seen, unseen);
  EXPECT_GT(unseen, (seen + unseen) / 10);
}

TEST(FieldEdges, MergedRowsHaveNoEdges) {
  DrawnField drawn = nadir();
  drawn.half_width = 0.5;
  const RowLines lines = detect(draw(drawn));
  for (const RowLine& row : lines.rows) EXPECT_FALSE(row.half_width_px.has_value());
}

// ---- Pictures without rows, and bad pictures
// ----------------------------------------------------------------------------------------

void expect_no_rows(const Image& picture, const char* what) {
  const RowLines lines = detect(picture);
  EXPECT_EQ(lines.status, "no_rows") << what << " confidence " << lines.confidence;
  EXPECT_FALSE(lines.reason.empty()) << what;
  EXPECT_TRUE(lines.rows.empty()) << what;
  EXPECT_EQ(lines.confidence, 0.0) << what;
}

TEST(NoRows, BlackWhiteNoiseAndLawn) {
  for (const int level : {0, 128, 255}) {
    Image flat = image::make_image(320, 240, 3);
    std::fill(flat.data.begin(), flat.data.end(), static_cast<std::uint8_t>(level));
    expect_no_rows(flat, "flat");
  }
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    base::Random random(seed);
    Image noise = image::make_image(320, 240, 3), lawn = image::make_image(640, 360, 3);
    for (auto& value : noise.data)
      value = static_cast<std::uint8_t>(std::clamp(random.normal(120.0, 40.0), 0.0, 255.0));
    for (std::size_t i = 0; i < lawn.data.size(); i += 3) {
      const double light = random.normal(1.0, 0.25);
      lawn.data[i] = static_cast<std::uint8_t>(std::clamp(60.0 * light, 0.0, 255.0));
      lawn.data[i + 1] =
          static_cast<std::uint8_t>(std::clamp(110.0 * light + random.normal(0.0, 8.0), 0.0, 255.0));
      lawn.data[i + 2] = static_cast<std::uint8_t>(std::clamp(40.0 * light, 0.0, 255.0));
    }
    expect_no_rows(noise, "noise");
    expect_no_rows(lawn, "lawn");
  }
}

TEST(BadPictures, AnySizeIsAnswered) {
  EXPECT_EQ(detect(Image{}).status, "picture_empty");
  for (const auto& [width, height] :
       {std::pair{1, 1}, {1, 500}, {500, 1}, {23, 15}, {24, 16}, {3000, 17}, {17, 3000}}) {
    const Image picture = image::make_image(width, height, 3);
    for (const Method method : {Method::field, Method::thesis}) {
      DetectOptions options;
      options.method = method;
      const RowLines lines = detect(picture, options);
      EXPECT_EQ(lines.status, "no_rows") << width << "x" << height;
      EXPECT_EQ(lines.width, width);
    }
  }
}

TEST(BadPictures, AHundredMegapixels) {
  const DrawnField drawn = oblique(320, 240);
  const Image small = draw(drawn);
  const Image large = image::resize(small, 11600, 8700);
  const RowLines lines = detect(large);
  ASSERT_TRUE(lines.ok());
  EXPECT_NEAR(lines.field->spacing_at(0.7 * 8700) / (drawn.field.spacing_at(0.7 * 240) * 8700 / 240), 1.0,
              0.03);
}

TEST(BadPictures, GreyHasNoGreen) {
  const Image grey = image::to_grey(draw(oblique()));
  EXPECT_EQ(detect(grey).status, "no_rows");
  DetectOptions options;
  options.method = Method::thesis;
  EXPECT_EQ(detect(grey, options).status, "no_rows");
}

TEST(FieldMethod, SamePictureSameAnswer) {
  const Image picture = draw(oblique());
  const RowLines a = detect(picture), b = detect(picture);
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t i = 0; i < a.rows.size(); ++i)
    for (std::size_t j = 0; j < a.rows[i].samples.size(); ++j)
      EXPECT_EQ(a.rows[i].samples[j].centre_px, b.rows[i].samples[j].centre_px);
}

TEST(FieldMethod, TheShotBeforeStartsTheSearch) {
  DrawnField drawn = oblique();
  const RowLines before = detect(draw(drawn));
  drawn.field.offset += 0.25 * drawn.field.spacing;
  drawn.field.slope += 0.05 * drawn.field.spacing;
  drawn.seed = 2;
  DetectOptions options;
  options.previous = previous_of(before);
  ASSERT_TRUE(options.previous.has_value());
  const RowLines now = detect(draw(drawn), options);
  ASSERT_TRUE(now.ok());
  EXPECT_LT(row_error(drawn, now, 0), 0.03);
}

TEST(FieldMethod, AShotBeforeThatNoLongerFitsIsForgotten) {
  DetectOptions options;
  options.previous = previous_of(detect(draw(nadir())));
  ASSERT_TRUE(options.previous.has_value());
  const RowLines now = detect(draw(oblique()), options);
  ASSERT_TRUE(now.ok());
  EXPECT_LT(row_error(oblique(), now, 0), 0.03);
  EXPECT_FALSE(previous_of(RowLines{}).has_value());
}

TEST(FieldMethod, AWrongHorizonPullsOnlySoftly) {
  const DrawnField drawn = oblique();
  DetectOptions options;
  options.priors.horizon_v_px = 150.0;  // the truth is about -120
  const RowLines lines = detect(draw(drawn), options);
  ASSERT_TRUE(lines.ok());
  EXPECT_LT(row_error(drawn, lines, 0), 0.05);
}

// ---- The thesis's chain
// --------------------------------------------------------------------------------------------------------------

TEST(ThesisMethod, FindsStraightRowsOfACleanPicture) {
  DrawnField drawn = oblique(320, 180);
  drawn.noise = 2.0, drawn.half_width = 0.12;
  DetectOptions options;
  options.method = Method::thesis;
  const RowLines lines = detect(draw(drawn), options);
  ASSERT_TRUE(lines.ok());
  EXPECT_EQ(lines.method, "thesis");
  EXPECT_LE(lines.rows.size(), 3U);
  EXPECT_LT(row_error(drawn, lines, 0), 0.15);
}

TEST(ThesisMethod, StepsAreThePicturesOfTheChainInOrder) {
  const auto steps = thesis_steps(draw(oblique()));
  ASSERT_EQ(steps.size(), 9U);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].name.substr(0, 3), "0" + std::to_string(i + 1) + "_");
    EXPECT_EQ(steps[i].picture.width, 320);
    EXPECT_EQ(steps[i].picture.height, 180);
  }
  // The mask is binary and the filled picture contains the binary one.
  for (std::size_t i = 0; i < steps[3].picture.data.size(); ++i) {
    EXPECT_TRUE(steps[1].picture.data[i] == 0 || steps[1].picture.data[i] == 255);
    EXPECT_GE(steps[4].picture.data[i], steps[3].picture.data[i]);
  }
  EXPECT_TRUE(thesis_steps(Image{}).empty());
}

}  // namespace
}  // namespace furrow::rows
