#include <gtest/gtest.h>
#include <cmath>

#include "field_generator.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;
using testing::Noise;
using testing::World;

World oblique_world() {
  World world;
  world.attitude = {deg_to_rad(3.0), deg_to_rad(-20.0), deg_to_rad(0.8)};
  world.height_above_canopy_m = 2.3;
  world.cross_track_m = 0.37;
  return world;
}

/// Rows without walls: what the closed form is exact for.
World flat(World world) {
  world.foliage_depth_m = 1e-9;
  return world;
}

RowsOnUnitPlane seen(const World& world, const Noise& noise = {}) {
  const Camera camera = testing::thesis_camera();
  return rows_on_unit_plane(testing::picture_of(world, camera, noise), camera).value();
}

TEST(UnitPlane, TakesPixelsToDirectionsAndBack) {
  const Camera camera = testing::thesis_camera();
  const rows::RowLines lines = testing::picture_of(oblique_world(), camera);
  const RowsOnUnitPlane plane = rows_on_unit_plane(lines, camera).value();
  ASSERT_EQ(plane.rows.size(), lines.rows.size());
  ASSERT_GE(plane.rows.size(), 3u);
  for (std::size_t k = 0; k < lines.rows.size(); ++k) {
    ASSERT_EQ(plane.rows[k].directions.size(), lines.rows[k].samples.size());
    const Eigen::Vector2d d = plane.rows[k].directions[2].centre;
    const auto px = camera::project(camera, {d.x(), d.y(), 1.0});
    ASSERT_TRUE(px);
    EXPECT_NEAR((*px - lines.rows[k].samples[2].centre_px).norm(), 0.0, 1e-6);
  }
}

TEST(UnitPlane, SigmaAcrossAnUprightRowIsPixelsOverFocalLength) {
  Camera camera;
  camera.width = 1280, camera.height = 720, camera.fx = 800, camera.fy = 1000, camera.cx = 640,
  camera.cy = 360;
  rows::RowLines lines;
  lines.width = 1280, lines.height = 720, lines.status = "ok";
  rows::RowLine upright, diagonal;
  for (int i = 0; i < 3; ++i) {
    upright.samples.push_back({{700.0, 400.0 + 10 * i}, 2.0, 690.0, 710.0, 1.0});
    // 45 deg on the unit plane: 8 px in u for 10 px in v.
    diagonal.samples.push_back({{700.0 + 8 * i, 400.0 + 10 * i}, 2.0, 690.0 + 8 * i, 710.0 + 8 * i, 1.0});
  }
  diagonal.index = 1;
  lines.rows = {upright, diagonal};
  const RowsOnUnitPlane plane = rows_on_unit_plane(lines, camera).value();
  EXPECT_NEAR(plane.rows[0].directions[1].sigma, 2.0 / 800.0, 1e-12);
  EXPECT_NEAR(plane.rows[0].directions[1].edge_sigma, 1.0 / 800.0, 1e-12);
  // Along u, an edge error moves a 45 deg line by its cosine.
  EXPECT_NEAR(plane.rows[1].directions[1].edge_sigma, std::sqrt(0.5) / 800.0, 1e-12);
}

TEST(UnitPlane, NamesWhatIsWrong) {
  const Camera camera = testing::thesis_camera();
  rows::RowLines lines = testing::picture_of(oblique_world(), camera);
  lines.width = 640;
  EXPECT_EQ(rows_on_unit_plane(lines, camera).error().code, "picture_size_differs");
  lines.status = "no_rows";
  EXPECT_EQ(rows_on_unit_plane(lines, camera).error().code, "rows_not_ok");
}

TEST(FromSpacing, IsExactForFlatRowsWithoutNoise) {
  const World world = flat(oblique_world());
  const auto result =
      from_spacing(seen(world), testing::knowledge_of(world, 0.0), testing::prior_of(world, 0.02, 1e-6));
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_NEAR(result->height_above_canopy_m.value, 2.3, 2e-5);
  EXPECT_NEAR(result->height_over_spacing.value, 2.3 / 3.0, 1e-5);
  EXPECT_NEAR(result->pitch_rad.value, deg_to_rad(-20.0), 1e-5);
  EXPECT_NEAR(result->yaw_rad.value, deg_to_rad(3.0), 1e-5);
  EXPECT_NEAR(result->cross_track_m.value, 0.37, 3e-5);
}

