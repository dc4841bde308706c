#include <gtest/gtest.h>

#include "furrow/sim/simulate.h"

TEST(Scene, DemoHolds) {
  EXPECT_TRUE(furrow::sim::validate(furrow::sim::demo_scene()).ok());
}
