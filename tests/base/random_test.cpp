#include "furrow/base/random.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "furrow/base/parallel.h"

namespace furrow::base {
namespace {

TEST(Random, MomentsOfUniformAndNormal) {
  Random random(1);
  const int n = 200000;
  double sum = 0.0;
  double squares = 0.0;
  double uniform = 0.0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal(2.0, 3.0);
    sum += x;
    squares += (x - 2.0) * (x - 2.0);
    uniform += random.uniform();
  }
  // Four standard errors of each mean.
  EXPECT_NEAR(sum / n, 2.0, 4 * 3.0 / 447.0);
  EXPECT_NEAR(squares / n, 9.0, 4 * 9.0 * 1.4142 / 447.0);
  EXPECT_NEAR(uniform / n, 0.5, 4 * 0.2887 / 447.0);
}

TEST(Random, SeedsGiveTheSameAndDifferentStreams) {
  Random a(5);
  Random b(5);
  Random c(6);
  EXPECT_EQ(a.bits(), b.bits());
  EXPECT_NE(a.bits(), c.bits());
}

TEST(ParallelFor, DoesEachOnceAndPassesOnTheFirstFailure) {
  std::vector<std::atomic<int>> calls(1000);
  parallel_for(calls.size(), 4, [&](std::size_t i) { ++calls[i]; });
  for (const auto& count : calls) EXPECT_EQ(count, 1);
  EXPECT_THROW(parallel_for(100, 3,
                            [](std::size_t i) {
                              if (i == 50) throw std::runtime_error("x");
                            }),
               std::runtime_error);
  parallel_for(0, 0, [](std::size_t) { FAIL(); });
}

}  // namespace
}  // namespace furrow::base
