// Lenses beyond OpenCV's polynomials: each finds itself, foretells what it has not seen, and stays within
// bounds.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "calib/synthetic.h"
#include "furrow/calib/calibrate.h"
#include "furrow/calib/choose_model.h"
#include "furrow/calib/uncertainty.h"
#include "furrow/camera/compare.h"

namespace furrow::calib {
namespace {

using camera::CameraModel;

Camera wide_camera(CameraModel model) {
  Camera camera;
  camera.model = model;
  camera.width = 1280;
  camera.height = 960;
  camera.fx = camera.fy = 420.0;
  camera.cx = 651.0;
  camera.cy = 470.0;
  if (model == CameraModel::fisheye) camera.distortion = {-0.02, 0.004, -0.001, 1e-4};
  return camera;
}

/// Boards all over what a wide lens sees, up to 75 degrees off the axis, each turned towards the camera and
/// tilted.
std::vector<target::BoardDetection> wide_session(const Camera& camera, int views, double noise_px) {
  base::Random random(41);
  const target::BoardSpec board = true_board();
  std::vector<target::BoardDetection> out;
  while (static_cast<int>(out.size()) < views) {
    const double off = random.uniform(0.0, 1.3), turn = random.uniform(0.0, 2.0 * std::numbers::pi);
    const Eigen::Vector3d way(std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn), std::cos(off));
    Rigid3 pose;
    pose.rotation =
        Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), way) *
        geom::rotation_from_vector(
            0.6 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), 0.3 * random.uniform(-1, 1)));
    pose.translation =
        random.uniform(0.3, 0.8) * way - pose.rotation * Eigen::Vector3d(4.0 * 0.038, 2.5 * 0.038, 0.0);
    target::BoardDetection view;
    view.image = "view_" + std::to_string(100 + out.size()) + ".jpg";
    view.width = camera.width;
    view.height = camera.height;
    view.found = true;
    for (const Eigen::Vector3d& x : target::corners_in_board(board)) {
      const auto px = camera::project(camera, pose * x);
      view.found =
          view.found && px && px->minCoeff() > 0 && px->x() < camera.width - 1 && px->y() < camera.height - 1;
      if (!view.found) break;
      view.corners_px.push_back(*px +
                                Eigen::Vector2d(random.normal(0, noise_px), random.normal(0, noise_px)));
    }
    if (view.found) out.push_back(std::move(view));
  }
  return out;
}

TEST(LensModels, WideLensesFindThemselvesFromNothing) {
  for (const CameraModel model : {CameraModel::fisheye, CameraModel::stereographic, CameraModel::latlon}) {
    const Camera truth = wide_camera(model);
    CalibrateOptions options;
    options.model = model;
    const auto found = calibrate(wide_session(truth, 25, 0.0), true_board(), options);
    ASSERT_TRUE(found.ok()) << camera::model_name(model) << ": " << found.error().message();
    EXPECT_LT(found->rms_px, 1e-6) << camera::model_name(model);
    // A turn of a latlon camera about x is a shift of cy, so the numbers may differ; the lens may not.
    const auto difference = camera::compare_cameras(truth, found->camera);
    ASSERT_TRUE(difference.ok()) << difference.error().message();
    EXPECT_LT(difference->rms_px, 1e-4) << camera::model_name(model);
  }
}

TEST(LensModels, SplinesTakeTheShapeOfAFisheye) {
  const Camera truth = wide_camera(CameraModel::fisheye);
  CalibrateOptions options;
  options.model = CameraModel::splined_stereographic;
  const auto found = calibrate(wide_session(truth, 40, 0.1), true_board(), options);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_TRUE(found->usable);
  EXPECT_LT(found->rms_px, 0.15);  // noise of 0.1 px in both coordinates
  const auto difference = camera::compare_cameras(truth, found->camera);
  ASSERT_TRUE(difference.ok()) << difference.error().message();
  // Where boards were: up to 75 degrees off the axis, some 550 px.
  for (std::size_t i = 0; i < difference->at_px.size(); ++i) {
    if ((difference->at_px[i] - Eigen::Vector2d(truth.cx, truth.cy)).norm() > 400.0) continue;
    EXPECT_LT(difference->difference_px[i].norm(), 0.5) << difference->at_px[i].transpose();
  }
  const auto sigma = projection_sigma_px(*found, {640, 480}, 1.0);
  ASSERT_TRUE(sigma.has_value());
  EXPECT_LT(*sigma, 0.2);
}

// A circular picture in a larger frame: no pixel of the border has a ray (the fold lies inside), and the
// knots must still be laid over what the lens sees.
TEST(LensModels, SplinesOfACircularPicture) {
  Camera truth = wide_camera(CameraModel::fisheye);
  truth.fx = truth.fy = 190.0;
  truth.distortion = {0.0, 0.0, 0.0, -0.002};  // turns back at 107 degrees, 300 px from the middle
  ASSERT_FALSE(camera::unproject_ray(truth, {truth.cx, 0.0}).has_value());
  CalibrateOptions options;
  options.model = CameraModel::splined_stereographic;
  const auto found = calibrate(wide_session(truth, 30, 0.1), true_board(), options);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_LT(found->rms_px, 0.16);
}

