#include "furrow/altitude/fuse.h"

#include <gtest/gtest.h>
#include <cmath>

#include "furrow/base/random.h"
#include "furrow/stats/agreement.h"

namespace furrow::altitude {
namespace {

constexpr double kCanopy = 1.7;

struct Log {
  std::vector<HeightSample> samples;
  std::vector<double> truth;
  std::vector<Seen> seen;
};

/// A minute of flight, one sample a second: a barometer that drifts by half a metre, a downward sensor that
/// sees leaves or soil, GNSS with a bias, vision with gaps and some wrong heights.
Log fly(base::Random& random) {
  Log log;
  double baro_bias = 41.0, gnss_bias = -12.0;
  Seen seen = Seen::canopy;
  for (int i = 0; i < 90; ++i) {
    const double h = 2.3 + 0.8 * std::sin(0.07 * i);
    baro_bias += random.normal(0.0, 0.02);
    gnss_bias += random.normal(0.0, 0.02);
    if (random.uniform() < 0.15) seen = seen == Seen::canopy ? Seen::soil : Seen::canopy;
    HeightSample s;
    s.t_s = i;
    const double sigma = 0.02 * h;
    if (i % 3 != 2) s.vision_above_canopy_m = {h + random.normal(0.0, sigma), sigma, 1};
    if (i % 17 == 9) s.vision_above_canopy_m = {2.0 * h, sigma, 1};
    s.baro_height_m = h + baro_bias + random.normal(0.0, 0.15);
    s.vps_height_m = h + (seen == Seen::soil ? kCanopy : 0.0) + random.normal(0.0, 0.10);
    s.gnss_height_m = h + gnss_bias + random.normal(0.0, 0.5);
    log.samples.push_back(s);
    log.truth.push_back(h);
    log.seen.push_back(seen);
  }
  return log;
}

FuseOptions options() {
  FuseOptions o;
  o.row_height_m = {kCanopy, 0.03, 1};
  o.acceleration_sigma = 0.05;
  return o;
}

double rms(const FusedFlight& flight, const std::vector<double>& truth) {
  double squares = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    squares += std::pow(flight.heights[i].above_canopy_m.value - truth[i], 2);
  return std::sqrt(squares / static_cast<double>(truth.size()));
}

TEST(Fuse, IsBetterThanAnySourceAndItsSigmaHolds) {
  base::Random random(1);
  std::vector<Estimate> estimates;
  std::vector<double> truths;
  for (int flight = 0; flight < 15; ++flight) {
    const Log log = fly(random);
    const auto fused = fuse(log.samples, options());
    ASSERT_TRUE(fused.ok()) << fused.error().message();
    EXPECT_LT(rms(*fused, log.truth), 0.05);
    for (std::size_t i = 4; i < log.truth.size(); i += 10) {
      estimates.push_back(fused->heights[i].above_canopy_m);
      truths.push_back(log.truth[i]);
    }
  }
  const stats::Coverage coverage = stats::coverage(estimates, truths);
  EXPECT_NEAR(coverage.within_1_sigma, 0.683, 0.12);
  EXPECT_NEAR(coverage.within_2_sigma, 0.954, 0.06);
}

TEST(Fuse, TellsLeavesFromSoilAndGatesWrongVision) {
  base::Random random(2);
  const Log log = fly(random);
  const auto fused = fuse(log.samples, options());
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  int right = 0, gated = 0;
  for (std::size_t i = 0; i < log.seen.size(); ++i) {
    right += fused->heights[i].vps_seen == log.seen[i];
    if (i % 17 == 9) gated += fused->heights[i].left_out[static_cast<std::size_t>(HeightSource::vision)];
  }
  EXPECT_GE(right, 88);
  EXPECT_EQ(gated, 5);
  EXPECT_NEAR(fused->heights[50].above_ground_m.value, log.truth[50] + kCanopy, 0.15);
}

// Rows found on strips of grass lie lower by the rows' height in every shot. What a downward sensor changes
// by tells its surfaces all the same. Heights, barometer and sensor are those of a rendered flight, the
// sigmas the test's own.
TEST(Fuse, VisionWrongByTheRowsHeightDoesNotTurnSoilIntoLeaves) {
  struct Told {
    double vision_m, baro_m, vps_m, truth_m;
    Seen seen;
  };
  const std::vector<Told> told = {{2.57, 3.1, 3.0, 1.55, Seen::soil},   {2.26, 3.1, 3.0, 1.56, Seen::soil},
                                  {2.31, 3.1, 1.6, 1.59, Seen::canopy}, {2.68, 3.2, 1.6, 1.61, Seen::canopy},
                                  {3.54, 4.2, 2.6, 2.60, Seen::canopy}, {3.61, 4.3, 2.5, 2.55, Seen::canopy},
                                  {3.61, 4.1, 2.5, 2.49, Seen::canopy}, {3.39, 4.2, 2.4, 2.46, Seen::canopy},
                                  {4.42, 5.4, 4.9, 3.46, Seen::soil},   {4.54, 5.5, 5.0, 3.51, Seen::soil},
                                  {4.55, 5.3, 5.0, 3.55, Seen::soil},   {4.55, 5.3, 5.0, 3.57, Seen::soil}};
  std::vector<HeightSample> samples;
  for (const Told& t : told) {
    HeightSample s;
    s.t_s = 2.0 * static_cast<double>(samples.size());
    s.vision_above_canopy_m = {t.vision_m, 0.16, 1};
    s.vision_reach_m = 4.2 * t.vision_m;
    s.vision_shared = {{"outline", 0.14}};
    s.baro_height_m = t.baro_m;
    s.vps_height_m = t.vps_m;
    samples.push_back(s);
  }
  FuseOptions o;
  o.row_height_m = {1.42, 0.07, 1};
  const auto fused = fuse(samples, o);
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_EQ(fused->heights[i].vps_seen, told[i].seen) << i;
    EXPECT_NEAR(fused->heights[i].above_canopy_m.value, told[i].truth_m, 0.25) << i;
  }
}

// Each source switched off in turn: the answer stays, and vision carries most of it.
TEST(Fuse, AnswersWithEachSourceSwitchedOff) {
  base::Random random(3);
  const Log log = fly(random);
  for (const HeightSource source :
       {HeightSource::vision, HeightSource::baro, HeightSource::vps, HeightSource::gnss}) {
    FuseOptions o = options();
    o.use[static_cast<std::size_t>(source)] = false;
    const auto fused = fuse(log.samples, o);
    ASSERT_TRUE(fused.ok()) << source_name(source) << fused.error().message();
    EXPECT_LT(rms(*fused, log.truth), source == HeightSource::vision ? 0.25 : 0.06) << source_name(source);
    std::printf("without %-6s rms %.3f m\n", source_name(source).c_str(), rms(*fused, log.truth));
  }
}

/// So many samples alike, one a second.
std::vector<HeightSample> a_second_apart(std::size_t count, const HeightSample& each = {}) {
  std::vector<HeightSample> samples(count, each);
  for (std::size_t i = 0; i < count; ++i) samples[i].t_s = static_cast<double>(i);
  return samples;
}

/// An aircraft that hardly moves, so that only what its samples share can leave the height open: it does, by
/// `shared_m`, however many samples there are.
void expect_no_better_than(double shared_m, const std::vector<HeightSample>& samples, FuseOptions still) {
  still.acceleration_sigma = 0.001;
  const auto fused = fuse(samples, still);
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  const double sigma_m = fused->heights[samples.size() / 2].above_canopy_m.sigma;
  EXPECT_GT(sigma_m, shared_m);
  EXPECT_LT(sigma_m, shared_m + 0.005);
}

// A wrong spacing shifts every shot alike: a thousand shots are no better than the spacing.
TEST(Fuse, ErrorsCommonToTheFlightDoNotAverageOut) {
  base::Random random(4);
  auto samples = a_second_apart(200);
  for (HeightSample& sample : samples) {
    sample.vision_above_canopy_m = {2.06 + random.normal(0.0, 0.04), 0.05, 1};
    sample.vision_shared = {{"row_spacing", 0.03}};
  }
  FuseOptions o = options();
  o.shots_per_stretch = 1.0;
  expect_no_better_than(0.03, samples, o);
}

// Low and oblique, the outline stands 10 cm over the top, as the downward sensor tells; high and straight
// down no outline counts, and the spacing's error is another.
TEST(Fuse, CausesThatPicturesShareAreToldApart) {
  std::vector<HeightSample> samples(40);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    HeightSample& s = samples[i];
    const bool low = i < 20;
    s.t_s = static_cast<double>(low ? i : i + 60);
    s.vision_above_canopy_m = {low ? 2.1 : 10.0, 0.105, 1};
    s.vision_shared = {{"row_spacing", low ? 0.02 : 0.1}, {"outline", low ? 0.1 : 0.0}};
    if (low) s.vps_height_m = 2.0;
  }
  FuseOptions o = options();
  o.vps_canopy_sigma_m = 0.001;
  const auto fused = fuse(samples, o);
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  EXPECT_NEAR(fused->heights[10].above_canopy_m.value, 2.0, 0.02);
  EXPECT_NEAR(fused->heights[30].above_canopy_m.value, 10.0, 0.03);
  EXPECT_GT(fused->heights[30].above_canopy_m.sigma, 0.09);
}

