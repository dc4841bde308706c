#include <gtest/gtest.h>
#include <cmath>

#include "field_generator.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;
using testing::Noise;
using testing::World;

World low_vineyard() {
  World world;
  world.attitude = {deg_to_rad(2.0), deg_to_rad(-12.4), deg_to_rad(0.5)};
  world.height_above_canopy_m = 1.3;
  world.cross_track_m = 0.15;
  return world;
}

Result<RefinedShot> refine(const World& world, const FieldKnowledge& field, const AttitudePrior& prior,
                           const Noise& noise = {}) {
  const Camera camera = testing::thesis_camera();
  return refine_shot(testing::picture_of(world, camera, noise), camera, field, prior);
}

struct NamedWorld {
  const char* name;
  World world;
};

std::vector<NamedWorld> worlds() {
  std::vector<NamedWorld> all = {{"3 m above ground", low_vineyard()}};
  World v = low_vineyard();
  v.base_half_width_m = 0.2;
  v.foliage_depth_m = 1.2;
  all.push_back({"V shaped", v});
  World five = low_vineyard();
  five.height_above_canopy_m = 3.3;
  five.attitude.pitch_rad = deg_to_rad(-13.8);
  all.push_back({"5 m above ground", five});
  World diagonal = low_vineyard();
  diagonal.height_above_canopy_m = 6.3;
  diagonal.attitude.pitch_rad = deg_to_rad(-45.0);
  all.push_back({"8 m, -45 deg", diagonal});
  World nadir = low_vineyard();
  nadir.height_above_canopy_m = 28.3;
  nadir.attitude = {deg_to_rad(2.0), deg_to_rad(-90.0), 0.0};
  all.push_back({"30 m, nadir", nadir});
  return all;
}

TEST(RefineShot, IsExactWithoutNoise) {
  for (const auto& [name, world] : worlds()) {
    const auto shot =
        refine(world, testing::knowledge_of(world, 0.01), testing::prior_of(world, 0.01, 0.005));
    ASSERT_TRUE(shot.ok()) << name << ": " << shot.error().message();
    EXPECT_TRUE(shot->usable);
    const double h = world.height_above_canopy_m;
    EXPECT_NEAR(shot->height_above_canopy_m.value, h, 1e-4 * h) << name;
    EXPECT_NEAR(shot->cross_track_m.value, world.cross_track_m, 1e-3) << name;
    EXPECT_NEAR(shot->pitch_rad.value, world.attitude.pitch_rad, 2e-4) << name;
    EXPECT_NEAR(shot->row_spacing_m.value, 3.0, 1e-4) << name;
    EXPECT_NEAR(shot->half_width_m.value, 0.6, 1e-3) << name;
    EXPECT_NEAR(shot->height_above_ground_m.value, h + 1.7, 1e-4 * h) << name;
  }
}

// A canopy that thins out over 8 cm. The generator moves each point of the outline along its own normal, the
// estimator whole cross-sections, so the two agree to some thousandths.
TEST(RefineShot, ASoftCanopyIsToldAndPutsTheHeightOffWhereItIsTakenForFirm) {
  World soft = low_vineyard();
  soft.height_above_canopy_m = 6.3;
  soft.attitude.pitch_rad = deg_to_rad(-45.0);
  soft.rounding_m = 0.3;
  soft.softness_m = 0.08;
  FieldKnowledge field = testing::knowledge_of(soft, 0.01);
  field.rounding_m = field.foliage_depth_m = field.base_width_ratio = field.softness_m = {};
  field.half_width_m.sigma = 0.1;
  const AttitudePrior prior = testing::prior_of(soft, deg_to_rad(2.0), 0.005);
  const auto found = refine(soft, field, prior);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_NEAR(found->softness_m.value, 0.08, 0.01);
  EXPECT_NEAR(found->height_above_canopy_m.value, 6.3, 0.003 * 6.3);
  EXPECT_NEAR(found->pitch_rad.value, soft.attitude.pitch_rad, deg_to_rad(0.02));
  field.softness_m = {0.0, 0.0, 1};
  const auto firm = refine(soft, field, prior);
  ASSERT_TRUE(firm.ok()) << firm.error().message();
  EXPECT_GT(std::abs(firm->height_above_canopy_m.value - 6.3), 0.003 * 6.3);
  EXPECT_GT(firm->residual_rms, 2.0 * found->residual_rms);
}

