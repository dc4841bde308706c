#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/stats/agreement.h"
#include "furrow/stats/robust.h"

namespace furrow::stats {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Robust, QuantilesFollowType7) {
  const std::vector<double> values = {4, 1, kNaN, 3, 2};
  EXPECT_DOUBLE_EQ(median(values), 2.5);
  // R: quantile(1:4, 0.1, type = 7) = 1.3
  EXPECT_DOUBLE_EQ(quantile(values, 0.1), 1.3);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(Robust, MadEqualsSigmaForGaussians) {
  base::Random random(3);
  std::vector<double> values(100000);
  for (double& value : values) value = random.normal(5.0, 2.0);
  EXPECT_NEAR(mad_sigma(values), 2.0, 0.03);
  EXPECT_NEAR(standard_deviation(values), 2.0, 0.02);
}

TEST(Agreement, BiasAndLimits) {
  const std::vector<double> estimates = {3.1, 4.3, kNaN, 5.0};
  const std::vector<double> references = {3.0, 4.0, 5.0, 5.2};
  const Agreement result = agreement(estimates, references);
  EXPECT_EQ(result.pairs, 3);
  EXPECT_EQ(result.left_out, 1);
  // Errors 0.1, 0.3, -0.2: mean 0.0667, sample sd 0.2517, rmse sqrt(0.14 / 3).
  EXPECT_NEAR(result.mean_error, 0.2 / 3, 1e-12);
  EXPECT_NEAR(result.sd_error, 0.2516611478, 1e-9);
  EXPECT_NEAR(result.rmse, std::sqrt(0.14 / 3), 1e-12);
  EXPECT_NEAR(result.max_abs_error, 0.3, 1e-12);
  EXPECT_NEAR(result.limit_high - result.limit_low, 2 * 1.959964 * 0.2516611478, 1e-6);
  EXPECT_TRUE(std::isnan(agreement({}, {}).rmse));
}

TEST(Coverage, CountsTruthsInsideSigma) {
  base::Random random(9);
  std::vector<Estimate> estimates;
  std::vector<double> truths;
  for (int i = 0; i < 20000; ++i) {
    estimates.push_back({random.normal(), 1.0, 1});
    truths.push_back(0.0);
  }
  estimates.push_back({});
  truths.push_back(0.0);
  const Coverage result = coverage(estimates, truths);
  EXPECT_EQ(result.count, 20000);
  EXPECT_NEAR(result.within_1_sigma, 0.6827, 0.012);
  EXPECT_NEAR(result.within_2_sigma, 0.9545, 0.006);
}

}  // namespace
}  // namespace furrow::stats