TEST(FromSpacing, FarEdgesKeepWallsOutOfTheHeight) {
  World world = oblique_world();
  world.height_above_canopy_m = 1.3;
  const auto result =
      from_spacing(seen(world), testing::knowledge_of(world, 0.0), testing::prior_of(world, 0.02, 1e-6));
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_NEAR(result->height_above_canopy_m.value, 1.3, 1e-4);
}

TEST(FromSpacing, AnswersTheRatioWithoutASpacing) {
  World world = flat(oblique_world());
  world.rounding_m =
      kRoundingPerHalfWidth * world.half_width_m;  // what stands in for a depth that is not known
  const auto result = from_spacing(seen(world), {}, {});
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_FALSE(result->height_above_canopy_m.usable());
  EXPECT_FALSE(result->cross_track_m.usable());
  EXPECT_NEAR(result->height_over_spacing.value, 2.3 / 3.0, 0.02);
}

TEST(FromSpacing, NumbersThatNoFarmHasAreNamed) {
  const World world = flat(oblique_world());
  const RowsOnUnitPlane rows = seen(world);
  const auto error_of = [&](const FieldKnowledge& field) {
    const auto closed = from_spacing(rows, field, {});
    const auto any = from_any_scale(rows, field, {}, {});
    EXPECT_FALSE(closed.ok());
    EXPECT_FALSE(any.ok());
    if (closed.ok() || any.ok()) return std::string("none");
    EXPECT_EQ(closed.error().message(), any.error().message());
    return closed.error().code + " " + closed.error().where;
  };
  FieldKnowledge field = testing::knowledge_of(world, 0.0);
  field.half_width_m.value = -0.6;
  EXPECT_EQ(error_of(field), "bad_field half_width_m");
  field.row_spacing_m = {};
  EXPECT_EQ(error_of(field), "bad_field half_width_m") << "a spacing need not be known";
  field = testing::knowledge_of(world, 0.0);
  field.row_spacing_m.value = -3.0;
  EXPECT_EQ(error_of(field), "bad_field row_spacing_m");
  field = testing::knowledge_of(world, 0.0);
  field.half_width_m.value = 2.0;
  EXPECT_EQ(error_of(field), "bad_field half_width_m") << "rows would overlap";
  field = testing::knowledge_of(world, 0.0);
  field.row_spacing_m.sigma = std::nan("");
  EXPECT_EQ(error_of(field), "not_finite row_spacing_m");
}

TEST(FromSpacing, TakesThePitchFromTheGimbalAtNadir) {
  World world = flat({});
  world.attitude = {deg_to_rad(2.0), deg_to_rad(-90.0), 0.0};
  world.height_above_canopy_m = 12.0;
  const RowsOnUnitPlane rows = seen(world);
  const FieldKnowledge field = testing::knowledge_of(world, 0.0);
  const auto result = from_spacing(rows, field, testing::prior_of(world, 0.01, 0.001));
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_NEAR(result->height_above_canopy_m.value, 12.0, 1e-3);
}

// Two short rows found to 20 px cannot tell how they converge.
TEST(FromSpacing, ParallelRowsNeedAPitch) {
  RowsOnUnitPlane rows;
  for (int k = 0; k < 2; ++k) {
    RowsOnUnitPlane::Row row;
    row.index = k;
    for (int i = 0; i < 3; ++i)
      row.directions.push_back({{-0.1 + 0.25 * k, -0.1 + 0.1 * i}, 0.02, {}, {}, 0.02});
    rows.rows.push_back(row);
  }
  EXPECT_EQ(from_spacing(rows, {}, {}).error().code, "no_pitch");
  AttitudePrior prior;
  prior.pitch_rad = {deg_to_rad(-90.0), 0.01, 1};
  prior.roll_rad = {0.0, 0.01, 1};
  const auto result = from_spacing(rows, {}, prior);
  ASSERT_TRUE(result.ok()) << result.error().message();
  EXPECT_NEAR(result->height_over_spacing.value, 1.0 / 0.25, 0.1);
}

