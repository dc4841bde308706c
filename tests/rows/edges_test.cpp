#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "furrow/base/random.h"
#include "furrow/rows/detect.h"
#include "rows/drawn_field.h"
#include "rows/edge_pencil.h"
#include "rows/index_rows.h"
#include "rows/leaf_edges.h"
#include "rows/summed_map.h"

namespace furrow::rows {
namespace {

constexpr int kWidth = 640, kHeight = 480;
const Eigen::Vector2d kMeet(330.0, -40.0);

/// Rows whose edges run to `kMeet`, with their places on the bottom row and noise.
RowLine straight_row(int index, double left, double right, double noise, base::Random& random) {
  RowLine row;
  row.index = index;
  for (double v = 20.0; v < kHeight; v += 10.0) {
    const double part = (v - kMeet.y()) / (kHeight - 1.0 - kMeet.y());
    RowSample sample;
    sample.left_u_px = kMeet.x() + part * (left - kMeet.x()) + random.normal(0.0, noise);
    sample.right_u_px = kMeet.x() + part * (right - kMeet.x()) + random.normal(0.0, noise);
    sample.centre_px = {0.5 * (sample.left_u_px + sample.right_u_px), v};
    sample.edge_sigma_px = 1.0;
    row.samples.push_back(sample);
  }
  return row;
}

Priors horizon_at(double v, double sigma) {
  Priors priors;
  priors.horizon_v_px = v;
  priors.horizon_sigma_px = sigma;
  return priors;
}

TEST(MeetingPoint, EdgesOutweighAWrongHorizonAndAWrongEdge) {
  base::Random random(4);
  std::vector<RowLine> rows = {straight_row(-1, 40.0, 120.0, 1.0, random),
                               straight_row(0, 280.0, 360.0, 1.0, random),
                               straight_row(1, 520.0, 600.0, 1.0, random)};
  // An edge that follows something else: it misses the point by a hundred pixels.
  for (RowSample& sample : rows[2].samples) sample.right_u_px += 0.3 * (sample.centre_px.y() - 240.0);
  const auto point = meeting_point(rows, horizon_at(kMeet.y() + 12.0, 15.0), 0.5 * (kWidth - 1));
  ASSERT_TRUE(point.has_value());
  EXPECT_NEAR(point->x(), kMeet.x(), 2.0);
  EXPECT_NEAR(point->y(), kMeet.y(), 4.0);
}

TEST(MeetingPoint, NothingWithoutHorizonOrAgainstIt) {
  base::Random random(5);
  const std::vector<RowLine> rows = {straight_row(0, 280.0, 360.0, 0.5, random),
                                     straight_row(1, 520.0, 600.0, 0.5, random)};
  EXPECT_FALSE(meeting_point(rows, Priors{}, 319.5).has_value());
  EXPECT_FALSE(meeting_point({rows[0]}, horizon_at(kMeet.y(), 15.0), 319.5).has_value());
  EXPECT_FALSE(meeting_point(rows, horizon_at(kMeet.y() + 80.0, 10.0), 319.5).has_value());
}

PlanarField field_of_map() {
  PlanarField anchor;
  anchor.u0 = 0.5 * (kWidth - 1), anchor.v0 = kHeight - 1.0, anchor.length = kHeight;
  return field_through(anchor, kMeet, kHeight - 1.0, 320.0, 240.0);
}

TEST(FieldThrough, MeetsThePointAndKeepsItsRows) {
  const PlanarField field = field_of_map();
  ASSERT_TRUE(field.vanishing_point().has_value());
  EXPECT_NEAR((*field.vanishing_point() - kMeet).norm(), 0.0, 1e-9);
  EXPECT_NEAR(field.u_at(kHeight - 1.0, 0.0), 320.0, 1e-9);
  EXPECT_NEAR(field.u_at(kHeight - 1.0, 1.0), 560.0, 1e-9);
}

/// The field of a picture is that of the picture levelled by `tilt` more, sheared back.
TEST(Relevelled, TheFollowedRowStaysWhereItIs) {
  constexpr double kTilt = -0.08, kMiddle = 0.5 * (kWidth - 1), kStep = 1e-4;
  const PlanarField field = field_of_map();
  const auto level = relevelled(field, kTilt, kMiddle);
  ASSERT_TRUE(level.has_value());
  const auto place = [&](double k, double v) {
    const double u = field.u_at(v, k);
    return level->k_at(u, v - kTilt * (u - kMiddle));
  };
  for (const double v : {0.0, 200.0, 450.0}) {
    EXPECT_NEAR(place(0.0, v), 0.0, 1e-9) << v;
    EXPECT_NEAR(place(kStep, v) / kStep, 1.0, 1e-3) << v;
    EXPECT_NEAR(place(2.0, v), place(2.0, 300.0), 1e-9) << v;  // still one line through the meeting point
    EXPECT_GT(std::abs(place(2.0, v) - 2.0), 0.1) << v;
  }
}

/// Log light by the distance from the last far edge, in parts of the tops' spacing.
using LightOf = std::function<double(double phase)>;

/// A canopy seen from low above: soil beside the followed row, then leaves, and behind every top a `strip` of
/// soil, in spacings. `spacing` is the tops', in row numbers of field_of_map; the tops' plane is that of the
/// picture levelled by `tilt`.
struct LowView {
  double spacing = 1.0, half_width = 0.2, strip = 0.0, tilt = 0.0;
  LightOf right, left;
};

GreenMap draw(const LowView& view) {
  const PlanarField field = *relevelled(field_of_map(), view.tilt, 0.5 * (kWidth - 1));
  base::Random random(6);
  GreenMap map;
  map.width = kWidth, map.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double k = field.k_at(u, v - view.tilt * (u - 0.5 * (kWidth - 1))) / view.spacing;
      const double away = std::abs(k), beyond = away - view.half_width;
      const double phase = beyond < 0.0 ? 1.0 : beyond - std::floor(beyond);
      const bool soil = (beyond > 0.0 && away < 0.45) || phase < view.strip;
      const double light =
          250.0 * std::exp((k < 0.0 ? view.left : view.right)(phase) + random.normal(0.0, 0.3));
      map.value.push_back(soil ? 0.0F : 0.3F);
      map.light.push_back(static_cast<std::uint16_t>(soil ? 500.0 : std::min(3.0 * 255.0, light)));
    }
  }
  return map;
}

