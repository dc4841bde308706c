#include <gtest/gtest.h>
#include <cmath>

#include "field_generator.h"
#include "furrow/geom/angles.h"
#include "furrow/stats/agreement.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;
using testing::Noise;
using testing::World;

struct Trial {
  World world;
  FieldKnowledge field;
  AttitudePrior prior;
};

/// A flight height and pitch with its spread; everything else is drawn.
struct Case {
  const char* name;
  double low_m, high_m;  ///< above the canopy
  double pitch_deg;
  double correlation;
  bool leaf_against_leaf = true;
  double slope_across_deg = 0.0;  ///< one sigma of the ground's slope, which the gimbal knows nothing of
};

Estimate drawn(double truth, double sigma, base::Random& random) {
  return {truth + random.normal(0.0, sigma), sigma, 1};
}

/// A world, and knowledge of it that errs as it says.
Trial draw(const Case& c, base::Random& random) {
  Trial t;
  t.world.height_above_canopy_m = random.uniform(c.low_m, c.high_m);
  const double pitch = c.pitch_deg < -80.0 ? c.pitch_deg : c.pitch_deg + random.uniform(-2.0, 2.0);
  t.world.attitude = {deg_to_rad(random.uniform(-6.0, 6.0)), deg_to_rad(pitch),
                      c.pitch_deg < -80.0 ? 0.0 : deg_to_rad(random.normal(0.0, 0.5))};
  t.world.cross_track_m = random.uniform(-1.5, 1.5);
  t.world.half_width_m = random.uniform(0.45, 0.75);
  t.world.base_half_width_m = t.world.half_width_m * random.uniform(0.0, 1.0);
  t.world.foliage_depth_m = random.uniform(0.0, 1.7);
  t.world.rounding_m =
      kRoundingPerHalfWidth * t.world.half_width_m * std::exp(random.normal(0.0, kLogRoundingSigma));
  t.world.softness_m =
      kSoftnessPerHalfWidth * t.world.half_width_m * std::exp(random.normal(0.0, kLogSoftnessSigma));
  t.field.row_spacing_m = drawn(3.0, 0.03, random);
  t.field.half_width_m = drawn(t.world.half_width_m, 0.06, random);
  t.field.row_height_m = {1.7, 0.05, 1};
  t.field.outline_rise_m = {0.0, 0.0, 1};
  t.field.planting_sigma_m = 0.03;
  t.field.growth_sigma_m = 0.03;
  t.prior.pitch_rad = drawn(t.world.attitude.pitch_rad, deg_to_rad(1.0), random);
  t.prior.roll_rad = drawn(t.world.attitude.roll_rad, deg_to_rad(0.5), random);
  if (c.slope_across_deg > 0.0) t.prior.roll_rad.value += deg_to_rad(random.normal(0.0, c.slope_across_deg));
  return t;
}

class Sampling : public ::testing::TestWithParam<Case> {};

