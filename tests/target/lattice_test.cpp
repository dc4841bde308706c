#include "target/lattice.h"

#include <gtest/gtest.h>

namespace furrow::target {
namespace {

// A picture of leaves, without a board, whose lattice was trimmed away altogether: growing nothing went on
// for ever.
TEST(Lattice, NothingGrowsToNothing) {
  SearchWork work;
  EXPECT_TRUE(completed({}, {}, 9, 6, work).empty());
}

// Two lone corners are trimmed to nothing inside.
TEST(Lattice, ALatticeThatIsTrimmedAwayStaysEmpty) {
  SearchWork work;
  Lattice lattice;
  lattice[{0, 0}] = Eigen::Vector2d(10, 10);
  lattice[{3, 2}] = Eigen::Vector2d(40, 30);
  (void)completed(lattice, {}, 9, 6, work);
}

}  // namespace
}  // namespace furrow::target
