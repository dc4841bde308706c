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
  field.rounding_m = field.outline_rise_m = {0.0, 0.0, 1};  // prisms end where they end
  return field;
}

struct PlannedCase {
  const char* name;
  double height_m, pitch_deg, heading_deg, cross_track_m;
  bool leaf_against_leaf;
};

class PlanAgainstShots : public ::testing::TestWithParam<PlannedCase> {};

constexpr double kEdgeSigmaPx = 2.0, kEdgeCorrelation = 0.6;

/// A shot of the independent generator, measured with knowledge that errs as it says; the error of its
/// height.
double sampled_error(const PlannedCase& c, const PlanOptions& options, base::Random& random) {
  World world;
  world.height_above_canopy_m = c.height_m;
  const double roll = c.pitch_deg < -80.0 ? 0.0 : random.normal(0.0, options.roll_sigma_rad);
  world.attitude = {deg_to_rad(c.heading_deg), deg_to_rad(c.pitch_deg), roll};
  world.cross_track_m = c.cross_track_m;
  world.base_half_width_m = 0.3;
  world.foliage_depth_m = 1.0 + random.normal(0.0, 0.1);
  world.rows_each_side = 12;
  FieldKnowledge known = vineyard();
  known.row_spacing_m.value += random.normal(0.0, 0.03);
  known.half_width_m.value += random.normal(0.0, 0.06);
  const Noise noise{.edge_sigma_px = kEdgeSigmaPx,
                    .correlation = kEdgeCorrelation,
                    .planting_sigma_m = 0.03,
                    .growth_sigma_m = 0.03,
                    .leaf_against_leaf = c.leaf_against_leaf};
  const AttitudePrior prior{{world.attitude.pitch_rad, options.pitch_sigma_rad, 1},
                            {0.0, options.roll_sigma_rad, 1}};
  const auto shot = refine_shot(testing::picture_of(world, testing::thesis_camera(), noise, random.bits()),
                                testing::thesis_camera(), known, prior);
  EXPECT_TRUE(shot.ok()) << shot.error().message();
  return shot.ok() ? shot->height_above_canopy_m.value - c.height_m : 0.0;
}

// The plan's sigma must be what shots of the independent generator scatter by, to a third.
TEST_P(PlanAgainstShots, SigmaIsWhatShotsWillScatterBy) {
  const PlannedCase c = GetParam();
  PlanOptions options;
  options.edge_sigma_px = kEdgeSigmaPx;
  options.edge_correlation = kEdgeCorrelation;
  options.leaf_against_leaf = c.leaf_against_leaf;
  options.narrowest_px = 4.0;
  const PlannedPose pose{c.height_m, deg_to_rad(c.pitch_deg), deg_to_rad(c.heading_deg), c.cross_track_m};
  const auto plan = plan_shot(testing::thesis_camera(), pose, vineyard(), options);
  ASSERT_TRUE(plan.ok()) << plan.error().message();
  base::Random random(11);
  double squares = 0.0;
  constexpr int kShots = 60;  // they know a scatter to 9 %
  for (int i = 0; i < kShots; ++i) squares += std::pow(sampled_error(c, options, random), 2);
  const double sampled = std::sqrt(squares / kShots);
  std::printf("%-26s planned %.4f m, sampled %.4f m, ratio %.2f\n", c.name, plan->height_above_canopy_m.sigma,
              sampled, sampled / plan->height_above_canopy_m.sigma);
  EXPECT_NEAR(sampled / plan->height_above_canopy_m.sigma, 1.0, 1.0 / 3.0);
}

INSTANTIATE_TEST_SUITE_P(Poses, PlanAgainstShots,
                         ::testing::Values(PlannedCase{"3 m above canopy, -20 deg", 3.0, -20.0, 2.0, 0.2,
                                                       true},
                                           PlannedCase{"2.3 m, -13.8 deg, soil", 2.3, -13.8, 1.0, 0.1, false},
                                           PlannedCase{"3.3 m, -13.8 deg, soil", 3.3, -13.8, 1.0, 0.1, false},
                                           PlannedCase{"6.3 m, -45 deg, soil", 6.3, -45.0, 2.0, 0.3, false},
                                           PlannedCase{"28.3 m, nadir, soil", 28.3, -90.0, 2.0, 0.3, false}));

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
  EXPECT_EQ(plan_shot(camera, {1e300, -0.3, 0, 0}, vineyard()).error().code, "bad_pose");
  EXPECT_EQ(plan_shot(camera, {2.0, 0.3, 0, 0}, vineyard()).error().code, "bad_pose");
  EXPECT_EQ(plan_shot(camera, {std::nan(""), -0.3, 0, 0}, vineyard()).error().code, "bad_pose");
}

}  // namespace
}  // namespace furrow::altitude