/// Leaves: the light drops at each far edge and grows again to the next.
LowView leaves(double spacing, double contrast) {
  LowView view;
  view.spacing = spacing;
  const double wall = 1.0 - 2.0 * view.half_width;
  view.right = view.left = [=](double phase) { return contrast * (std::min(1.0, phase / wall) - 0.5); };
  return view;
}

/// Walls and tops of one light each.
LightOf faces(double half_width, double wall, double top) {
  return [=](double phase) { return phase < 1.0 - 2.0 * half_width ? wall : top; };
}

/// `far_edges`: with those of the rows beside the followed one.
std::vector<RowLine> rows_of(const LowView& view, bool far_edges = false) {
  const PlanarField field = field_of_map();
  std::vector<RowLine> rows;
  for (int k = -2; k <= 2; ++k) {
    RowLine row;
    row.index = k;
    for (double v = 5.0; v < kHeight; v += 10.0) {
      const auto u_at = [&](double place) { return field.u_at(v, place * view.spacing); };
      RowSample sample;
      sample.centre_px = {field.u_at(v, k), v};
      if (k == 0) sample.left_u_px = u_at(-view.half_width);
      if (k == 0) sample.right_u_px = u_at(view.half_width);
      if (k == -1) sample.right_u_px = u_at(-0.45);
      if (k == 1) sample.left_u_px = u_at(0.45);
      if (far_edges && k == -1) sample.left_u_px = u_at(-(1.0 + view.half_width));
      if (far_edges && k == 1) sample.right_u_px = u_at(1.0 + view.half_width);
      row.samples.push_back(sample);
    }
    rows.push_back(row);
  }
  return rows;
}

FoundTops tops_of(const LowView& view, bool far_edges = false) {
  return find_tops(draw(view), CommonModel(field_of_map()), 0.0, rows_of(view, far_edges));
}