// The wall of a 3-D row must not bias the height at 3 m above ground, even when nothing is known of its depth
// or shape.
TEST(RefineShot, WallsDoNotBiasTheHeightWhenTheirShapeIsUnknown) {
  for (const double depth : {0.3, 0.7, 1.2, 1.7}) {
    for (const double base : {0.2, 0.4, 0.6}) {
      World world = low_vineyard();
      world.foliage_depth_m = depth;
      world.base_half_width_m = base;
      FieldKnowledge field = testing::knowledge_of(world, 0.01);
      field.half_width_m.sigma = 0.1;
      field.foliage_depth_m = {};
      field.base_width_ratio = {};
      const auto shot = refine(world, field, testing::prior_of(world, 0.02, 0.005));
      ASSERT_TRUE(shot.ok()) << depth << " " << base << ": " << shot.error().message();
      EXPECT_NEAR(shot->height_above_canopy_m.value, 1.3, 0.02 * 1.3) << depth << " " << base;
    }
  }
}

// One side of the rows in shade: the two walls end at different depths, and neither may pull at the height,
// least of all where a picture shows only four edges against the ground and one glimpse of a fifth.
TEST(RefineShot, AWallInShadeDoesNotBiasTheHeight) {
  for (const double shown : {0.6, 0.3}) {
    for (const double base : {0.3, 0.6}) {
      World world = low_vineyard();
      world.attitude.pitch_rad = deg_to_rad(-13.8);
      world.right_wall_shown = shown;
      world.base_half_width_m = base;
      FieldKnowledge field = testing::knowledge_of(world, 0.01);
      field.half_width_m.sigma = 0.09;
      field.foliage_depth_m = {};
      field.base_width_ratio = {};
      Noise none;
      none.leaf_against_leaf = false;
      const auto shot = refine(world, field, testing::prior_of(world, 0.02, 0.005), none);
      ASSERT_TRUE(shot.ok()) << shown << " " << base << ": " << shot.error().message();
      EXPECT_NEAR(shot->height_above_canopy_m.value, 1.3, 0.01 * 1.3) << shown << " " << base;
    }
  }
}

// A rounded top: flat lines of sight touch it near its ridge, steep ones where the row is widest.
TEST(RefineShot, ARoundedTopIsToldByItsRowsNearAndFar) {
  for (const double height : {2.3, 3.3}) {
    for (const double depth : {0.15, 0.6}) {
      World world = low_vineyard();
      world.height_above_canopy_m = height;
      world.attitude.pitch_rad = deg_to_rad(-13.8);
      world.rounding_m = depth;
      FieldKnowledge field = testing::knowledge_of(world, 0.01);
      field.half_width_m.sigma = 0.09;
      field.rounding_m = {};
      const auto shot = refine(world, field, testing::prior_of(world, 0.02, 0.005));
      ASSERT_TRUE(shot.ok()) << height << " " << depth << ": " << shot.error().message();
      EXPECT_NEAR(shot->height_above_canopy_m.value, height, 0.005 * height) << depth;
      EXPECT_NEAR(shot->rounding_m.value, depth, 2.0 * shot->rounding_m.sigma);
      field.rounding_m = {0.0, 0.0, 1};
      const auto flat = refine(world, field, testing::prior_of(world, 0.02, 0.005));
      ASSERT_TRUE(flat.ok());
      EXPECT_GT(std::abs(flat->height_above_canopy_m.value / height - 1.0), 0.015) << depth;
    }
  }
}

TEST(RefineShot, ABiasedGimbalPitchHardlyMovesTheHeight) {
  const World world = low_vineyard();
  AttitudePrior prior = testing::prior_of(world, deg_to_rad(1.0), 0.005);
  prior.pitch_rad.value += deg_to_rad(0.7);
  const auto shot = refine(world, testing::knowledge_of(world, 0.01), prior, {.edge_sigma_px = 1.0});
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_NEAR(shot->height_above_canopy_m.value, 1.3, 0.02 * 1.3);
  EXPECT_NEAR(shot->pitch_rad.value, world.attitude.pitch_rad, deg_to_rad(0.2));
}

TEST(RefineShot, SharesOfTheBudgetAddUpToTheSigma) {
  const World world = low_vineyard();
  Camera camera = testing::thesis_camera();
  camera.covariance = Eigen::MatrixXd::Zero(9, 9);
  camera.covariance.diagonal() << 25.0, 25.0, 4.0, 4.0, 1e-5, 1e-5, 1e-8, 1e-8, 1e-6;
  const auto lines = testing::picture_of(world, camera, {.edge_sigma_px = 1.0, .correlation = 0.5});
  const auto shot =
      refine_shot(lines, camera, testing::knowledge_of(world, 0.02), testing::prior_of(world, 0.01, 0.005));
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  double squares = 0.0;
  for (const SigmaShare& share : shot->height_budget) squares += share.sigma_m * std::abs(share.sigma_m);
  EXPECT_NEAR(std::sqrt(squares), shot->height_above_canopy_m.sigma, 1e-6);
  EXPECT_NEAR(shot->covariance(0, 0), std::pow(shot->height_above_canopy_m.sigma, 2), 1e-12);
}

