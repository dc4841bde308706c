#include "altitude/edge_line.h"

#include <gtest/gtest.h>
#include <cmath>

namespace furrow::altitude {
namespace {

/// A gently bent edge, on the unit plane.
double bent_edge(double y) {
  return 0.1 + 0.5 * y + 0.2 * y * y;
}

/// A row's left edge from the horizon down, its samples as sure as they are far.
RowsOnUnitPlane bent_row() {
  RowsOnUnitPlane rows;
  RowsOnUnitPlane::Row row;
  for (int i = 1; i <= 60; ++i) {
    const double y = 0.01 * i;
    RowDirection d;
    d.left = Eigen::Vector2d(bent_edge(y), y);
    d.centre = {0.0, y};
    d.sigma = 1.0;
    d.edge_sigma = 0.05 * y;
    row.directions.push_back(d);
  }
  rows.rows.push_back(row);
  return rows;
}

// A straight line fitted to samples of a parabola meets it at Gauss's two nodes of the samples' weights. Two
// points one spread from the centroid miss it by 3e-3, and the farther lies beyond the farthest sample
// (y = -0.02).
TEST(EdgeLine, ALineMeetsTheCurveThatItWasFittedToAtItsTwoPoints) {
  const auto lines = reduce_to_lines(bent_row());
  ASSERT_EQ(lines.size(), 1u);
  for (const Eigen::Vector2d& p : lines[0].points) {
    EXPECT_GT(p.y(), 0.01);
    EXPECT_LT(p.y(), 0.6);
    EXPECT_NEAR(p.x(), bent_edge(p.y()), 3e-4) << p.y();
  }
}

}  // namespace
}  // namespace furrow::altitude