void expect_tops(const LowView& view, bool far_edges = false) {
  const FoundTops found = tops_of(view, far_edges);
  const double spacing = view.spacing;
  ASSERT_TRUE(found.comb.has_value()) << spacing;
  EXPECT_EQ(found.tilt, 0.0) << spacing;
  EXPECT_NEAR(found.comb->spacing, spacing, 0.03) << spacing;
  EXPECT_NEAR(found.comb->middle, 0.0, 1e-6);
  ASSERT_GE(found.comb->edges.size(), 2U) << spacing;
  for (const TopEdge& edge : found.comb->edges) {
    const double far = spacing * (std::abs(edge.row) + view.half_width) * (edge.row < 0 ? -1.0 : 1.0);
    EXPECT_NEAR(edge.place.value, far, 3.0 * edge.place.sigma) << spacing << " row " << edge.row;
  }
}

TEST(Tops, LightTellsTheirSpacingAndFarEdges) {
  for (const double spacing : {0.8, 1.0, 1.25}) expect_tops(leaves(spacing, 0.5));
}

// Boxes without leaves: walls have one light, which the sun decides. Seen flatly tops may be darker than any.
TEST(Tops, FacesOfAnyLightTellThemToo) {
  LowView view;
  for (const double spacing : {0.8, 1.0, 1.25}) {
    view.spacing = spacing;
    view.right = view.left = faces(view.half_width, 0.2, -0.3);
    expect_tops(view);
    view.right = faces(view.half_width, 0.3, 0.0), view.left = faces(view.half_width, -0.4, 0.0);
    expect_tops(view);
  }
}

// With the alleys in view a comb of walls and tops fits in more than one place: far edges against the ground
// say which.
TEST(Tops, FarEdgesAgainstTheGroundBoundTheSpacing) {
  LowView view;
  view.half_width = 0.15, view.strip = 0.45;
  for (const double spacing : {0.8, 1.0, 1.25}) {
    view.spacing = spacing;
    view.right = view.left = faces(view.half_width, 0.2, -0.3);
    expect_tops(view, true);
    view.right = view.left = faces(view.half_width, -0.4, 0.3);
    expect_tops(view, true);
  }
}

TEST(Tops, LightTellsATiltOfTheirPlane) {
  for (const double tilt : {-0.12, -0.06, 0.06, 0.12}) {
    LowView view = leaves(1.0, 0.5);
    view.tilt = tilt;
    EXPECT_NEAR(tops_of(view).tilt, tilt, 0.015) << tilt;
  }
}

TEST(Tops, EvenLeavesTellNothing) {
  const auto tops = [](const GreenMap& map) {
    const FoundTops found = find_tops(map, CommonModel(field_of_map()), 0.0, rows_of(LowView{}));
    EXPECT_EQ(found.tilt, 0.0);
    return found.comb;
  };
  EXPECT_FALSE(tops(draw(leaves(1.0, 0.0))));
  EXPECT_FALSE(tops(GreenMap{}));
  GreenMap bare = draw(leaves(1.0, 0.5));
  std::fill(bare.value.begin(), bare.value.end(), 0.0F);
  EXPECT_FALSE(tops(bare));
}

/// The low view as a picture. Between rows farther off the feet of walls are in deep shade, so that the
/// search sees rows.
Image low_picture(double tilt) {
  LowView view = leaves(1.0, 0.5);
  view.tilt = tilt;
  const GreenMap map = draw(view);
  const PlanarField field = *relevelled(field_of_map(), tilt, 0.5 * (kWidth - 1));
  Image picture = image::make_image(kWidth, kHeight, 3);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto i = static_cast<std::size_t>(v * kWidth + u);
      const double k = std::abs(field.k_at(u, v - tilt * (u - 0.5 * (kWidth - 1))));
      const double beyond = k - view.half_width - std::floor(k - view.half_width);
      const bool foot = k > 1.0 && beyond < 0.12;
      const double light = map.light[i] / 250.0;
      const std::array colour = map.value[i] == 0.0F ? std::array{150.0, 125.0, 95.0}
                                : foot               ? std::array{32.0, 34.0, 28.0}
                                                     : std::array{55.0 * light, 105.0 * light, 40.0 * light};
      for (std::size_t c = 0; c < 3; ++c)
        picture.at(u, v)[c] = static_cast<std::uint8_t>(std::clamp(std::lround(colour[c]), 0L, 255L));
    }
  }
  return picture;
}