// With all of the farm known but the spacing, the height is as uncertain as the spacing: H is proportional to
// S.
TEST(RefineShot, SpacingSigmaCarriesOverOneToOne) {
  const World world = low_vineyard();
  FieldKnowledge field = testing::knowledge_of(world, 0.3);
  field.row_spacing_m.sigma = 0.03;
  field.planting_sigma_m = 1e-6;
  field.growth_sigma_m = 1e-6;
  const auto shot = refine(world, field, testing::prior_of(world, 0.02, 0.02), {.edge_sigma_px = 0.01});
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_NEAR(shot->height_above_canopy_m.sigma, 0.01 * 1.3, 0.001);
}

TEST(RefineShot, FocalUncertaintyCarriesOverOneToOneAtNadir) {
  World world = low_vineyard();
  world.height_above_canopy_m = 10.0;
  world.attitude = {0.0, deg_to_rad(-90.0), 0.0};
  world.foliage_depth_m = 1e-9;  // walls of known depth would tell a wrong focal length
  Camera camera = testing::thesis_camera();
  FieldKnowledge field = testing::knowledge_of(world, 1e-5);
  field.planting_sigma_m = field.growth_sigma_m = 1e-6;
  const auto lines = testing::picture_of(world, camera, {.edge_sigma_px = 0.01});
  camera.covariance = Eigen::MatrixXd::Zero(9, 9);
  camera.covariance(0, 0) = std::pow(0.01 * camera.fx, 2);
  camera.covariance(1, 1) = std::pow(0.01 * camera.fy, 2);
  camera.covariance(0, 1) = camera.covariance(1, 0) = std::pow(0.01, 2) * camera.fx * camera.fy;
  const auto shot = refine_shot(lines, camera, field, testing::prior_of(world, 1e-4, 1e-4),
                                {.terrain_slope_sigma_rad = 1e-4, .slope_across_sigma_rad = 1e-4});
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_NEAR(shot->height_above_canopy_m.sigma / 10.0, 0.01, 0.0003);
}

// A gimbal measures against gravity, and the closed form hears of the slope too.
TEST(RefineShot, ASlopeWidensWhatTheGimbalSays) {
  AttitudePrior prior;
  prior.roll_rad = {0.01, 0.03, 1};
  const RefineOptions slopes{.terrain_slope_sigma_rad = 0.12, .slope_across_sigma_rad = 0.04};
  AttitudePrior wide = over_slope(prior, slopes);
  EXPECT_NEAR(wide.roll_rad.value, 0.01, 1e-15);
  EXPECT_NEAR(wide.roll_rad.sigma, 0.05, 1e-15);
  EXPECT_FALSE(wide.pitch_rad.usable());
  const double unknown_sigma_rad = over_slope({}, {.slope_across_sigma_rad = 0.0}).roll_rad.sigma;
  const Estimate unknown = over_slope({}, slopes).roll_rad;
  EXPECT_EQ(unknown.value, 0.0);
  EXPECT_NEAR(unknown.sigma, std::hypot(unknown_sigma_rad, 0.04), 1e-15);
  prior.pitch_rad = {-0.2, 0.05, 1};
  wide = over_slope(prior, slopes);
  EXPECT_NEAR(wide.pitch_rad.sigma, 0.13, 1e-15);
  EXPECT_NEAR(wide.roll_rad.sigma, 0.05, 1e-15);
}

// A sigma below 0 is an error however steep the ground may be, not a wider prior.
TEST(RefineShot, ASlopeHidesNoNegativeSigma) {
  const World world = low_vineyard();
  AttitudePrior prior = testing::prior_of(world, 0.01, 0.005);
  prior.roll_rad.sigma = -0.01;
  const auto shot = refine(world, testing::knowledge_of(world, 0.01), prior);
  ASSERT_FALSE(shot.ok());
  EXPECT_EQ(shot.error().code, "not_finite");
  EXPECT_EQ(shot.error().where, "roll_rad");
}

