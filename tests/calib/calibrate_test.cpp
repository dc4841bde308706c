#include "furrow/calib/calibrate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "calib/model.h"
#include "calib/synthetic.h"
#include "furrow/base/file.h"
#include "furrow/base/value.h"
#include "furrow/camera/model_files.h"

namespace furrow::calib {
namespace {

TEST(Model, ViewJacobiansEqualCentralDifferences) {
  FreeTerms free;
  free.distortion = 12;
  free.aspect = free.warp = true;
  Camera camera = true_camera();
  camera.model = camera::CameraModel::opencv12;
  camera.distortion = {0.4, 0.02, 4e-4, -1e-4, 9e-5, 0.7, 0.09, 1e-3, 1e-3, -2e-4, -5e-4, 1e-4};
  // An AprilGrid of 2 x 2 tags seen without its first corner: corners at uneven steps, told by their ids.
  const target::BoardSpec board{"small",         4, 4, 0.04, 1.1, target::BoardKind::aprilgrid, 0.0, 0.012,
                                "apriltag_36h11"};
  const SharedModel model = make_shared_model(camera, board, Eigen::Vector2d::Zero(), free);
  Eigen::VectorXd shared = shared_of(model);
  shared.tail<2>() << 0.002, -0.001;
  base::Random random(5);
  for (int trial = 0; trial < 20; ++trial) {
    PoseVector pose;
    pose << random.normal(), random.normal(), random.normal(), random.normal(0, 0.1), random.normal(0, 0.1),
        0.8;
    if (trial == 0) pose.head<3>().setZero();
    SeenCorners seen{{}, std::vector<Eigen::Vector2d>(15, Eigen::Vector2d(600, 300))};
    for (int id = 1; id < 16; ++id) seen.ids.push_back(id);
    const std::vector<double> weight(15, 0.7);
    const auto residual = [&](const Eigen::VectorXd& s, const PoseVector& p) {
      Eigen::VectorXd out(30);
      EXPECT_TRUE(evaluate_view(model, s, p, seen, weight, out.data(), nullptr, nullptr));
      return out;
    };
    Eigen::VectorXd at(30);
    RowMajor a(30, model.count), b(30, 6);
    ASSERT_TRUE(evaluate_view(model, shared, pose, seen, weight, at.data(), a.data(), b.data()));
    for (Eigen::Index i = 0; i < shared.size(); ++i) {
      const double step = 1e-6 * std::max(1.0, std::abs(shared[i]));
      const Eigen::VectorXd d = Eigen::VectorXd::Unit(shared.size(), i) * step;
      const Eigen::VectorXd numeric = (residual(shared + d, pose) - residual(shared - d, pose)) / (2 * step);
      EXPECT_LT((a.col(i) - numeric).norm(), 1e-5 * (1 + numeric.norm())) << "shared " << i;
    }
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-6;
      const PoseVector d = PoseVector::Unit(i) * kStep;
      const Eigen::VectorXd numeric = (residual(shared, pose + d) - residual(shared, pose - d)) / (2 * kStep);
      EXPECT_LT((b.col(i) - numeric).norm(), 1e-4 * (1 + numeric.norm())) << "pose " << i;
    }
  }
}

// Boards of which every view misses other corners: the ids say which are there.
TEST(Calibrate, PartsOfABoardGiveTheCamera) {
  auto detections = session(true_camera(), true_board(), {20});
  base::Random random(17);
  for (auto& one : detections) {
    const auto whole = one;
    one.corners_px.clear();
    one.sigma_px.clear();
    for (int id = 0; id < 54; ++id) {
      if (random.uniform() < 0.4) continue;
      one.corner_ids.push_back(id);
      one.corners_px.push_back(whole.corners_px[static_cast<std::size_t>(id)]);
      one.sigma_px.push_back(0.2);
    }
  }
  const auto found = calibrate(detections, true_board());
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_LT(found->rms_px, 0.2 * std::sqrt(2.0) * 1.05);
  EXPECT_NEAR(found->camera.fx, true_camera().fx, 3.0 * std::sqrt(found->camera.covariance(0, 0)));
  EXPECT_EQ(found->views[0].corner_ids, detections[0].corner_ids);
  for (const std::vector<int>& wrong : {std::vector<int>{3, 2}, {-1, 4}, {5, 54}}) {
    auto broken = detections;
    broken[0].corner_ids = wrong;
    broken[0].corners_px.resize(2);
    const auto without = calibrate(broken, true_board());
    ASSERT_TRUE(without.ok()) << without.error().message();
    EXPECT_EQ(without->views[0].reason, "corners that are not the board's");
  }
}

TEST(Calibrate, FindsTheVeryCameraWithoutNoise) {
  Session how;
  how.noise_px = 0.0;
  const auto found = calibrate(session(true_camera(), true_board(), how), true_board());
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_LT(found->rms_px, 1e-7);
  EXPECT_LT((camera::intrinsics(found->camera) - camera::intrinsics(true_camera())).norm(), 1e-3);
}

TEST(Calibrate, EveryModelFindsItself) {
  for (const auto model :
       {camera::CameraModel::pinhole, camera::CameraModel::opencv4, camera::CameraModel::opencv8}) {
    Camera camera = true_camera();
    camera.model = model;
    camera.distortion.assign(static_cast<std::size_t>(camera::distortion_count(model)), 0.0);
    if (model != camera::CameraModel::pinhole) camera.distortion[0] = -0.2;
    Session how;
    how.noise_px = 0.0;
    CalibrateOptions options;
    options.model = model;
    const auto found = calibrate(session(camera, true_board(), how), true_board(), options);
    ASSERT_TRUE(found.ok()) << found.error().message();
    EXPECT_LT(found->rms_px, 1e-5) << camera::model_name(model);
    EXPECT_NEAR(found->camera.fx, camera.fx, 0.01) << camera::model_name(model);
  }
}

// 200 sessions with fresh noise: the scatter of fx, cx and k1 must be what each claims, within 15 %.
TEST(Calibrate, ClaimedSigmaIsTheScatter) {
  constexpr int kTrials = 200;
  Session how;
  how.noise_px = 0.0;
  const auto clean = session(true_camera(), true_board(), how);
  const std::vector<Eigen::Index> watched{0, 2, 4};
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(9), square = sum, claimed = sum;
  base::Random random(77);
  for (int trial = 0; trial < kTrials; ++trial) {
    auto noisy = clean;
    for (auto& view : noisy) {
      for (auto& px : view.corners_px) px += Eigen::Vector2d(random.normal(0, 0.2), random.normal(0, 0.2));
    }
    const auto found = calibrate(noisy, true_board());
    ASSERT_TRUE(found.ok());
    const Eigen::VectorXd miss = camera::intrinsics(found->camera) - camera::intrinsics(true_camera());
    sum += miss / kTrials;
    square += miss.cwiseAbs2() / kTrials;
    claimed += found->camera.covariance.diagonal() / kTrials;
  }
  for (const Eigen::Index i : watched) {
    const double sampled = std::sqrt(square[i] - sum[i] * sum[i]);
    EXPECT_NEAR(std::sqrt(claimed[i]) / sampled, 1.0, 0.15) << "intrinsic " << i;
    EXPECT_LT(std::abs(sum[i]), 4.0 * sampled / std::sqrt(kTrials)) << "bias of intrinsic " << i;
  }
}

TEST(Calibrate, NoiseLevelIsFoundWithTheRightCount) {
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Session how;
    how.seed = seed;
    how.views = 4;
    const auto found = calibrate(session(true_camera(), true_board(), how), true_board());
    ASSERT_TRUE(found.ok());
    EXPECT_EQ(found->degrees_of_freedom, 4 * 54 * 2 - 9 - 4 * 6);
    sum += found->sigma0_px * found->sigma0_px / 20;
  }
  EXPECT_NEAR(std::sqrt(sum), 0.2, 0.01);
}