// The gimbal's roll is level against gravity; rows on a slope are not.
TEST(Tops, RowsOnASlopeAreLevelledByItWhateverRollIsTold) {
  for (const double tilt : {-0.06, 0.0, 0.06}) {
    DetectOptions options;
    options.priors = horizon_at(kMeet.y(), 15.0);
    options.priors.horizon_slope = 0.0;
    const RowLines lines = detect(low_picture(tilt), options);
    ASSERT_TRUE(lines.ok()) << lines.reason;
    EXPECT_NEAR(lines.horizon_slope, tilt, 0.015) << tilt;
    const PlanarField field = *relevelled(field_of_map(), tilt, 0.5 * (kWidth - 1));
    int tops = 0;
    for (const RowLine& row : lines.rows) {
      for (const RowSample& sample : row.samples) {
        for (const double u : {sample.top_left_u_px, sample.top_right_u_px}) {
          const double v = sample.centre_px.y();
          if (!std::isfinite(u) || field.scale(v) < 0.3) continue;
          const double far =
              std::abs(field.k_at(u, v - tilt * (u - 0.5 * (kWidth - 1)))) - LowView{}.half_width;
          EXPECT_NEAR(far, std::abs(row.index), 0.08) << tilt << " row " << row.index << " v " << v;
          ++tops;
        }
      }
    }
    EXPECT_GT(tops, 40) << tilt;
  }
}

// Four rows are summed at once; heights are seldom a multiple.
TEST(Rows, SummedMapSumsEveryRow) {
  for (const int height : {1, 3, 4, 6}) {
    GreenMap map;
    map.width = 5, map.height = height;
    for (int i = 0; i < map.width * height; ++i) map.value.push_back(static_cast<float>(i));
    const SummedMap summed(map);
    for (int row = 0; row < height; ++row) {
      float sum = 0.0F;
      for (int u = 0; u <= map.width; ++u) {
        EXPECT_EQ(summed.running(row)[u], sum) << height << " " << row << " " << u;
        if (u < map.width) sum += map.row(row)[u];
      }
      EXPECT_EQ(summed.running(row)[map.width + 1], sum);
    }
  }
}

// Rows that leave a low picture above its middle row came out of order by where they leave it.
TEST(Rows, CountFromTheFollowedKeepsTheModelsNumbers) {
  RowLines lines;
  lines.width = 101, lines.height = 101;
  const auto add = [&](int index, double u_top, double u_end, double v_end) {
    RowLine row;
    row.index = index;
    row.samples.push_back({.centre_px = {u_top, 0.0}});
    row.samples.push_back({.centre_px = {u_end, v_end}});
    lines.rows.push_back(row);
  };
  add(4, 48.0, 2.0, 40.0), add(5, 49.0, 0.0, 100.0), add(6, 50.0, 52.0, 100.0), add(7, 52.0, 99.0, 30.0);
  count_from_followed(lines);
  EXPECT_EQ(lines.rows[0].index, -2);
  EXPECT_EQ(lines.rows[2].index, 0);
  EXPECT_EQ(lines.rows[3].index, 1);
}

/// Largest distance of the followed row from its drawn place over the picture's lower two thirds, spacings.
double followed_row_error(const testing::DrawnField& drawn, const Priors& priors) {
  DetectOptions options;
  options.priors = priors;
  const RowLines lines = detect(draw(drawn), options);
  EXPECT_TRUE(lines.ok()) << lines.reason;
  double worst = 0.0;
  for (const RowLine& row : lines.rows) {
    if (row.index != 0) continue;
    for (const RowSample& sample : row.samples) {
      const double v = sample.centre_px.y();
      if (v < 0.33 * drawn.height) continue;
      const double k = drawn.field.k_at(sample.centre_px.x(), v);
      worst = std::max(worst, std::abs(k - std::round(k)));
    }
  }
  return worst;
}

TEST(Straightening, BentRowsStayBentAndStraightOnesStraight) {
  for (const double bend : {0.0, 60.0, 150.0}) {
    auto drawn = testing::oblique(1280, 720);
    drawn.field.bend = bend;
    drawn.half_width = 0.3;
    const Priors priors = horizon_at(*drawn.field.horizon_v(), 80.0);
    EXPECT_LT(followed_row_error(drawn, priors), 0.06) << bend;
  }
}

}  // namespace
}  // namespace furrow::rows