// Leaves that a downward sensor hits may lie under the named top: a hundred readings are no better than that.
TEST(Fuse, TheLeavesLevelDoesNotAverageOut) {
  HeightSample each;
  each.vision_above_canopy_m = {2.0, 0.5, 1};
  each.vision_shared = {{"outline", 0.499}};
  each.vps_height_m = 2.0;
  FuseOptions o = options();
  o.vps_canopy_sigma_m = 0.05;
  expect_no_better_than(0.05, a_second_apart(100, each), o);
}

// A network's scale is wrong for the whole flight.
TEST(Fuse, ADepthMapsScaleDoesNotAverageOut) {
  HeightSample each;
  each.depth_above_canopy_m = {2.0, 0.22, 1};
  each.depth_shared = {{"depth_scale", 0.2}};
  FuseOptions o = options();
  o.depth_bias_sigma_m = 0.001;
  expect_no_better_than(0.2, a_second_apart(100, each), o);
}

// Neighbouring shots see the same plants: with r of them alike the mean of n is worth n / r.
TEST(Fuse, WhatLastsOverAStretchAveragesSlowly) {
  HeightSample each;
  each.vision_above_canopy_m = {2.0, 0.1, 1};
  const auto samples = a_second_apart(400, each);
  FuseOptions still = options();
  still.acceleration_sigma = 1e-6;
  const auto sigma = [&](double stretch) {
    still.shots_per_stretch = stretch;
    return fuse(samples, still)->heights[200].above_canopy_m.sigma;
  };
  // Half of the variance lasts: (1 + r) / 2 times the variance of independent shots.
  EXPECT_NEAR(sigma(4.0) / sigma(1.0), std::sqrt(2.5), 0.1);
}

