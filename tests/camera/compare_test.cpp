#include "furrow/camera/compare.h"

#include <gtest/gtest.h>

#include <cmath>

#include "camera/cameras.h"
#include "furrow/base/random.h"

namespace furrow::camera {
namespace {

Camera narrow_camera() {
  Camera camera = test_camera(CameraModel::opencv8);
  camera.fx = camera.fy = 900.0;
  return camera;
}

TEST(Compare, CameraEqualsItself) {
  const auto same = compare_cameras(narrow_camera(), narrow_camera());
  ASSERT_TRUE(same.ok());
  EXPECT_LT(same->rms_px, 1e-8);
  EXPECT_TRUE(std::isnan(same->expected_rms_px));
  EXPECT_EQ(same->compared_share, 1.0);
}

// A shifted principal point is nearly a turn of the camera: what is left of 5 px is a fraction of that.
TEST(Compare, TurnThatSaysNothingIsTakenOut) {
  Camera moved = narrow_camera();
  moved.cx += 5.0;
  const auto difference = compare_cameras(narrow_camera(), moved);
  ASSERT_TRUE(difference.ok());
  EXPECT_NEAR(std::abs(difference->b_from_a_rad.y()), 5.0 / 900.0, 1e-3);
  EXPECT_LT(difference->rms_px, 1.5);
  Camera longer = narrow_camera();
  longer.fx *= 1.01;
  longer.fy *= 1.01;
  const auto focal = compare_cameras(narrow_camera(), longer);
  EXPECT_GT(focal->rms_px, 2.0);
}

// The first coefficient bends the corners of the picture by pixels and its middle by hundredths.
TEST(Compare, WithinAnOutlineOnlyWhatLiesThere) {
  const Camera a = narrow_camera();
  Camera b = a;
  b.distortion[0] += 0.05;
  const auto whole = compare_cameras(a, b, 24, 16);
  const auto middle = compare_cameras(
      a, b, 24, 16,
      {{0.4 * a.width, 0.4 * a.height}, {0.6 * a.width, 0.4 * a.height}, {0.6 * a.width, 0.6 * a.height},
       {0.4 * a.width, 0.6 * a.height}});
  ASSERT_TRUE(whole.ok() && middle.ok());
  EXPECT_LT(middle->mean_px, 0.05 * whole->mean_px);
  EXPECT_LT(middle->compared_share, 0.06);
  EXPECT_LE(whole->mean_px, whole->rms_px);
  EXPECT_LE(whole->rms_px, whole->largest_px);
}

TEST(Compare, PredictedDifferenceIsTheSampledOne) {
  Camera camera = narrow_camera();
  camera.covariance = Eigen::VectorXd::LinSpaced(12, 1.0, 1.0).asDiagonal();
  for (int i = 4; i < 12; ++i) camera.covariance(i, i) = 1e-8;
  const double expected = compare_cameras(camera, camera)->expected_rms_px;
  base::Random random(8);
  double squared = 0.0;
  constexpr int kTrials = 200;
  for (int trial = 0; trial < kTrials; ++trial) {
    Eigen::VectorXd a = intrinsics(camera), b = a;
    for (int i = 0; i < 12; ++i) {
      a[i] += std::sqrt(camera.covariance(i, i)) * random.normal();
      b[i] += std::sqrt(camera.covariance(i, i)) * random.normal();
    }
    squared += std::pow(compare_cameras(with_intrinsics(camera, a), with_intrinsics(camera, b))->rms_px, 2) /
               kTrials;
  }
  EXPECT_NEAR(std::sqrt(squared) / expected, 1.0, 0.1);
}

TEST(Compare, RefusesOtherSizesAndNoCamera) {
  Camera other = narrow_camera();
  other.width += 1;
  EXPECT_EQ(compare_cameras(narrow_camera(), other).error().code, "picture_sizes_differ");
  EXPECT_FALSE(compare_cameras(Camera{}, Camera{}).ok());
}

}  // namespace
}  // namespace furrow::camera