TEST(Calibrate, OrderOfFilesDoesNotMatter) {
  Session how;
  auto views = session(true_camera(), true_board(), how);
  const auto one = calibrate(views, true_board());
  std::reverse(views.begin(), views.end());
  const auto two = calibrate(views, true_board());
  ASSERT_TRUE(one.ok() && two.ok());
  EXPECT_EQ(camera::intrinsics(one->camera), camera::intrinsics(two->camera));
  EXPECT_EQ(one->camera.covariance, two->camera.covariance);
  EXPECT_EQ(one->views.front().image, two->views.back().image);
}

TEST(Calibrate, AspectOfABoardOnAMonitorIsSolved) {
  target::BoardSpec stretched = true_board();
  stretched.aspect = 1.013;
  Camera square = true_camera();
  square.fy = square.fx;
  CalibrateOptions options;
  options.solve_aspect = true;
  const auto found = calibrate(session(square, stretched, Session{}), true_board(), options);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_EQ(found->camera.fx, found->camera.fy);
  ASSERT_TRUE(found->board_aspect.usable());
  EXPECT_NEAR(found->board_aspect.value, 1.013, 4 * found->board_aspect.sigma);
  EXPECT_LT(found->board_aspect.sigma, 1e-3);
  EXPECT_EQ(found->board.aspect, found->board_aspect.value);
}

TEST(Calibrate, BendOfTheBoardIsSolved) {
  CalibrateOptions options;
  options.solve_warp = true;
  Session how;
  how.views = 20;
  const Eigen::Vector2d warp_m(0.0015, -0.0008);
  const auto found = calibrate(session(true_camera(), true_board(), how, warp_m), true_board(), options);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_NEAR(found->board_warp_x_m.value, warp_m.x(), 4 * found->board_warp_x_m.sigma);
  EXPECT_NEAR(found->board_warp_y_m.value, warp_m.y(), 4 * found->board_warp_y_m.sigma);
  EXPECT_LT(found->board_warp_x_m.sigma, 3e-4);
}