// A spacing a tenth too wide, one sigma, beside a height that is known to a centimetre.
TEST(OffsetFromRows, AHeightMendsASpacing) {
  const World world = oblique_world();
  const Camera camera = testing::thesis_camera();
  FieldKnowledge field = testing::knowledge_of(world, 0.001);
  field.row_spacing_m = {3.3, 0.3, 1};
  field.half_width_m = {};  // would tell the metres too
  const AttitudePrior prior = testing::prior_of(world, 0.02, 0.001);
  const auto lines = testing::picture_of(world, camera);
  const Estimate height{world.height_above_canopy_m, 0.01, 1};
  const auto full = offset_from_rows(lines, camera, field, prior, height);
  ASSERT_TRUE(full.ok()) << full.error().message();
  EXPECT_NEAR(full->row_spacing_m.value, 3.0, 0.03);
  EXPECT_LT(full->row_spacing_m.sigma, 0.05);
  EXPECT_NEAR(full->cross_track_m.value, 0.37, 0.01);
  const auto closed = from_any_scale(rows_on_unit_plane(lines, camera).value(), field, prior, height);
  ASSERT_TRUE(closed.ok()) << closed.error().message();
  EXPECT_NEAR(closed->row_spacing_m.value, 3.0, 0.03);
  EXPECT_NEAR(closed->cross_track_m.value, 0.37, 0.01);
  EXPECT_NEAR(closed->height_above_canopy_m.value, world.height_above_canopy_m, 0.01);
}

TEST(FromSpacing, DegenerateInputHasAName) {
  const World world = oblique_world();
  RowsOnUnitPlane rows = seen(world);
  RowsOnUnitPlane one = rows;
  one.rows.resize(1);
  EXPECT_EQ(from_spacing(one, {}, {}).error().code, "not_enough_rows");
  EXPECT_EQ(from_spacing({}, {}, {}).error().code, "not_enough_rows");
  RowsOnUnitPlane same = rows;
  for (auto& row : same.rows) row.index = 0;
  EXPECT_EQ(from_spacing(same, {}, {}).error().code, "ill_conditioned");
  RowsOnUnitPlane mirrored = rows;
  for (auto& row : mirrored.rows) row.index = -row.index;
  EXPECT_EQ(from_spacing(mirrored, {}, {}).error().code, "ill_conditioned");
  rows.rows[1].directions[3].centre.x() = std::nan("");
  EXPECT_EQ(from_spacing(rows, {}, {}).error().code, "not_finite");
}

TEST(FromSpacing, RowsAcrossThePictureAreNamed) {
  RowsOnUnitPlane rows;
  for (int k = 0; k < 3; ++k) {
    RowsOnUnitPlane::Row row;
    row.index = k;
    for (int i = 0; i < 10; ++i)
      row.directions.push_back({{-0.5 + 0.1 * i, 0.1 + 0.1 * k + 0.002 * i}, 1e-3, {}, {}, 1e-3});
    rows.rows.push_back(row);
  }
  AttitudePrior prior;
  prior.pitch_rad = {deg_to_rad(-60.0), 0.02, 1};
  EXPECT_EQ(from_spacing(rows, {}, prior).error().code, "rows_across");
}

TEST(FromSpacing, RowsAboveTheHorizonAreNamed) {
  World world = flat(oblique_world());
  RowsOnUnitPlane rows = seen(world);
  // The picture upside down: the rows now run upwards from their common point, into the sky.
  for (auto& row : rows.rows) {
    for (auto& d : row.directions) {
      d.centre.y() = -d.centre.y();
      d.left.reset();
      d.right.reset();
    }
  }
  EXPECT_EQ(from_spacing(rows, {}, {}).error().code, "camera_along_horizon");
}

}  // namespace
}  // namespace furrow::altitude