// Level flight over a slope: the barometer stands still while the canopy rises by two row heights.
TEST(Fuse, TellsLeavesFromSoilOverASlopeWithoutVision) {
  base::Random random(5);
  auto samples = a_second_apart(80);
  std::vector<double> truth;
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    truth.push_back(6.0 - 0.04 * static_cast<double>(i));
    seen.push_back(i % 11 < 6 ? Seen::canopy : Seen::soil);
    samples[i].baro_height_m = 20.0 + random.normal(0.0, 0.1);
    samples[i].vps_height_m =
        truth.back() + (seen.back() == Seen::soil ? kCanopy : 0.0) + random.normal(0.0, 0.05);
  }
  const auto fused = fuse(samples, options());
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  EXPECT_FALSE(fused->surface_open);
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(fused->heights[i].vps_seen, seen[i]) << i;
  EXPECT_LT(rms(*fused, truth), 0.08);
}

// Never a jump: nobody knows whether these were leaves or soil, and the sigma says so.
TEST(Fuse, ADownwardSensorOnOneLevelLeavesTheSurfaceOpen) {
  base::Random random(6);
  auto samples = a_second_apart(30);
  for (HeightSample& sample : samples) sample.vps_height_m = 4.0 + random.normal(0.0, 0.05);
  const auto fused = fuse(samples, options());
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  EXPECT_TRUE(fused->surface_open);
  EXPECT_GT(fused->heights[10].above_canopy_m.sigma, kCanopy);
}

// A sensor twice as noisy as it claims is found out, and the sigma of the heights follows.
TEST(Fuse, NoiseIsWhatTheFlightShows) {
  base::Random random(7);
  auto samples = a_second_apart(300);
  for (HeightSample& sample : samples) sample.vision_above_canopy_m = {2.0 + random.normal(0.0, 0.2), 0.1, 1};
  FuseOptions still = options();
  still.acceleration_sigma = 0.01;
  still.shots_per_stretch = 1.0;
  const auto fused = fuse(samples, still);
  ASSERT_TRUE(fused.ok()) << fused.error().message();
  EXPECT_NEAR(fused->noise_scale[static_cast<std::size_t>(HeightSource::vision)], 2.0, 0.2);
}

/// Forty shots over ground that waves under the rows ahead: vision errs by curvature x reach² / 2, which
/// lasts over some shots; a downward sensor and a barometer know better.
std::vector<HeightSample> over_waves(double curvature_sigma, std::vector<double>& truth,
                                     base::Random& random) {
  constexpr double kReach = 8.0, kKept = 0.6;
  std::vector<HeightSample> samples(40);
  double curvature = random.normal(0.0, curvature_sigma);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double h = 2.3 + 0.1 * std::sin(0.3 * static_cast<double>(i));
    curvature = kKept * curvature + random.normal(0.0, curvature_sigma * std::sqrt(1.0 - kKept * kKept));
    samples[i].t_s = 2.0 * static_cast<double>(i);
    samples[i].vision_above_canopy_m = {h + 0.5 * curvature * kReach * kReach + random.normal(0.0, 0.04),
                                        0.04, 1};
    samples[i].vision_reach_m = kReach;
    samples[i].vps_height_m = h + random.normal(0.0, 0.10);
    samples[i].baro_height_m = h + 20.0 + random.normal(0.0, 0.15);
    truth.push_back(h);
  }
  return samples;
}