TEST_P(Sampling, TruthLiesInsideItsSigmasAsOftenAsClaimed) {
  constexpr int kShots = 300;  // 1800 over the six cases
  const Case c = GetParam();
  const Camera camera = testing::thesis_camera();
  base::Random random(20240611);
  std::vector<Estimate> height, pitch, heading, cross, spacing_height;
  std::vector<double> true_height, true_pitch, true_heading, true_cross;
  const Noise noise{.edge_sigma_px = 1.5,
                    .correlation = c.correlation,
                    .planting_sigma_m = 0.03,
                    .growth_sigma_m = 0.03,
                    .foot_anywhere = true,
                    .leaf_against_leaf = c.leaf_against_leaf};
  RefineOptions options;
  options.terrain_slope_sigma_rad = 0.0;
  options.slope_across_sigma_rad = deg_to_rad(c.slope_across_deg);
  double worst = 0.0, squares = 0.0;
  int answered = 0;
  for (int i = 0; i < kShots; ++i) {
    const Trial t = draw(c, random);
    const auto lines = testing::picture_of(t.world, camera, noise, random.bits());
    const auto shot = refine_shot(lines, camera, t.field, t.prior, options);
    if (!shot.ok()) continue;
    ++answered;
    height.push_back(shot->height_above_canopy_m), true_height.push_back(t.world.height_above_canopy_m);
    pitch.push_back(shot->pitch_rad), true_pitch.push_back(t.world.attitude.pitch_rad);
    heading.push_back(shot->yaw_rad), true_heading.push_back(t.world.attitude.yaw_rad);
    cross.push_back(shot->cross_track_m), true_cross.push_back(t.world.cross_track_m);
    const double relative = shot->height_above_canopy_m.value / t.world.height_above_canopy_m - 1.0;
    squares += relative * relative;
    worst = std::max(worst, std::abs(relative));
  }
  EXPECT_GE(answered, 0.98 * kShots);
  const auto check = [&](const char* what, const std::vector<Estimate>& estimates,
                         const std::vector<double>& truths) {
    const stats::Coverage coverage = stats::coverage(estimates, truths);
    // Five points, and twice what 300 shots scatter by chance. Two points more may be on the safe side: feet
    // of walls are claimed twice as wide as they are drawn (eq. 5.4), and near edges tell the yaw.
    EXPECT_GT(coverage.within_1_sigma, 0.683 - 0.05 - 2.0 * 0.027) << what;
    EXPECT_LT(coverage.within_1_sigma, 0.683 + 0.07 + 2.0 * 0.027) << what;
    EXPECT_NEAR(coverage.within_2_sigma, 0.954, 0.05) << what;
    std::printf("%-22s %-8s within 1 sigma %.3f, 2 sigma %.3f\n", c.name, what, coverage.within_1_sigma,
                coverage.within_2_sigma);
  };
  check("height", height, true_height);
  check("cross", cross, true_cross);
  if (c.pitch_deg > -80.0) check("pitch", pitch, true_pitch), check("yaw", heading, true_heading);
  std::printf("%-22s answered %d, relative height rms %.4f, worst %.4f\n", c.name, answered,
              std::sqrt(squares / answered), worst);
}

INSTANTIATE_TEST_SUITE_P(Heights, Sampling,
                         ::testing::Values(Case{"3 to 5 m, -13 deg", 1.3, 3.3, -13.0, 0.6},
                                           Case{"3 to 6 m, -20 deg", 1.3, 4.3, -20.0, 0.8},
                                           Case{"4 to 5 m, against soil", 2.0, 3.3, -13.0, 0.6, false},
                                           Case{"3 to 5 m, slope across", 1.3, 3.3, -13.0, 0.6, true, 3.0},
                                           Case{"8 m, -45 deg", 5.5, 7.0, -45.0, 0.6},
                                           Case{"30 m, nadir", 25.0, 32.0, -90.0, 0.6}));

/// What gives the closed form its metres.
struct Known {
  const char* name;
  bool spacing, half_width, height, is_alone;
  bool is_full = false;  ///< offset_from_rows, by the full model
};

class ClosedForm : public ::testing::TestWithParam<Known> {};

