// Fusion on the simulator's own logs: drifting and gusty barometer, a downward sensor that jumps between
// leaves and soil, late rows and rows that are missing. Vision is drawn, so that many flights can be judged.
#include "project/fusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "furrow/base/random.h"
#include "furrow/sim/simulate.h"
#include "furrow/sim/world.h"
#include "furrow/stats/agreement.h"
#include "sim/airdata.h"

namespace furrow::project {
namespace {

struct Flown {
  sim::Scene scene;
  std::vector<sim::ShotTruth> truth;
  sync::Located located;
  std::vector<VisionHeight> vision;
  double rise_m = 0.0;  ///< of the outline over the named top, in truth
  altitude::FieldKnowledge field;
  std::vector<audit::ShotRecord> records;
};

/// How far what is called the top lies from the outline, and from the leaves below the aircraft; one sigma.
constexpr double kTop_m = 0.05;
/// What the pictures' heights take the outline's rise for.
constexpr double kTaken_m = 0.10;

struct DrawnVision {
  std::vector<VisionHeight> heights;
  double rise_m = 0.0;
};

/// Heights as pictures give them: a spacing that is 1 % wrong and an outline that stands over the named top,
/// for the whole flight; 2 % and 2 cm of each shot's own, most of which lasts over four shots; some shots
/// without rows, some far off.
DrawnVision draw_vision(const std::vector<sim::ShotTruth>& truth, base::Random& random) {
  constexpr double kSpacingShare = 0.01, kLasting = 0.8, kKept = 0.6;
  const double spacing = random.normal(), outline = random.normal();
  double plants = random.normal();
  std::vector<VisionHeight> vision(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const double height = truth[i].height_above_canopy_m, own = 0.02 * height + 0.02;
    const double by_spacing = kSpacingShare * height;
    plants = kKept * plants + std::sqrt(1.0 - kKept * kKept) * random.normal();
    const double error = spacing * by_spacing + outline * kTop_m +
                         own * (std::sqrt(kLasting) * plants + std::sqrt(1.0 - kLasting) * random.normal());
    if (random.uniform() < 0.08) continue;
    const double off = random.uniform() < 0.04 ? 0.4 * height : 0.0;
    vision[i] = {{height + error + off, std::hypot(own, by_spacing, kTop_m), 1},
                 {{"row_spacing", by_spacing}, {"outline", kTop_m}},
                 0.0,
                 {kTaken_m, kTop_m, 1}};
  }
  return {vision, kTaken_m - outline * kTop_m};
}

/// Leaves that a downward sensor hits above or below the named top.
void shift_leaves(sync::Located& located, const std::vector<sim::ShotTruth>& truth, base::Random& random) {
  const double shift = random.normal(0.0, kTop_m);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    double& vps = located.poses[i].state.height_vps_m;
    const double above_leaves = vps - truth[i].height_above_canopy_m;
    const double above_soil = vps - truth[i].height_above_ground_m;
    if (std::abs(above_leaves) < std::abs(above_soil)) vps += shift;
  }
}

/// A receiver's height above the ellipsoid: constant bias, slow error.
void add_gnss(sync::Located& located, const std::vector<sim::ShotTruth>& truth, base::Random& random) {
  const double bias = random.normal(230.0, 3.0);
  double slow = random.normal(0.0, 0.4);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    constexpr double kKept = 0.9;  // from shot to shot, 2 s apart
    slow = kKept * slow + 0.4 * std::sqrt(1.0 - kKept * kKept) * random.normal();
    located.poses[i].state.height_ellipsoid_m = truth[i].x_in_world.z() + bias + slow;
  }
}

