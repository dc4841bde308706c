#include "altitude/outline_roughness.h"

#include <gtest/gtest.h>
#include <cmath>
#include <Eigen/Geometry>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

constexpr double kHeight_m = 2.3, kSpacing_m = 3.0;

ShotVector pose_of_test() {
  ShotVector x = ShotVector::Zero();
  x[kLogHeight] = std::log(kHeight_m);
  x[kTheta] = geom::deg_to_rad(-14.0);
  x[kPsi] = geom::deg_to_rad(2.0);
  x[kPoseSize + kSpacing] = kSpacing_m;
  return x;
}

/// Direction of a place on the tops' plane, metres along the rows and to the left.
Eigen::Vector2d direction_of(const ShotVector& x, double along_m, double left_m) {
  const Eigen::Matrix3d rotation = cam_from_row({x[kTheta], x[kLambda], x[kPsi]});
  const Eigen::Vector3d d = rotation * Eigen::Vector3d(along_m, left_m, -kHeight_m);
  return d.hnormalized();
}

/// A row 0.6 m to each side of `axis_m`, its far edge wandering by `sigma_m`, its near one by ten times that.
RowsOnUnitPlane::Row row_at(int index, double axis_m, double sigma_m, double from_m, base::Random& random) {
  RowsOnUnitPlane::Row row;
  row.index = index;
  const ShotVector x = pose_of_test();
  for (int i = 0; i < 60; ++i) {
    const double along_m = from_m + 0.15 * i, far = sigma_m * random.normal(),
                 near = 10.0 * sigma_m * random.normal();
    const bool is_left = axis_m > 0.0;
    RowDirection direction;
    direction.left = direction_of(x, along_m, axis_m + 0.6 + (is_left ? far : near));
    direction.right = direction_of(x, along_m, axis_m - 0.6 + (is_left ? near : far));
    row.directions.push_back(direction);
  }
  return row;
}

TEST(OutlineRoughness, IsTheScatterOfFarEdgesInMetres) {
  base::Random random(5);
  RowsOnUnitPlane rows;
  for (int k = -1; k <= 1; ++k) rows.rows.push_back(row_at(k, 0.9 - k * kSpacing_m, 0.03, 2.0, random));
  rows.rows.push_back(row_at(-4, 12.9, 0.5, 2.0, random));  // too far aside to be told from pixels
  EXPECT_NEAR(outline_roughness_m(rows, pose_of_test()), 0.03, 0.006);
}

TEST(OutlineRoughness, IsNotKnownWithoutNearEdges) {
  base::Random random(6);
  RowsOnUnitPlane rows;
  EXPECT_TRUE(std::isnan(outline_roughness_m(rows, pose_of_test())));
  rows.rows.push_back(row_at(0, 0.9, 0.03, 12.5, random));
  EXPECT_TRUE(std::isnan(outline_roughness_m(rows, pose_of_test())));
}

}  // namespace
}  // namespace furrow::altitude
