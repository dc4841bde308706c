#include "rows/relief.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/rows/detect.h"
#include "rows/edge_pencil.h"

namespace furrow::rows {
namespace {

constexpr int kWidth = 640, kHeight = 360;
constexpr double kFocalPx = 430.0, kPitch = -0.23, kOverTops = 2.0, kSpacing = 2.2, kAside = 0.3;

struct Colour {
  std::uint8_t red, green, blue;
};

/// Box-shaped rows of dull leaves with dark walls, and strips of grass greener than they are midway between,
/// cast ray by ray. Row axes lie at kAside + n kSpacing beside the camera.
Image vineyard(double row_height) {
  constexpr Colour kTop{100, 112, 80}, kWall{50, 58, 40}, kSoil{150, 120, 95}, kGrass{90, 165, 50},
      kSky{120, 150, 190};
  constexpr double kHalfWidth = 0.45, kHalfGrass = 0.4;
  Image picture{kWidth, kHeight, 3, {}};
  picture.data.reserve(static_cast<std::size_t>(3 * kWidth * kHeight));
  const auto off_axis = [](double y) { return std::remainder(y - kAside, kSpacing); };
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double across = (u - 0.5 * (kWidth - 1)) / kFocalPx, down = (v - 0.5 * (kHeight - 1)) / kFocalPx;
      const double drop = std::cos(kPitch) * down - std::sin(kPitch);
      Colour colour = kSky;
      if (drop > 0.02) {
        const double y_top = across * kOverTops / drop, y_ground = across * (kOverTops + row_height) / drop;
        const bool is_top = std::abs(off_axis(y_top)) < kHalfWidth;
        // A ray meets a wall where a row's near edge lies between its places at the tops and on the ground.
        const double side = across > 0.0 ? 1.0 : -1.0;
        const double first = (side * (y_top - kAside) + kHalfWidth) / kSpacing,
                     last = (side * (y_ground - kAside) + kHalfWidth) / kSpacing;
        const bool is_wall = std::floor(last) > std::floor(first);
        colour = is_top                                                       ? kTop
                 : is_wall                                                    ? kWall
                 : std::abs(off_axis(y_ground)) > 0.5 * kSpacing - kHalfGrass ? kGrass
                                                                              : kSoil;
      }
      picture.data.insert(picture.data.end(), {colour.red, colour.green, colour.blue});
    }
  }
  return picture;
}

/// Straight rows so far below the camera, one of them `aside` m beside it.
PlanarField field_at(double depth, double aside) {
  PlanarField field;
  field.u0 = 0.5 * (kWidth - 1), field.v0 = kHeight - 1.0, field.length = kHeight;
  const Eigen::Vector2d point(field.u0, 0.5 * (kHeight - 1) + kFocalPx * std::tan(kPitch));
  const double px_per_m = (field.v0 - point.y()) * std::cos(kPitch) / depth;
  return field_through(field, point, field.v0, field.u0 + aside * px_per_m, kSpacing * px_per_m);
}

constexpr double kRowHeight = 1.4, kMostPixels = 1e6;

TEST(Relief, TopsAreFoundWhereTheFieldHasTheGrass) {
  const PlanarField grass = field_at(kOverTops + kRowHeight, kAside - 0.5 * kSpacing);
  const auto found = find_relief(green_map(vineyard(kRowHeight), kMostPixels), grass);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->elsewhere);
  const Relief& relief = found->relief;
  // In the ground's spacings: what is as high as the tops looks farther aside.
  const double stretch = (kOverTops + kRowHeight) / kOverTops;
  EXPECT_NEAR(relief.spacing, stretch, 0.03 * stretch);
  EXPECT_NEAR(relief.foot, 1.0 / stretch, 0.02);
  const double camera = -(kAside - 0.5 * kSpacing) / kSpacing, axis = camera + kAside / kSpacing * stretch;
  EXPECT_NEAR(relief.camera, camera, 1e-6);
  EXPECT_NEAR(std::remainder(relief.middle - axis, stretch), 0.0, 0.03 * stretch);
}

TEST(Relief, TopsOfTheFieldStay) {
  const auto found = find_relief(green_map(vineyard(kRowHeight), kMostPixels), field_at(kOverTops, kAside));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->elsewhere);
  EXPECT_NEAR(found->relief.spacing, 1.0, 0.05);
  EXPECT_NEAR(found->relief.middle, 0.0, 0.05);
}

