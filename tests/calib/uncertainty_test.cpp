#include "furrow/calib/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "calib/synthetic.h"

namespace furrow::calib {
namespace {

/// Where the point goes that keeps its place among the boards: mrcal's definition, by the definition.
Eigen::Vector2d reprojected(const Calibration& baseline, const Calibration& sample, const Eigen::Vector3d& x,
                            bool direction) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < baseline.views.size(); ++i) {
    const Rigid3 drift = sample.views[i].cam_from_board * geom::inverse(baseline.views[i].cam_from_board);
    sum += direction ? Eigen::Vector3d(drift.rotation * x) : drift * x;
  }
  return *camera::project(sample.camera, sum);
}

// 200 re-noised solves; the claimed standard deviation within 15 % of the sampled one at nine places, near,
// and at infinity.
TEST(Uncertainty, ClaimedProjectionSigmaIsTheScatter) {
  Session how;
  how.noise_px = 0.0;
  const auto clean = session(true_camera(), true_board(), how);
  const auto baseline = calibrate(clean, true_board());
  ASSERT_TRUE(baseline.ok());
  base::Random random(99);
  std::vector<Calibration> samples;
  for (int trial = 0; trial < 200; ++trial) {
    auto noisy = clean;
    for (auto& view : noisy) {
      for (auto& px : view.corners_px) px += Eigen::Vector2d(random.normal(0, 0.2), random.normal(0, 0.2));
    }
    const auto found = calibrate(noisy, true_board());
    ASSERT_TRUE(found.ok());
    samples.push_back(*found);
  }
  for (const double distance_m : {0.8, std::numeric_limits<double>::infinity()}) {
    const bool direction = !std::isfinite(distance_m);
    for (const double u : {200.0, 640.0, 1080.0}) {
      for (const double v : {120.0, 360.0, 600.0}) {
        const Eigen::Vector3d way = camera::unproject(baseline->camera, {u, v})->homogeneous().normalized();
        const Eigen::Vector3d x = direction ? way : Eigen::Vector3d(way * distance_m);
        double sampled = 0.0, claimed = 0.0;
        for (const Calibration& sample : samples) {
          sampled +=
              (reprojected(*baseline, sample, x, direction) - Eigen::Vector2d(u, v)).squaredNorm() / 200;
          claimed += projection_covariance(sample, {u, v}, distance_m)->trace() / 200;
        }
        EXPECT_NEAR(std::sqrt(claimed / sampled), 1.0, 0.15) << u << " " << v << " at " << distance_m << " m";
      }
    }
  }
}

TEST(Uncertainty, GrowsAwayFromTheBoards) {
  const auto found = calibrate(session(true_camera(), true_board(), Session{}), true_board());
  ASSERT_TRUE(found.ok());
  const double middle = *projection_sigma_px(*found, {640, 360}, 0.8),
               corner = *projection_sigma_px(*found, {5, 5}, 0.8);
  const double far = *projection_sigma_px(*found, {640, 360}, 100.0);
  EXPECT_GT(corner, 2.0 * middle);
  EXPECT_GT(far, middle);
  EXPECT_FALSE(projection_sigma_px(*found, {640, 360}, -1.0).has_value());
  EXPECT_FALSE(projection_sigma_px(Calibration{}, {640, 360}, 1.0).has_value());
}

TEST(Uncertainty, HeightErrorIsTheFocalErrorInPercent) {
  Camera camera = true_camera();
  EXPECT_FALSE(height_error_percent(camera).has_value());
  camera.fx = camera.fy = 1000.0;
  camera.covariance = Eigen::MatrixXd::Zero(9, 9);
  camera.covariance.topLeftCorner<2, 2>().setConstant(25.0);  // fx and fy off together by 5 px
  EXPECT_NEAR(*height_error_percent(camera), 0.5, 1e-12);
}

}  // namespace
}  // namespace furrow::calib
