#include "furrow/sync/clock_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/random.h"

namespace furrow::sync {
namespace {

using base::Nanoseconds;
constexpr Nanoseconds kSecond = base::kNanosecondsPerSecond;

/// Pairs over ten minutes: offset 7234.7 s, a drift, Gaussian noise, and a share of pairs that are wrong by
/// up to a minute.
std::vector<std::pair<Nanoseconds, Nanoseconds>> make_pairs(base::Random& random, int count, double drift,
                                                            double noise_s, double wrong_share) {
  std::vector<std::pair<Nanoseconds, Nanoseconds>> pairs;
  for (int i = 0; i < count; ++i) {
    const double t_s = 600.0 * i / count;
    double c_s = t_s + drift * (t_s - 300.0) + random.normal(0.0, noise_s);
    if (random.uniform() < wrong_share) c_s += random.uniform(-60.0, 60.0);
    pairs.emplace_back(base::seconds_to_ns(t_s), base::seconds_to_ns(c_s) + Nanoseconds{7'234'700'000'000});
  }
  return pairs;
}

TEST(ClockMap, ExactPairsGiveExactClocks) {
  base::Random random(1);
  const auto pairs = make_pairs(random, 50, 2e-5, 0.0, 0.0);
  const auto map = fit_clock(pairs, {.drift = true, .step_s = 1e-9});
  ASSERT_TRUE(map.ok());
  EXPECT_NEAR(map->drift, 2e-5, 1e-10);
  for (const auto& [t, c] : pairs) EXPECT_NEAR(static_cast<double>(map_time(*map, t) - c), 0.0, 50.0) << "ns";
}

TEST(ClockMap, KeepsNanosecondsOfAUtcSizedOffset) {
  const Nanoseconds offset = 1'700'000'000'123'456'789;
  const auto map = fit_clock({{0, offset}, {kSecond, offset + kSecond}, {2 * kSecond, offset + 2 * kSecond}});
  ASSERT_TRUE(map.ok());
  EXPECT_EQ(map->offset_ns, offset);
  EXPECT_EQ(map_time(*map, 5 * kSecond), offset + 5 * kSecond);
}

TEST(ClockMap, WrongPairsHardlyMoveIt) {
  base::Random random(2);
  const auto map = fit_clock(make_pairs(random, 200, 0.0, 0.05, 0.2), {.step_s = 0.01});
  ASSERT_TRUE(map.ok());
  EXPECT_NEAR(base::ns_to_seconds(map->offset_ns), 7234.7, 0.03);
  EXPECT_GT(map->outliers, 20);
}

// The claimed sigma, sampled: the truth lies inside 1 and 2 sigma as often as a Gaussian's. 1500 trials have
// a standard error of 1.2 %.
TEST(ClockMap, ClaimedSigmasHold) {
  base::Random random(3);
  const int trials = 1500;
  int offset_1 = 0, offset_2 = 0, drift_1 = 0, far_1 = 0;
  for (int i = 0; i < trials; ++i) {
    const auto map = fit_clock(make_pairs(random, 40, 3e-5, 0.08, 0.0), {.drift = true, .step_s = 1e-3});
    // The true line at the pairs' mean time.
    const double mean_s = base::ns_to_seconds(map->at_ns);
    const double error_s = base::ns_to_seconds(map->offset_ns) - 7234.7 - 3e-5 * (mean_s - 300.0);
    offset_1 += std::abs(error_s) < map->offset_sigma_s;
    offset_2 += std::abs(error_s) < 2.0 * map->offset_sigma_s;
    drift_1 += std::abs(map->drift - 3e-5) < map->drift_sigma;
    const double far_error_s =
        base::ns_to_seconds(map_time(*map, 900 * kSecond)) - 900.0 - 7234.7 - 3e-5 * 600.0;
    far_1 += std::abs(far_error_s) < map_sigma_s(*map, 900 * kSecond);
  }
  EXPECT_NEAR(static_cast<double>(offset_1) / trials, 0.683, 0.05);
  EXPECT_NEAR(static_cast<double>(offset_2) / trials, 0.954, 0.03);
  EXPECT_NEAR(static_cast<double>(drift_1) / trials, 0.683, 0.05);
  EXPECT_NEAR(static_cast<double>(far_1) / trials, 0.683, 0.05);
}

TEST(ClockMap, TooFewPairsAreAnError) {
  EXPECT_EQ(fit_clock({}).error().code, "not_enough_pairs");
  EXPECT_EQ(fit_clock({{0, 0}, {1, 1}}, {.drift = true}).error().code, "not_enough_pairs");
  const auto one = fit_clock({{0, 5}}, {.step_s = 1.0});
  ASSERT_TRUE(one.ok());
  EXPECT_NEAR(one->offset_sigma_s, 1.0 / std::sqrt(12.0), 1e-12);
}

}  // namespace
}  // namespace furrow::sync