// Every length alone and together, and a row alone, from 1.3 to 7 m.
TEST_P(ClosedForm, TruthLiesInsideItsSigmasAsOftenAsClaimed) {
  const Known k = GetParam();
  const int shots = k.is_alone ? 300 : 150;
  const Camera camera = testing::thesis_camera();
  const Noise noise{.edge_sigma_px = 1.5,
                    .correlation = 0.6,
                    .planting_sigma_m = 0.03,
                    .growth_sigma_m = 0.03,
                    .foot_anywhere = true};
  base::Random random(20261127);
  std::vector<Estimate> cross, heading, to_neighbour;
  std::vector<double> true_cross, true_heading, true_neighbour;
  for (int i = 0; i < shots; ++i) {
    Trial t = draw(i % 2 == 0 ? Case{"", 1.3, 4.3, -20.0, 0.6} : Case{"", 4.0, 7.0, -45.0, 0.6}, random);
    const Estimate height = drawn(t.world.height_above_canopy_m, 0.15, random);
    t.world.rows_each_side = k.is_alone ? 0 : 4;
    if (!k.spacing) t.field.row_spacing_m = {};
    if (!k.half_width) t.field.half_width_m = {};
    const auto lines = testing::picture_of(t.world, camera, noise, random.bits());
    const Estimate known = k.height ? height : Estimate{};
    const auto closed = from_any_scale(rows_on_unit_plane(lines, camera).value(), t.field, t.prior, known);
    const auto full = offset_from_rows(lines, camera, t.field, t.prior, known);
    if (!closed.ok() || !closed->cross_track_m.usable() || !full.ok()) continue;
    const RowOffset shot = k.is_full
                               ? *full
                               : RowOffset{closed->cross_track_m, closed->yaw_rad, closed->row_spacing_m,
                                           closed->cross_track_spacing_covariance_m2};
    cross.push_back(shot.cross_track_m), true_cross.push_back(t.world.cross_track_m);
    heading.push_back(shot.yaw_rad), true_heading.push_back(t.world.attitude.yaw_rad);
    if (k.is_alone) continue;
    const double variance = std::pow(shot.cross_track_m.sigma, 2) +
                            9.0 * std::pow(shot.row_spacing_m.sigma, 2) +
                            6.0 * shot.cross_track_spacing_covariance_m2;
    to_neighbour.push_back(
        {shot.cross_track_m.value + 3.0 * shot.row_spacing_m.value, std::sqrt(variance), 1});
    true_neighbour.push_back(t.world.cross_track_m + 3.0 * t.world.spacing_m);
  }
  EXPECT_GE(static_cast<double>(cross.size()), 0.95 * shots);
  const auto check = [&](const char* what, const std::vector<Estimate>& estimates,
                         const std::vector<double>& truths, double too_wide = 0.0) {
    const stats::Coverage coverage = stats::coverage(estimates, truths);
    double squares = 0.0, sigmas = 0.0;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      squares += std::pow(estimates[i].value - truths[i], 2);
      sigmas += estimates[i].sigma;
    }
    const auto n = static_cast<double>(truths.size());
    std::printf("%-28s %-12s rmse %.4f, mean sigma %.4f, within 1 sigma %.3f, 2 sigma %.3f\n", k.name, what,
                std::sqrt(squares / n), sigmas / n, coverage.within_1_sigma, coverage.within_2_sigma);
    const double chance = 2.0 * std::sqrt(0.683 * 0.317 / n);
    EXPECT_GT(coverage.within_1_sigma, 0.683 - 0.05 - chance) << what;
    EXPECT_LT(coverage.within_1_sigma, 0.683 + 0.05 + chance + too_wide) << what;
    EXPECT_NEAR(coverage.within_2_sigma, 0.954, 0.05) << what;
  };
  check("cross", cross, true_cross);
  check("yaw", heading, true_heading, 0.05);
  if (!k.is_alone) check("third row", to_neighbour, true_neighbour);
}

INSTANTIATE_TEST_SUITE_P(Lengths, ClosedForm,
                         ::testing::Values(Known{"spacing", true, true, false, false},
                                           Known{"height", false, false, true, false},
                                           Known{"spacing and height", true, true, true, false},
                                           Known{"half width", false, true, false, false},
                                           Known{"full model, spacing", true, true, false, false, true},
                                           Known{"full model, and height", true, true, true, false, true},
                                           Known{"a row alone, height", false, false, true, true},
                                           Known{"a row alone, half width", false, true, false, true},
                                           Known{"a row alone, both", true, true, true, true}));

}  // namespace
}  // namespace furrow::altitude