Flown fly(sim::Scene scene, std::uint64_t seed, bool gnss = false) {
  scene.seed = seed;
  base::Random random(seed);
  Flown flown{scene, sim::true_shots(scene), {}, {}, 0.0, {}, {}};
  const auto track = telemetry::parse_track(sim::airdata_csv(scene), "airdata.csv");
  EXPECT_TRUE(track.ok());
  std::vector<telemetry::Shot> shots;
  for (const sim::ShotTruth& truth : flown.truth) {
    shots.emplace_back().shot_id = truth.shot_id;
    auto& record = flown.records.emplace_back();
    record.shot_id = truth.shot_id;
    record.truth_above_canopy_m = truth.height_above_canopy_m;
  }
  auto located = sync::locate_shots(shots, *track);
  if (!located.ok()) ADD_FAILURE() << seed << located.error().message();
  flown.located = std::move(*located);
  DrawnVision drawn = draw_vision(flown.truth, random);
  flown.vision = std::move(drawn.heights);
  flown.rise_m = drawn.rise_m;
  shift_leaves(flown.located, flown.truth, random);
  if (gnss) add_gnss(flown.located, flown.truth, random);
  const double height = scene.field.row_height_m;
  flown.field.row_height_m = {height + random.normal(0.0, 0.05 * height), 0.05 * height, 1};
  return flown;
}

/// Estimates and truths of many flights, trial by trial.
struct Pool {
  std::vector<Estimate> heights;
  std::vector<double> truths;
};

std::map<std::string, Pool> pool_flights(const sim::Scene& scene, int flights, bool gnss) {
  std::map<std::string, Pool> pools;
  for (int seed = 1; seed <= flights; ++seed) {
    const Flown flown = fly(scene, static_cast<std::uint64_t>(seed), gnss);
    const auto fusion = fuse_flight(flown.located, flown.vision, flown.field);
    EXPECT_TRUE(fusion.ok()) << fusion.error().message();
    const auto add = [&](const std::string& name, const altitude::FusedFlight& fused) {
      for (std::size_t i = 0; i < fusion->shots.size(); ++i) {
        pools[name].heights.push_back(fused.heights[i].above_canopy_m);
        pools[name].truths.push_back(flown.truth[fusion->shots[i]].height_above_canopy_m);
      }
    };
    add("all", fusion->fused);
    for (const audit::FusionTrial& trial : fusion->without) {
      if (trial.fused.ok()) add("without " + altitude::source_name(trial.off), *trial.fused);
    }
  }
  return pools;
}

sim::Scene bad_log() {
  sim::Scene scene = sim::demo_scene();
  scene.log.latency_s = 0.3;
  scene.log.dropout_probability = 0.04;
  scene.log.baro_gust_m = 0.2;
  scene.log.baro_drift_m = 1.0;
  return scene;
}

sim::Scene climb() {
  sim::Scene scene = sim::demo_scene();
  scene.flight.legs.resize(1);
  scene.flight.legs[0].end_height_above_ground_m = 6.0;
  scene.flight.legs[0].shots = 24;
  return scene;
}

sim::Scene hills() {
  sim::Scene scene = bad_log();
  scene.field.undulation_m = 0.25;
  scene.field.undulation_wavelength_m = 45.0;
  scene.field.slope_along = 0.05;
  return scene;
}

struct Case {
  const char* name;
  sim::Scene scene;
  bool gnss;
};

class FusionOfSimulatedLogs : public ::testing::TestWithParam<int> {};

std::vector<Case> cases() {
  return {{"demo", sim::demo_scene(), false}, {"bad log", bad_log(), false},     {"climb", climb(), false},
          {"hills", hills(), false},          {"demo", sim::demo_scene(), true}, {"hills", hills(), true}};
}