TEST(Calibrate, BadViewIsDroppedForItsErrorOnlyWhenAsked) {
  auto views = session(true_camera(), true_board(), Session{});
  base::Random random(3);
  for (auto& px : views[4].corners_px) px += Eigen::Vector2d(random.normal(0, 3), random.normal(0, 3));
  CalibrateOptions options;
  const auto kept = calibrate(views, true_board(), options);
  ASSERT_TRUE(kept.ok());
  EXPECT_TRUE(kept->views[4].used);
  options.view_outlier_ratio = 3.0;
  const auto dropped = calibrate(views, true_board(), options);
  ASSERT_TRUE(dropped.ok());
  EXPECT_FALSE(dropped->views[4].used);
  EXPECT_NE(dropped->views[4].reason.find("RMS"), std::string::npos);
  EXPECT_EQ(std::count_if(dropped->views.begin(), dropped->views.end(), [](const View& v) { return v.used; }),
            11);
}

TEST(Calibrate, StainedCornersAreLeftOutOnlyWhenAsked) {
  auto views = session(true_camera(), true_board(), Session{});
  const std::vector<std::pair<std::size_t, std::size_t>> stains{{0, 3}, {2, 17}, {2, 18}, {7, 53}};
  for (const auto& [view, corner] : stains) views[view].corners_px[corner] += Eigen::Vector2d(4.0, -3.0);
  CalibrateOptions options;
  const auto kept = calibrate(views, true_board(), options);
  ASSERT_TRUE(kept.ok());
  EXPECT_EQ(kept->corners_left_out, 0);
  options.corner_outlier_sigmas = 5.0;
  const auto cleaned = calibrate(views, true_board(), options);
  ASSERT_TRUE(cleaned.ok()) << cleaned.error().message();
  EXPECT_EQ(cleaned->corners_left_out, 4);
  for (const auto& [view, corner] : stains) EXPECT_TRUE(cleaned->views[view].left_out[corner]);
  EXPECT_EQ(cleaned->corners, 12 * 54 - 4);
  EXPECT_EQ(cleaned->degrees_of_freedom, 2 * cleaned->corners - 9 - 12 * 6);
  EXPECT_NEAR(cleaned->sigma0_px, 0.2, 0.015);
  EXPECT_GT(kept->rms_px, 1.3 * cleaned->rms_px);
}

TEST(Calibrate, RefusalsNameWhatIsMissing) {
  auto views = session(true_camera(), true_board(), Session{});
  auto two = views;
  two.resize(2);
  two.push_back({});
  two.back().image = "blank.jpg";
  two.back().reason = "no board of 9x6 inner corners found";
  const auto few = calibrate(two, true_board());
  ASSERT_FALSE(few.ok());
  EXPECT_EQ(few.error().code, "too_few_boards");
  EXPECT_NE(few.error().message().find("blank.jpg"), std::string::npos);
  EXPECT_EQ(calibrate({}, true_board()).error().code, "too_few_boards");
  auto mixed = views;
  mixed[3].width = 1281;
  EXPECT_EQ(calibrate(mixed, true_board()).error().code, "picture_sizes_differ");
  auto rubbish = views;
  for (auto& view : rubbish) std::fill(view.corners_px.begin(), view.corners_px.end(), Eigen::Vector2d(3, 3));
  EXPECT_EQ(calibrate(rubbish, true_board()).error().code, "solve_failed");
  auto nan = views;
  nan[0].corners_px[7].x() = std::nan("");
  const auto rest = calibrate(nan, true_board());
  ASSERT_TRUE(rest.ok());
  EXPECT_FALSE(rest->views[0].used);
}

TEST(Calibrate, JsonHoldsTheNamesOthersRead) {
  const auto found = calibrate(session(true_camera(), true_board(), Session{}), true_board());
  ASSERT_TRUE(found.ok());
  const std::string text = to_json(*found);
  const auto tree = base::parse_json(text, "calibration.json");
  ASSERT_TRUE(tree.ok());
  for (const char* key :
       {"image_size", "model", "fx", "fy", "cx", "cy", "distortion", "rms_px", "views", "covariance"}) {
    EXPECT_NE(tree->find(key), nullptr) << key;
  }
  for (const char* key : {"image", "used", "rms_px", "reason"})
    EXPECT_NE((*tree->find("views")->array())[0].find(key), nullptr) << key;
  const auto camera = camera::parse_camera(text, "calibration.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera::intrinsics(*camera), camera::intrinsics(found->camera));
  EXPECT_EQ(camera->covariance, found->camera.covariance);
  EXPECT_EQ(camera->provenance, found->camera.provenance);
}

}  // namespace
}  // namespace furrow::calib