TEST(Relief, StripesOnFlatGroundStayRows) {
  const GreenMap flat = green_map(vineyard(0.0), kMostPixels);
  const auto found = find_relief(flat, field_at(kOverTops, kAside));
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->elsewhere);
}

/// Rows on flat ground, straight, with a stripe of another look midway in every alley, or in every second
/// one.
GreenMap flat_rows(const PlanarField& field, int every) {
  GreenMap map;
  map.width = kWidth, map.height = kHeight;
  const auto pixels = static_cast<std::size_t>(kWidth * kHeight);
  map.value.resize(pixels), map.light.resize(pixels), map.chroma.resize(pixels);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto i = static_cast<std::size_t>(v * kWidth + u);
      const double k = field.scale(v) > 0.02 ? field.k_at(u, v) : 0.5;
      const bool row = std::abs(k - std::round(k)) < 0.2;
      const bool stripe =
          std::abs(k - std::floor(k) - 0.5) < 0.18 && static_cast<int>(std::floor(k)) % every == 0;
      const auto look = [&](int light, int red, int green) {
        map.light[i] = static_cast<std::uint16_t>(light);
        map.chroma[i] = static_cast<std::uint16_t>(red * kChromaLevels + green);
      };
      row ? look(220, 15, 35) : stripe ? look(280, 24, 22) : look(365, 26, 21);
    }
  }
  return map;
}

// Seen from the middle of an alley, tops midway between the rows explained such pictures better than tops at
// the rows, and rows of low crops moved there.
TEST(Relief, RowsOnFlatGroundStayWhateverLiesInTheirAlleys) {
  for (const double aside : {-0.9, 0.3, 1.0}) {
    const PlanarField rows = field_at(kOverTops, aside);
    for (const int every : {1, 2})
      EXPECT_FALSE(find_relief(flat_rows(rows, every), rows)->elsewhere) << aside << ' ' << every;
  }
}

TEST(Relief, NothingIsFoundWithoutColourOrPicture) {
  EXPECT_FALSE(find_relief(GreenMap{}, field_at(kOverTops, kAside)));
  PlanarField parallel = field_at(kOverTops, kAside);
  parallel.convergence = 0.0;
  EXPECT_FALSE(find_relief(green_map(vineyard(kRowHeight), kMostPixels), parallel));
}

TEST(Relief, RenumberedRowsShowTheSameSurfaces) {
  const Relief relief{0.1, 1.2, 0.25, -0.4, 0.6};
  const Relief renumbered = relief.renumbered(2.0);
  for (double k = -4.0; k < 4.0; k += 0.07)
    EXPECT_EQ(renumbered.surface_at(k + 2.0), relief.surface_at(k)) << k;
}

TEST(Relief, SurfacesFromTopToGroundOutwards) {
  const Relief relief{0.0, 1.0, 0.2, 0.0, 0.6};
  EXPECT_EQ(relief.surface_at(0.1), Surface::top);
  EXPECT_EQ(relief.surface_at(0.3), Surface::ground);
  EXPECT_EQ(relief.surface_at(0.55), Surface::wall);  // its foot stands at 0.6 of 0.8
  EXPECT_EQ(relief.surface_at(-0.55), Surface::wall);
  EXPECT_EQ(relief.surface_at(1.1), Surface::top);
  EXPECT_EQ(relief.surface_at(2.5), Surface::wall);  // from 1.68 on no ground shows
}

TEST(Relief, RowsAreTheCropsNotTheGreenerGrass) {
  DetectOptions options;
  options.priors.horizon_v_px = 0.5 * (kHeight - 1) + kFocalPx * std::tan(kPitch);
  options.priors.horizon_sigma_px = 7.0;
  options.priors.horizon_slope = 0.0;
  const RowLines lines = detect(vineyard(kRowHeight), options);
  ASSERT_TRUE(lines.ok());
  ASSERT_TRUE(lines.field);
  const PlanarField tops = field_at(kOverTops, kAside);
  EXPECT_NEAR(lines.field->spacing_at(300.0), tops.spacing_at(300.0), 0.06 * tops.spacing_at(300.0));
  const double k = tops.k_at(lines.field->u_at(300.0, 0.0), 300.0);
  EXPECT_NEAR(std::remainder(k, 1.0), 0.0, 0.1);
}

}  // namespace
}  // namespace furrow::rows