TEST_P(FusionOfSimulatedLogs, SigmaHoldsWithAllSourcesAndWithoutVision) {
  const Case c = cases()[static_cast<std::size_t>(GetParam())];
  for (const auto& [trial, pool] : pool_flights(c.scene, 60, c.gnss)) {
    const auto line = audit::compare(trial, pool.heights, pool.truths);
    std::printf("%-8s %-5s %-15s %4d shots, RMSE %.3f m, bias %+.3f m, in 1 sigma %.2f, in 2 sigma %.2f\n",
                c.name, c.gnss ? "GNSS" : "", trial.c_str(), line.shots, line.rmse_m, line.mean_error_m,
                line.within_1_sigma, line.within_2_sigma);
    // The downward sensor is better than it claims, so sigmas may be wide; narrow they must not be.
    EXPECT_GE(line.within_1_sigma, 0.633) << trial;
    EXPECT_GE(line.within_2_sigma, trial == "all" ? 0.94 : 0.89) << trial;
    if (trial != "all") continue;
    EXPECT_LE(line.within_1_sigma, 0.79);
    EXPECT_LE(line.rmse_m, 0.09);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, FusionOfSimulatedLogs, ::testing::Range(0, 6));

// A downward sensor that sees leaves and soil tells how far the outline stands over the named top.
TEST(FuseFlight, TellsTheRiseOfTheOutlineAndItsSigmaHolds) {
  std::vector<Estimate> told;
  std::vector<double> truths;
  double sigma_m = 0.0;
  constexpr int kFlights = 120;
  for (std::uint64_t seed = 1; seed <= kFlights; ++seed) {
    const Flown flown = fly(sim::demo_scene(), seed);
    const auto fusion = fuse_flight(flown.located, flown.vision, flown.field);
    ASSERT_TRUE(fusion.ok()) << fusion.error().message();
    EXPECT_DOUBLE_EQ(fusion->rise_taken_m.value, kTaken_m);
    told.push_back(fusion->rise_told_m);
    truths.push_back(flown.rise_m);
    sigma_m += fusion->rise_told_m.sigma / kFlights;
  }
  const stats::Coverage coverage = stats::coverage(told, truths);
  std::printf("rise told to %.3f m, taken to %.3f m; in 1 sigma %.2f, in 2 sigma %.2f\n", sigma_m, kTop_m,
              coverage.within_1_sigma, coverage.within_2_sigma);
  EXPECT_LT(sigma_m, 0.9 * kTop_m);
  EXPECT_NEAR(coverage.within_1_sigma, 0.68, 0.12);  // 3 sigma of 120 draws
  EXPECT_GE(coverage.within_2_sigma, 0.89);
}

// Rows lower than a few sigmas of what words leave open: a sensor's leaves may pass for soil. And a farm that
// told the rise is not told it back.
TEST(FuseFlight, SaysNothingOfTheRiseOverLowRowsOrWhereTheFarmToldIt) {
  Flown flown = fly(sim::demo_scene(), 1);
  const auto usable = [&flown](const altitude::FieldKnowledge& field) {
    const auto fusion = fuse_flight(flown.located, flown.vision, field);
    return fusion.ok() && fusion->rise_told_m.usable();
  };
  EXPECT_TRUE(usable(flown.field));
  altitude::FieldKnowledge told = flown.field, low = flown.field;
  told.outline_rise_m = {0.1, 0.02, 1};
  EXPECT_FALSE(usable(told));
  low.row_height_m.sigma = 0.5 * low.row_height_m.value;
  EXPECT_FALSE(usable(low));
  for (sync::ShotPose& pose : flown.located.poses) pose.state.height_vps_m = std::nan("");
  EXPECT_FALSE(usable(flown.field));
}

TEST(FuseFlight, WordsOfTheRiseSayWhatToWrite) {
  audit::FlightFusion fusion;
  fusion.rise_taken_m = {0.13, 0.17, 9};
  fusion.rise_told_m = {0.263, 0.074, 9};
  const std::string words = audit::rise_words(fusion);
  EXPECT_NE(words.find("0.26 +- 0.07 m"), std::string::npos) << words;
  EXPECT_NE(words.find("outline_rise_m: 0.26 and outline_rise_sigma_m: 0.07"), std::string::npos) << words;
  fusion.rise_told_m.sigma = 0.13;  // adds little
  EXPECT_EQ(audit::rise_words(fusion), "");
}

TEST(FuseFlight, SaysNothingOfTheRiseWithoutPicturesThatTookOne) {
  const Flown flown = fly(sim::demo_scene(), 1);
  std::vector<VisionHeight> without = flown.vision;
  for (VisionHeight& height : without) height.outline_rise_m = {};
  const auto fusion = fuse_flight(flown.located, without, flown.field);
  ASSERT_TRUE(fusion.ok()) << fusion.error().message();
  EXPECT_FALSE(fusion->rise_told_m.usable());
  EXPECT_EQ(audit::rise_words(*fusion), "");
}

TEST(FuseFlight, SaysWhyThereIsNothingToFuse) {
  sync::Located located;
  located.poses.resize(2);
  EXPECT_EQ(fuse_flight(located, std::vector<VisionHeight>(2), {}).error().code, "no_times");
  for (int i = 0; i < 2; ++i) located.poses[static_cast<std::size_t>(i)].state.t_utc_ns = 0;
  EXPECT_EQ(fuse_flight(located, std::vector<VisionHeight>(2), {}).error().code, "no_absolute_height");
  // Two shots in one second of a clock are two samples.
  const std::vector<VisionHeight> vision(2, {{2.0, 0.1, 1}, {{"row_spacing", 0.02}}});
  const auto fusion = fuse_flight(located, vision, {});
  ASSERT_TRUE(fusion.ok()) << fusion.error().message();
  EXPECT_EQ(fusion->samples.size(), 2U);
  EXPECT_EQ(fusion->without.size(), 1U);  // vision alone spoke
  EXPECT_FALSE(fusion->without[0].fused.ok());
  EXPECT_EQ(audit::trials_table(*fusion).rows[1][4], "only barometer or GNSS, whose zero is not known");
}

// Leaves over which a downward sensor hovers lie as far from the named top as rows of some width let them;
// who does not know the width knows the height no better.
TEST(FuseFlight, KnowsNoMoreOfTheLeavesOverRowsOfUnknownWidth) {
  sync::Located located;
  located.poses.resize(30);
  for (std::size_t i = 0; i < located.poses.size(); ++i) {
    located.poses[i].state.t_utc_ns = static_cast<std::int64_t>(i) * 1'000'000'000;
    located.poses[i].state.height_vps_m = 2.0;
  }
  const std::vector<VisionHeight> vision(located.poses.size(), {{2.0, 0.5, 1}, {{"row_spacing", 0.49}}});
  const auto sigma_m = [&](const altitude::FieldKnowledge& field) {
    const auto fusion = fuse_flight(located, vision, field);
    EXPECT_TRUE(fusion.ok()) << fusion.error().message();
    return fusion.ok() ? fusion->fused.heights[15].above_canopy_m.sigma : std::nan("");
  };
  altitude::FieldKnowledge narrow, wide;
  narrow.half_width_m = {0.05, 0.01, 1};
  wide.half_width_m = {2.0, 0.1, 1};
  EXPECT_LT(sigma_m(narrow), sigma_m(wide));
  EXPECT_GE(sigma_m({}), sigma_m(wide));
  EXPECT_LT(sigma_m({}), 0.2);
}

TEST(FusionTable, HasEverySourcesReadingResidualAndUse) {
  const Flown flown = fly(sim::demo_scene(), 3);
  const auto fusion = fuse_flight(flown.located, flown.vision, flown.field);
  ASSERT_TRUE(fusion.ok()) << fusion.error().message();
  const auto table = audit::fusion_table(flown.records, *fusion);
  ASSERT_EQ(table.rows.size(), flown.truth.size());
  EXPECT_FALSE(table.column("gnss_m"));
  const auto cell = [&](std::size_t row, const char* name) {
    return table.rows[row][table.column(name).value()];
  };
  EXPECT_EQ(cell(0, "shot_id"), "shot-0001");
  EXPECT_FALSE(cell(0, "baro_residual_m").empty());
  int soil = 0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    EXPECT_EQ(cell(i, "vision_use").empty(), !flown.vision[i].above_canopy_m.usable());
    soil += cell(i, "vps_use") == "used, saw soil";
  }
  EXPECT_GT(soil, 5);
  const auto lines = audit::compare_fusion(flown.records, *fusion);
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[1].method, "fused without vision");
}

}  // namespace
}  // namespace furrow::project