// Low over ground that slopes by 10 % along and across, steps between rows grow to the one side: started with
// the gimbal's roll, rows were taken for miscounted and the height for up to twice the true one.
TEST(RefineShot, ASteepSlopeDoesNotMisplaceRows) {
  const Camera camera = testing::thesis_camera();
  base::Random random(11);
  RefineOptions options;
  options.terrain_slope_sigma_rad = deg_to_rad(3.0);
  for (int i = 0; i < 16; ++i) {
    World world = low_vineyard();
    world.height_above_canopy_m = random.uniform(1.2, 1.5);
    world.cross_track_m = random.uniform(-1.0, 1.0);
    world.rounding_m = 0.3, world.softness_m = 0.03;
    const auto lines = testing::picture_of(world, camera, {.edge_sigma_px = 1.0}, random.bits());
    AttitudePrior prior = testing::prior_of(world, deg_to_rad(1.0), deg_to_rad(1.0));
    prior.pitch_rad.value += deg_to_rad(i % 4 < 2 ? -5.7 : 5.7);
    prior.roll_rad.value += deg_to_rad(i % 2 == 0 ? -5.7 : 5.7);
    FieldKnowledge field = testing::knowledge_of(world, 0.01);
    field.foliage_depth_m = field.base_width_ratio = {};
    const auto shot = refine_shot(lines, camera, field, prior, options);
    ASSERT_TRUE(shot.ok()) << i << " " << shot.error().message();
    EXPECT_NEAR(shot->height_above_canopy_m.value / world.height_above_canopy_m, 1.0, 0.04) << i;
    EXPECT_NEAR(shot->roll_rad.value, world.attitude.roll_rad, deg_to_rad(1.0)) << i;
  }
}

TEST(RefineShot, AMisplacedRowIsLeftOut) {
  const World world = low_vineyard();
  const Camera camera = testing::thesis_camera();
  World high = world;
  high.height_above_canopy_m = 3.3;
  rows::RowLines lines = testing::picture_of(high, camera, {.edge_sigma_px = 1.0});
  ASSERT_GE(lines.rows.size(), 5u);
  for (rows::RowSample& sample : lines.rows[1].samples) {
    sample.centre_px.x() += 30.0, sample.left_u_px += 30.0, sample.right_u_px += 30.0;
  }
  const auto shot =
      refine_shot(lines, camera, testing::knowledge_of(high, 0.01), testing::prior_of(high, 0.02, 0.01));
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_GE(shot->rows_left_out, 1);
  EXPECT_NEAR(shot->height_above_canopy_m.value, 3.3, 0.03 * 3.3);
}

// A detector that miscounts over a gap: the outermost rows carry the index of rows farther out.
TEST(RefineShot, RowsWithAWrongIndexAreLeftOut) {
  World world = low_vineyard();
  world.height_above_canopy_m = 3.3;
  rows::RowLines lines = testing::picture_of(world, testing::thesis_camera(), {.edge_sigma_px = 1.0});
  ASSERT_GE(lines.rows.size(), 7u);
  lines.rows.front().index -= 4;
  lines.rows[1].index -= 3;
  lines.rows.back().index += 4;
  const auto shot = refine_shot(lines, testing::thesis_camera(), testing::knowledge_of(world, 0.01),
                                testing::prior_of(world, 0.02, 0.01));
  ASSERT_TRUE(shot.ok()) << shot.error().message();
  EXPECT_EQ(shot->rows_left_out, 3);
  EXPECT_NEAR(shot->height_above_canopy_m.value, 3.3, 0.01 * 3.3);
}

TEST(RefineShot, DegenerateInputHasAName) {
  const World world = low_vineyard();
  const FieldKnowledge field = testing::knowledge_of(world, 0.01);
  const AttitudePrior prior = testing::prior_of(world, 0.01, 0.01);
  FieldKnowledge unknown = field;
  unknown.row_spacing_m = {};
  EXPECT_EQ(refine(world, unknown, prior).error().code, "no_spacing");
  FieldKnowledge infinite = field;
  infinite.row_spacing_m.value = HUGE_VAL;
  EXPECT_EQ(refine(world, infinite, prior).error().code, "not_finite");
  FieldKnowledge negative = field;
  negative.half_width_m.value = -0.6;
  EXPECT_EQ(refine(world, negative, prior).error().code, "bad_field");
  FieldKnowledge overlapping = field;  // a whole width for half of one doubled heights without a word
  overlapping.half_width_m.value = 0.7 * field.row_spacing_m.value;
  const auto overlap = refine(world, overlapping, prior);
  ASSERT_FALSE(overlap.ok());
  EXPECT_EQ(overlap.error().code, "bad_field");
  EXPECT_NE(overlap.error().message().find("at most half"), std::string::npos);
  AttitudePrior wrong = prior;
  wrong.pitch_rad = {deg_to_rad(-30.0), deg_to_rad(0.5), 1};
  const auto conflict = refine(world, field, wrong);
  ASSERT_FALSE(conflict.ok());
  EXPECT_EQ(conflict.error().code, "contradictory_priors");
  EXPECT_EQ(conflict.error().where, "pitch");
  AttitudePrior broken = prior;
  broken.pitch_rad.value = -HUGE_VAL;
  EXPECT_EQ(refine(world, field, broken).error().code, "not_finite");
}

}  // namespace
}  // namespace furrow::altitude
