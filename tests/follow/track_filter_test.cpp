#include "furrow/follow/track_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/random.h"

namespace furrow::follow {
namespace {

using base::seconds_to_ns;

FilterOptions plain() {
  FilterOptions options;
  options.common_share = 0.0;
  return options;
}

TEST(TrackFilter, KnowsNothingBeforeTheFirstMeasurement) {
  const Filtered nothing = filter_step({}, 0, {}, {});
  EXPECT_FALSE(filtered_value(nothing, {}).has_value());
  EXPECT_FALSE(filtered_rate(nothing).usable());
}

TEST(TrackFilter, TheFirstMeasurementIsTakenAsItIs) {
  const Filtered first = filter_step({}, seconds_to_ns(5.0), {0.3, 0.1, 1}, {});
  EXPECT_EQ(first.intake, Intake::restarted);
  EXPECT_DOUBLE_EQ(filtered_value(first, {})->value, 0.3);
  EXPECT_NEAR(filtered_value(first, {})->sigma, 0.1, 1e-15);
}

// Two equal measurements at one place with no motion and nothing in common: the mean, sigma over the root of
// two.
TEST(TrackFilter, IndependentMeasurementsAverage) {
  FilterOptions still = plain();
  still.agility = 0.0, still.start_rate_sigma = 0.0;
  Filtered filtered = filter_step({}, 0, {0.2, 0.1, 1}, still);
  filtered = filter_step(filtered, seconds_to_ns(1.0), {0.4, 0.1, 1}, still);
  EXPECT_NEAR(filtered_value(filtered, still)->value, 0.3, 1e-12);
  EXPECT_NEAR(filtered_value(filtered, still)->sigma, 0.1 / std::sqrt(2.0), 1e-12);
}

TEST(TrackFilter, WhatPicturesHaveInCommonDoesNotAverageOut) {
  FilterOptions still;
  still.agility = 0.0, still.start_rate_sigma = 0.0, still.common_share = 0.5;
  Filtered filtered;
  for (int i = 0; i < 60; ++i)
    filtered = filter_step(filtered, seconds_to_ns(i / 60.0), {0.2, 0.1, 1}, still);
  EXPECT_GT(filtered_value(filtered, still)->sigma, 0.055);
}

TEST(TrackFilter, SigmaGrowsOverMissedPicturesThenHold) {
  const FilterOptions options = plain();
  Filtered filtered = filter_step({}, 0, {0.2, 0.05, 1}, options);
  double sigma = filtered_value(filtered, options)->sigma;
  for (int i = 1; i <= 9; ++i) {
    filtered = filter_step(filtered, seconds_to_ns(0.1 * i), {}, options);
    EXPECT_EQ(filtered.intake, Intake::nothing);
    const auto value = filtered_value(filtered, options);
    if (!value) break;
    EXPECT_GT(value->sigma, sigma);
    sigma = value->sigma;
  }
  filtered = filter_step(filtered, seconds_to_ns(1.2), {}, options);
  EXPECT_FALSE(filtered_value(filtered, options).has_value());
}

// By hand: 0.05² + 0.5² x 0.4² + 1² x 0.4³ / 3 for the value, 0.5² + 1² x 0.4 for its rate (eq. 1).
TEST(TrackFilter, PredictionByHand) {
  const FilterOptions options = plain();
  const Filtered later =
      filter_step(filter_step({}, 0, {0.2, 0.05, 1}, options), seconds_to_ns(0.4), {}, options);
  EXPECT_NEAR(later.covariance(0, 0), 0.0025 + 0.04 + 0.064 / 3.0, 1e-12);
  EXPECT_NEAR(later.covariance(1, 1), 0.25 + 0.4, 1e-12);
  EXPECT_NEAR(later.covariance(0, 1), 0.25 * 0.4 + 0.16 / 2.0, 1e-12);
}

TEST(TrackFilter, AnOutlierIsLeftOutAndASteadyNewPlaceIsTaken) {
  const FilterOptions options = plain();
  Filtered filtered;
  int i = 0;
  const auto step = [&](double value) {
    filtered = filter_step(filtered, seconds_to_ns(0.05 * i++), {value, 0.02, 1}, options);
    return filtered.intake;
  };
  for (int k = 0; k < 20; ++k) step(0.1);
  EXPECT_EQ(step(3.1), Intake::left_out);
  EXPECT_NEAR(filtered.state[0], 0.1, 0.02);
  EXPECT_EQ(step(0.1), Intake::used);
  for (int k = 1; k < options.restart_after; ++k) EXPECT_EQ(step(3.1), Intake::left_out);
  EXPECT_EQ(step(3.1), Intake::restarted);
  EXPECT_NEAR(filtered.state[0], 3.1, 1e-12);
}

TEST(TrackFilter, AnotherZeroMovesTheValueOnly) {
  const Filtered filtered = filter_step({}, 0, {0.2, 0.1, 1}, {});
  EXPECT_NEAR(filtered_value(shifted(filtered, 3.0), FilterOptions{})->value, 3.2, 1e-12);
  EXPECT_EQ(shifted(filtered, 3.0).covariance, filtered.covariance);
}

/// A flight whose rate is a random walk, seen with errors of which a part is common to neighbouring pictures,
/// with gaps.
struct Trial {
  int within_1 = 0, within_2 = 0, count = 0;
};

Trial fly(std::uint64_t seed, double rate_hz, const FilterOptions& options) {
  base::Random random(seed);
  const double dt = 1.0 / rate_hz, sigma = 0.06, kept = std::exp(-dt / options.common_time_s);
  double offset = random.normal(0.0, 0.3), rate = random.normal(0.0, options.start_rate_sigma);
  double common = random.normal();
  Filtered filtered;
  Trial trial;
  for (int i = 0; i < 200; ++i) {
    if (i > 0) {
      // The exact discrete form of white acceleration: two normals of the covariance of eq. 1.
      const double a = random.normal(), b = random.normal(), q = options.agility * options.agility;
      offset += dt * rate + std::sqrt(q * dt * dt * dt / 12.0) * b + std::sqrt(q * dt * dt * dt / 4.0) * a;
      rate += std::sqrt(q * dt) * a;
      common = kept * common + std::sqrt(1.0 - kept * kept) * random.normal();
    }
    const double error = sigma * (std::sqrt(options.common_share) * common +
                                  std::sqrt(1.0 - options.common_share) * random.normal());
    const bool is_seen = i < 80 || i % 7 != 0;
    filtered = filter_step(filtered, seconds_to_ns(i * dt),
                           is_seen ? Estimate{offset + error, sigma, 1} : Estimate{}, options);
    if (i % 20 != 19) continue;
    const double z = std::abs(filtered.state[0] - offset) / std::sqrt(filtered.covariance(0, 0));
    trial.within_1 += z < 1.0, trial.within_2 += z < 2.0, ++trial.count;
  }
  return trial;
}

// 600 flights of 10 looks each; looks of one flight hang together, so the bounds are for about 2000 free
// ones: 0.683 and 0.954 with 3 sigmas of 0.010 and 0.005.
TEST(TrackFilter, TheSigmaHolds) {
  for (const double rate_hz : {5.0, 60.0}) {
    const FilterOptions options;
    Trial all;
    for (std::uint64_t seed = 0; seed < 600; ++seed) {
      const Trial one = fly(seed, rate_hz, options);
      all.within_1 += one.within_1, all.within_2 += one.within_2, all.count += one.count;
    }
    EXPECT_NEAR(static_cast<double>(all.within_1) / all.count, 0.683, 0.03) << rate_hz;
    EXPECT_NEAR(static_cast<double>(all.within_2) / all.count, 0.954, 0.015) << rate_hz;
  }
}

}  // namespace
}  // namespace furrow::follow
