#include "furrow/altitude/plan.h"

#include <gtest/gtest.h>
#include <cmath>

#include "field_generator.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;
using testing::Noise;
using testing::World;

FieldKnowledge vineyard() {
  FieldKnowledge field;
  field.row_spacing_m = {3.0, 0.03, 1};
  field.half_width_m = {0.6, 0.06, 1};
  field.row_height_m = {1.7, 0.05, 1};
  field.foliage_depth_m = {1.0, 0.1, 1};
  field.base_width_ratio = {0.5, 0.1, 1};
  field.planting_sigma_m = 0.03;
  field.growth_sigma_m = 0.03;
  return field;
}

// The plan's sigma must be what shots of the independent generator scatter by.
TEST(Plan, SigmaIsWhatShotsWillScatterBy) {
  const FieldKnowledge field = vineyard();
  PlanOptions options;
  options.edge_sigma_px = 2.0;
  options.edge_correlation = 0.6;
  options.leaf_against_leaf = true;
  options.narrowest_px = 4.0;
  const PlannedPose pose{3.0, deg_to_rad(-20.0), deg_to_rad(2.0), 0.2};
  const auto plan = plan_shot(testing::thesis_camera(), pose, field, options);
  ASSERT_TRUE(plan.ok()) << plan.error().message();
  base::Random random(11);
  double squares = 0.0;
  constexpr int kShots = 60;
  for (int i = 0; i < kShots; ++i) {
    World world;
    world.height_above_canopy_m = 3.0;
    world.attitude = {deg_to_rad(2.0), deg_to_rad(-20.0), random.normal(0.0, options.roll_sigma_rad)};
    world.cross_track_m = 0.2;
    world.base_half_width_m = 0.3;
    world.foliage_depth_m = 1.0 + random.normal(0.0, 0.1);
    world.rows_each_side = 20;
    FieldKnowledge known = field;
    known.row_spacing_m.value += random.normal(0.0, 0.03);
    known.half_width_m.value += random.normal(0.0, 0.06);
    const Noise noise{
        .edge_sigma_px = 2.0, .correlation = 0.6, .planting_sigma_m = 0.03, .growth_sigma_m = 0.03};
    const auto shot = refine_shot(
        testing::picture_of(world, testing::thesis_camera(), noise, random.bits()), testing::thesis_camera(),
        known, {{world.attitude.pitch_rad, options.pitch_sigma_rad, 1}, {0.0, options.roll_sigma_rad, 1}});
    ASSERT_TRUE(shot.ok()) << shot.error().message();
    squares += std::pow(shot->height_above_canopy_m.value - 3.0, 2);
  }
  // 60 shots know a scatter to 9 %.
  EXPECT_NEAR(std::sqrt(squares / kShots) / plan->height_above_canopy_m.sigma, 1.0, 0.3);
}

TEST(Plan, ASteeperOrHigherViewThanThreeMetresAtTheHorizonIsBetter) {
  const PlannedPose low{1.3, deg_to_rad(-12.4), 0.0, 0.1};
  FieldKnowledge field = vineyard();
  field.foliage_depth_m = {};
  field.base_width_ratio = {};
  const PlanAdvice advice = plan_advice(testing::thesis_camera(), low, field);
  ASSERT_TRUE(advice.best_pitch);
  ASSERT_TRUE(advice.best_height);
  EXPECT_GE(advice.by_pitch.size(), 10u);
  EXPECT_GT(advice.best_height->pose.height_above_canopy_m, 1.3);
  const auto plan = plan_shot(testing::thesis_camera(), low, field);
  ASSERT_TRUE(plan.ok()) << plan.error().message();
  EXPECT_LT(advice.best_height->height_above_canopy_m.sigma / advice.best_height->height_above_canopy_m.value,
            plan->height_above_canopy_m.sigma / 1.3);
}

TEST(Plan, RefusesPosesThatCannotBeFlown) {
  const Camera camera = testing::thesis_camera();
  EXPECT_EQ(plan_shot(camera, {0.0, -0.3, 0, 0}, vineyard()).error().code, "bad_pose");
  EXPECT_EQ(plan_shot(camera, {2.0, 0.3, 0, 0}, vineyard()).error().code, "bad_pose");
  EXPECT_EQ(plan_shot(camera, {std::nan(""), -0.3, 0, 0}, vineyard()).error().code, "bad_pose");
}

}  // namespace
}  // namespace furrow::altitude