// A bump of 8 px that no radial formula has, as a cover glass or a decentred element makes: splines follow
// it.
TEST(LensModels, SplinesFollowWhatFormulasLack) {
  Camera truth = wide_camera(CameraModel::fisheye);
  auto views = wide_session(truth, 40, 0.0);
  for (auto& view : views) {
    for (Eigen::Vector2d& px : view.corners_px)
      px += Eigen::Vector2d(
          8.0 * std::exp(-(px - Eigen::Vector2d(400, 300)).squaredNorm() / (2.0 * 150 * 150)), 0.0);
  }
  CalibrateOptions options;
  options.model = CameraModel::fisheye;
  const auto formula = calibrate(views, true_board(), options);
  options.model = CameraModel::splined_stereographic;
  const auto splined = calibrate(views, true_board(), options);
  ASSERT_TRUE(formula.ok() && splined.ok());
  EXPECT_GT(formula->rms_px, 0.2);
  EXPECT_LT(splined->rms_px, 0.3 * formula->rms_px) << splined->rms_px << " of " << formula->rms_px;
}

TEST(LensModels, BoardsBendBeforeSplinesToo) {
  CalibrateOptions options;
  options.model = CameraModel::splined_stereographic;
  options.solve_warp = true;
  Session how;
  how.views = 40;
  const Eigen::Vector2d warp_m(0.0015, -0.0008);
  const auto found = calibrate(session(true_camera(), true_board(), how, warp_m), true_board(), options);
  ASSERT_TRUE(found.ok()) << found.error().message();
  EXPECT_NEAR(found->board_warp_x_m.value, warp_m.x(), 5 * found->board_warp_x_m.sigma);
  EXPECT_LT(found->rms_px, 0.3);
  options.solve_aspect = true;
  EXPECT_EQ(calibrate(session(true_camera(), true_board(), how), true_board(), options).error().code,
            "bad_option");
}

// Numerator and denominator of a rational lens cancel where there is no distortion: nothing but the prior
// holds them.
TEST(LensModels, RationalCoefficientsDoNotRunAway) {
  Camera plain = true_camera();
  plain.model = CameraModel::pinhole;
  plain.distortion.clear();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Session how;
    how.seed = seed;
    const auto views = session(plain, true_board(), how);
    CalibrateOptions options;
    options.model = CameraModel::opencv8;
    const auto found = calibrate(views, true_board(), options);
    ASSERT_TRUE(found.ok()) << found.error().message();
    for (const double k : found->camera.distortion) EXPECT_LT(std::abs(k), 15.0) << "seed " << seed;
    options.model = CameraModel::opencv5;
    EXPECT_LT(found->rms_px, calibrate(views, true_board(), options)->rms_px + 1e-3);
  }
}

TEST(LensModels, CrossValidationTakesTheSmallestThatForetells) {
  Session how;
  how.views = 18;
  const auto plain = choose_model(session(true_camera(), true_board(), how), true_board());
  ASSERT_TRUE(plain.ok()) << plain.error().message();
  EXPECT_TRUE(plain->model == CameraModel::opencv4 || plain->model == CameraModel::opencv5)
      << plain->sentence;
  EXPECT_NE(plain->sentence.find("foretold"), std::string::npos);
  const auto wide = choose_model(wide_session(wide_camera(CameraModel::fisheye), 24, 0.1), true_board());
  ASSERT_TRUE(wide.ok()) << wide.error().message();
  EXPECT_EQ(wide->model, CameraModel::fisheye) << wide->sentence;
  how.views = 5;
  EXPECT_EQ(choose_model(session(true_camera(), true_board(), how), true_board()).error().code,
            "too_few_boards");
}

TEST(LensModels, AnOldLensIsJudgedOnNewPictures) {
  const auto views = session(true_camera(), true_board(), Session{});
  const auto good = locate_boards(true_camera(), views, true_board());
  ASSERT_EQ(good.size(), views.size());
  for (const View& view : good) {
    EXPECT_TRUE(view.used) << view.reason;
    EXPECT_NEAR(view.rms_px, 0.2 * std::sqrt(2.0), 0.08);
  }
  Camera zoomed = true_camera();
  zoomed.fx *= 1.05;
  zoomed.fy *= 1.05;
  double worst = 0.0;
  for (const View& view : locate_boards(zoomed, views, true_board())) worst = std::max(worst, view.rms_px);
  EXPECT_GT(worst, 0.55);  // twice the noise
  std::vector<target::BoardDetection> blank(1);
  blank[0].reason = "no board of 9x6 inner corners found";
  EXPECT_EQ(locate_boards(true_camera(), blank, true_board())[0].reason, blank[0].reason);
}

}  // namespace
}  // namespace furrow::calib