TEST(Fuse, TheGroundsCurvatureIsSeenWhereOtherSourcesDenyVision) {
  base::Random random(8);
  std::vector<Estimate> estimates;
  std::vector<double> truths;
  int found = 0;
  for (int flight = 0; flight < 20; ++flight) {
    std::vector<double> truth;
    const auto samples = over_waves(0.006, truth, random);  // 0.19 m
    const auto fused = fuse(samples, options());
    ASSERT_TRUE(fused.ok()) << fused.error().message();
    found += fused->ground_curvature_per_m >= 0.002 && fused->ground_curvature_per_m <= 0.016;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      estimates.push_back(fused->heights[i].above_canopy_m);
      truths.push_back(truth[i]);
    }
  }
  EXPECT_GE(found, 18);
  const stats::Coverage coverage = stats::coverage(estimates, truths);
  std::printf("over waves within 1 sigma %.3f, 2 sigma %.3f\n", coverage.within_1_sigma,
              coverage.within_2_sigma);
  EXPECT_NEAR(coverage.within_1_sigma, 0.683, 0.08);
  EXPECT_NEAR(coverage.within_2_sigma, 0.954, 0.04);
}

TEST(Fuse, LevelGroundStaysLevel) {
  base::Random random(9);
  int curved = 0;
  for (int flight = 0; flight < 40; ++flight) {
    std::vector<double> truth;
    const auto samples = over_waves(0.0, truth, random);
    curved += fuse(samples, options())->ground_curvature_per_m > 0.0;
  }
  EXPECT_LE(curved, 4);  // Akaike's 2 lets through some 8 %
}

TEST(Fuse, NamesWhatCannotBeAnswered) {
  EXPECT_EQ(fuse({}, options()).error().code, "no_samples");
  HeightSample a, b;
  a.baro_height_m = b.baro_height_m = 10.0;
  b.t_s = 1.0;
  EXPECT_EQ(fuse({a, b}, options()).error().code, "no_absolute_height");
  a.vps_height_m = 3.0;
  EXPECT_EQ(fuse({a, b}, {}).error().code, "no_row_height");
  EXPECT_TRUE(fuse({a, b}, options()).ok());
  b.t_s = 0.0;
  EXPECT_EQ(fuse({a, b}, options()).error().code, "times_not_increasing");
  b.t_s = std::nan("");
  EXPECT_EQ(fuse({a, b}, options()).error().code, "times_not_increasing");
  for (double FuseOptions::*sigma : {&FuseOptions::baro_sigma_m, &FuseOptions::gate_sigmas}) {
    FuseOptions bad = options();
    bad.*sigma = 0.0;
    EXPECT_EQ(fuse({a}, bad).error().code, "not_finite");
  }
  for (double FuseOptions::*sigma :
       {&FuseOptions::vps_canopy_sigma_m, &FuseOptions::baro_drift_m_per_sqrt_s}) {
    FuseOptions may_be_none = options();
    may_be_none.*sigma = 0.0;
    EXPECT_TRUE(fuse({a}, may_be_none).ok());
    may_be_none.*sigma = std::nan("");
    EXPECT_EQ(fuse({a}, may_be_none).error().code, "not_finite");
  }
}

// Such readings had made every height of the flight NaN, with a sigma of 0.
TEST(Fuse, NamesThePictureThatCannotBeWeighed) {
  HeightSample good;
  good.vision_above_canopy_m = {2.0, 0.1, 1};
  std::vector<HeightSample> bad(4, good);
  bad[0].vision_above_canopy_m.sigma = 0.0;
  bad[1].depth_above_canopy_m = {2.0, 0.0, 1};
  bad[2].vision_shared = {{"outline", std::nan("")}};
  bad[3].vision_reach_m = std::nan("");
  for (HeightSample& second : bad) {
    second.t_s = 1.0;
    const auto fused = fuse({good, second}, options());
    ASSERT_FALSE(fused.ok());
    EXPECT_EQ(fused.error().code, "not_finite");
    EXPECT_EQ(fused.error().where, "sample 2");
  }
  // What a silent picture carries along does no harm.
  for (const std::size_t i : {2, 3}) {
    bad[i].vision_above_canopy_m = {};
    EXPECT_TRUE(fuse({good, bad[i]}, options()).ok());
  }
}

}  // namespace
}  // namespace furrow::altitude
