#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"
#include "furrow/geom/attitude.h"
#include "furrow/geom/hull.h"
#include "furrow/geom/rigid3.h"

namespace furrow::geom {
namespace {

TEST(Angles, Wrap) {
  EXPECT_NEAR(wrap_angle(3 * kPi), -kPi, 1e-12);
  EXPECT_NEAR(wrap_angle(-kPi - 0.1), kPi - 0.1, 1e-12);
  EXPECT_NEAR(wrap_angle(deg_to_rad(370)), deg_to_rad(10), 1e-12);
}

TEST(Hull, HoldsItsPointsAndHasNoCornerToSpare) {
  const std::vector<Eigen::Vector2d> square{{0, 0}, {2, 2}, {1, 0}, {2, 0}, {1, 1}, {0, 2}, {0, 0}};
  const std::vector<Eigen::Vector2d> expected{{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  EXPECT_EQ(convex_hull(square), expected);
  for (const Eigen::Vector2d& p : square) EXPECT_TRUE(is_inside(expected, p));
  EXPECT_FALSE(is_inside(expected, {2.01, 1.0}));
  EXPECT_FALSE(is_inside(expected, {-0.01, 1.0}));
  const auto line = convex_hull({{0, 0}, {1, 1}, {2, 2}});
  EXPECT_LT(line.size(), 3U);
  EXPECT_FALSE(is_inside(line, {1, 1}));
  base::Random random(5);
  std::vector<Eigen::Vector2d> cloud;
  for (int i = 0; i < 200; ++i) cloud.emplace_back(random.normal(), random.normal());
  const auto hull = convex_hull(cloud);
  for (const Eigen::Vector2d& p : cloud) EXPECT_TRUE(is_inside(hull, p));
}

TEST(Rigid3, ProductsCancel) {
  base::Random random(2);
  for (int i = 0; i < 100; ++i) {
    const auto draw = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
    const Rigid3 b_from_a{rotation_from_vector(draw()), draw()};
    const Rigid3 c_from_b{rotation_from_vector(draw()), draw()};
    const Eigen::Vector3d x_in_a = draw();
    EXPECT_LT(((c_from_b * b_from_a) * x_in_a - c_from_b * (b_from_a * x_in_a)).norm(), 1e-12);
    EXPECT_LT((inverse(b_from_a) * (b_from_a * x_in_a) - x_in_a).norm(), 1e-12);
  }
}

TEST(Rigid3, RotationVectorRoundTrips) {
  for (const double angle : {0.0, 1e-12, 1e-5, 1.0, 3.1, kPi}) {
    const Eigen::Vector3d vector = angle * Eigen::Vector3d(1, -2, 2) / 3.0;
    EXPECT_LT((rotation_vector(rotation_from_vector(vector)) - vector).norm(), 1e-9) << angle;
  }
}

// Worked by hand from the definition of the frames.
TEST(Attitude, PointsWhereTheConventionSays) {
  const Eigen::Vector3d forward(1, 0, 0);
  const Eigen::Vector3d left(0, 1, 0);
  const Eigen::Vector3d down(0, 0, -1);
  EXPECT_LT((cam_from_level({}) * forward - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((cam_from_level({}) * left - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-12);
  EXPECT_LT((cam_from_level({}) * down - Eigen::Vector3d(0, 1, 0)).norm(), 1e-12);
  // Straight down: what is below is ahead, what is forward is up in the picture.
  const Eigen::Matrix3d nadir = cam_from_level({.yaw_rad = 0, .pitch_rad = -kPi / 2, .roll_rad = 0});
  EXPECT_LT((nadir * down - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((nadir * forward - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12);
  // Pitched down by 30 deg, the horizon ahead appears above the centre.
  EXPECT_LT((cam_from_level({.yaw_rad = 0, .pitch_rad = -kPi / 6, .roll_rad = 0}) * forward).y(), -0.4);
  // Turned left, what was ahead appears on the right.
  EXPECT_GT((cam_from_level({.yaw_rad = 0.1, .pitch_rad = 0, .roll_rad = 0}) * forward).x(), 0.09);
  // Right side down: what is on the left and level appears lower left... the world turns counter-clockwise in
  // the picture.
  EXPECT_GT((cam_from_level({.yaw_rad = 0, .pitch_rad = 0, .roll_rad = 0.1}) * left).y(), 0.09);
}

TEST(Attitude, RoundTrips) {
  base::Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Attitude in{random.uniform(-3, 3), random.uniform(-1.5, 1.5), random.uniform(-3, 3)};
    const Attitude out = attitude_of(cam_from_level(in));
    EXPECT_NEAR(out.yaw_rad, in.yaw_rad, 1e-9);
    EXPECT_NEAR(out.pitch_rad, in.pitch_rad, 1e-9);
    EXPECT_NEAR(out.roll_rad, in.roll_rad, 1e-9);
  }
  const Attitude nadir = attitude_of(cam_from_level({0.3, -kPi / 2, 0.0}));
  EXPECT_NEAR(nadir.yaw_rad, 0.3, 1e-9);
  EXPECT_NEAR(nadir.pitch_rad, -kPi / 2, 1e-9);
}

}  // namespace
}  // namespace furrow::geom
