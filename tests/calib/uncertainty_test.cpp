#include "furrow/calib/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "calib/synthetic.h"
#include "furrow/base/file.h"
#include "furrow/stats/robust.h"

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

/// What one place's claims and samples add up to.
struct Tally {
  double claimed = 0.0, sampled = 0.0;
  double ratio() const { return std::sqrt(claimed / sampled); }
};

/// Exact corners of a solved real set, so that its own geometry and lens are what is sampled.
std::vector<target::BoardDetection> exact_like(const Calibration& solved,
                                               std::vector<target::BoardDetection> detections) {
  for (std::size_t i = 0; i < detections.size(); ++i) {
    detections[i].found = solved.views[i].used;
    if (!detections[i].found) continue;
    const auto corners = target::corners_in_board(solved.board);
    for (std::size_t c = 0; c < corners.size(); ++c)
      detections[i].corners_px[c] =
          *camera::project(solved.camera, solved.views[i].cam_from_board * corners[c]);
  }
  return detections;
}

struct HardSet {
  const char* name;
  const char* pattern;
  int corners_x, corners_y;
  camera::CameraModel model;
};
class UncertaintyReal : public ::testing::TestWithParam<HardSet> {};

// Tello: small boards at one distance, 32 px of sigma over the picture. Theta: a fisheye beyond 180 degrees.
TEST_P(UncertaintyReal, ClaimedSigmasAreTheScatterOverSeveralSeeds) {
  const HardSet& set = GetParam();
  const char* folder = std::getenv("FURROW_DATA");
  const std::filesystem::path data =
      folder != nullptr ? folder : std::filesystem::path(FURROW_SOURCE_DIR) / "../shared/data";
  const auto files = base::expand_pattern(set.pattern, data);
  if (!files.ok()) GTEST_SKIP() << "no pictures: " << files.error().message() << " (set FURROW_DATA)";
  const target::BoardSpec board{set.name, set.corners_x, set.corners_y, 0.03, 1.0};
  CalibrateOptions options;
  options.model = set.model;
  const auto detections = target::detect_boards(*files, board);
  const auto solved = calibrate(detections, board, options);
  ASSERT_TRUE(solved.ok()) << solved.error().message();
  const auto exact = exact_like(*solved, detections);
  const Camera& camera = solved->camera;
  std::vector<double> depths_m;
  for (const View& view : solved->views) {
    if (view.used) depths_m.push_back(view.cam_from_board.translation.norm());
  }
  const double near_m = stats::median(depths_m);
  Tally fx, cx, at[9], at_infinity[9];
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    base::Random random(seed);
    for (int trial = 0; trial < 70; ++trial) {
      auto noisy = exact;
      for (auto& view : noisy) {
        for (auto& px : view.corners_px)
          px += solved->sigma0_px * Eigen::Vector2d(random.normal(), random.normal());
      }
      const auto found = calibrate(noisy, board, options);
      ASSERT_TRUE(found.ok());
      fx.sampled += std::pow(found->camera.fx - camera.fx, 2);
      fx.claimed += found->camera.covariance(0, 0);
      cx.sampled += std::pow(found->camera.cx - camera.cx, 2);
      cx.claimed += found->camera.covariance(2, 2);
      for (int place = 0; place < 9; ++place) {
        // The Theta's picture is a circle: places within its middle.
        const Eigen::Vector2d px((0.3 + 0.2 * (place % 3)) * camera.width,
                                 (0.3 + 0.2 * (place / 3)) * camera.height);
        const Eigen::Vector3d way = *camera::unproject_ray(camera, px);
        Calibration used_only = *solved, sample = *found;
        std::erase_if(used_only.views, [](const View& view) { return !view.used; });
        std::erase_if(sample.views, [](const View& view) { return !view.used; });
        at[place].sampled += (reprojected(used_only, sample, near_m * way, false) - px).squaredNorm();
        at[place].claimed += projection_covariance(*found, px, near_m)->trace();
        at_infinity[place].sampled += (reprojected(used_only, sample, way, true) - px).squaredNorm();
        at_infinity[place].claimed +=
            projection_covariance(*found, px, std::numeric_limits<double>::infinity())->trace();
      }
    }
  }
  EXPECT_NEAR(fx.ratio(), 1.0, 0.15);
  EXPECT_NEAR(cx.ratio(), 1.0, 0.15);
  for (int place = 0; place < 9; ++place) {
    // At the boards' distance some of the Tello's solves hold a board tilted the other way, which no linear
    // claim knows; the lens is not touched by that.
    if (set.model == camera::CameraModel::fisheye) {
      EXPECT_NEAR(at[place].ratio(), 1.0, 0.15) << place;
    } else {
      RecordProperty("near_" + std::to_string(place), std::to_string(at[place].ratio()));
    }
    EXPECT_NEAR(at_infinity[place].ratio(), 1.0, set.model == camera::CameraModel::fisheye ? 0.15 : 0.2)
        << place;
  }
}

INSTANTIATE_TEST_SUITE_P(Calib, UncertaintyReal,
                         ::testing::Values(HardSet{"tello", "calib/tello-archdrone/images/*.jpg", 7, 7,
                                                   camera::CameraModel::opencv5},
                                           HardSet{"theta", "calib/boofcv-fisheye-theta/images/*.jpg", 6, 4,
                                                   camera::CameraModel::fisheye}),
                         [](const auto& set) { return std::string(set.param.name); });

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
