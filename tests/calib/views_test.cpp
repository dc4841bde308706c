#include "furrow/calib/views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calib/synthetic.h"
#include "furrow/calib/uncertainty.h"
#include "furrow/calib/verdict.h"

namespace furrow::calib {
namespace {

/// Sigmas of a solve, as if its noise were that of `like`.
double focal_sigma(const Calibration& solved, const Calibration& like) {
  return *height_error_percent(solved.camera) * like.sigma0_px / solved.sigma0_px;
}
double picture_sigma(const Calibration& solved, const Calibration& like) {
  return *picture_sigma_px(solved.camera) * like.sigma0_px / solved.sigma0_px;
}

/// The claim is linear at the full solution; a fresh solve without the view has its own.
void expect_gains_hold(const std::vector<target::BoardDetection>& views, const CalibrateOptions& options,
                       std::size_t step, double tolerance) {
  const auto found = calibrate(views, true_board(), options);
  ASSERT_TRUE(found.ok()) << found.error().message();
  const std::vector<ViewGain> gain = information_gain(*found);
  ASSERT_EQ(gain.size(), views.size());
  for (std::size_t i = 0; i < gain.size(); i += step) {
    EXPECT_GT(gain[i].focal, 0.0);
    EXPECT_GT(gain[i].picture, 0.0);
    auto rest = views;
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(i));
    const auto without = calibrate(rest, true_board(), options);
    ASSERT_TRUE(without.ok());
    EXPECT_NEAR(focal_sigma(*without, *found) / focal_sigma(*found, *found), 1.0 + gain[i].focal,
                tolerance * (1.0 + gain[i].focal));
    EXPECT_NEAR(picture_sigma(*without, *found) / picture_sigma(*found, *found), 1.0 + gain[i].picture,
                tolerance * (1.0 + gain[i].picture));
  }
}

TEST(Views, AddWhatASolveWithoutThemLacks) {
  CalibrateOptions options;
  expect_gains_hold(session(true_camera(), true_board(), Session{}), options, 1, 0.06);
  options.solve_warp = options.square_pixels = true;
  Camera square = true_camera();
  square.fy = square.fx;
  expect_gains_hold(session(square, true_board(), Session{}), options, 1, 0.06);
}

// As many corners as give the finest grid with and without the view, which alone shows the right of the
// picture.
TEST(Views, AddToASplinedLensToo) {
  Session how;
  how.views = 120;
  how.farthest_m = 0.8;
  auto views = session(true_camera(), true_board(), how);
  const auto reaches_right = [](const target::BoardDetection& view) {
    return std::any_of(view.corners_px.begin(), view.corners_px.end(),
                       [](const Eigen::Vector2d& p) { return p.x() > 1000; });
  };
  std::stable_partition(views.begin(), views.end(), reaches_right);
  views.erase(views.begin(), std::find_if_not(views.begin(), views.end(), reaches_right) - 1);
  ASSERT_GT(views.size(), 30U);
  CalibrateOptions options;
  options.model = camera::CameraModel::splined_stereographic;
  const auto found = calibrate(views, true_board(), options);
  ASSERT_TRUE(found.ok());
  EXPECT_GT(information_gain(*found)[0].picture, 0.08);
  expect_gains_hold(views, options, views.size(), 0.03);
}

// Two views fix no lens: without either of the two good ones nothing is left.
TEST(Views, AreBeyondMeasureWhereTheRestFixesNothing) {
  Session how;
  how.views = 3;
  const auto found = calibrate(session(true_camera(), true_board(), how), true_board());
  ASSERT_TRUE(found.ok());
  for (const ViewGain& gain : information_gain(*found)) EXPECT_GT(gain.focal, 0.3);
  EXPECT_TRUE(std::isnan(information_gain([&] {
                           Calibration unused = *found;
                           unused.views[1].used = false;
                           return unused;
                         }())[1]
                             .focal));
  Calibration unknown = *found;
  unknown.lens_and_board_covariance.resize(0, 0);
  EXPECT_TRUE(std::isnan(information_gain(unknown)[0].picture));
  EXPECT_TRUE(next_views(unknown).empty());
}

/// Exact corners of a board held like this, with noise.
target::BoardDetection taken(const Camera& camera, const Rigid3& cam_from_board, std::uint64_t seed) {
  base::Random random(seed);
  target::BoardDetection out;
  out.image = "zz_next_" + std::to_string(seed) + ".jpg";
  out.width = camera.width;
  out.height = camera.height;
  out.found = true;
  for (const Eigen::Vector3d& x : target::corners_in_board(true_board())) {
    const auto px = camera::project(camera, cam_from_board * x);
    EXPECT_TRUE(px.has_value());
    out.corners_px.push_back(*px + Eigen::Vector2d(random.normal(0, 0.2), random.normal(0, 0.2)));
    out.sigma_px.push_back(0.2);
  }
  return out;
}

/// Boards in the middle, hardly tilted: what beginners bring home.
std::vector<target::BoardDetection> poor_session() {
  auto views = session(true_camera(), true_board(), Session{200, 0.2, 0.25, 0.8, 1.1, 4});
  std::erase_if(views, [](const target::BoardDetection& view) {
    return std::any_of(view.corners_px.begin(), view.corners_px.end(), [](const Eigen::Vector2d& p) {
      return p.x() < 250 || p.x() > 1030 || p.y() < 100 || p.y() > 620;
    });
  });
  views.resize(10);
  return views;
}

TEST(NextViews, KeepTheirPromiseAndBeatOtherPictures) {
  auto views = poor_session();
  const auto before = calibrate(views, true_board());
  ASSERT_TRUE(before.ok());
  const std::vector<NextView> next = next_views(*before);
  ASSERT_EQ(next.size(), 3U);
  const double at_first = *picture_sigma_px(before->camera);
  EXPECT_LT(next[0].picture_sigma_px, 0.6 * at_first);
  EXPECT_LT(next[1].picture_sigma_px, next[0].picture_sigma_px);
  EXPECT_LT(next[2].focal_percent, 0.6 * *height_error_percent(before->camera));
  // Twenty pictures that somebody might take instead.
  const auto others = session(true_camera(), true_board(), Session{20, 0.2, 0.7, 0.45, 1.1, 77});
  double best_other = at_first;
  for (const target::BoardDetection& other : others) {
    auto more = views;
    more.push_back(other);
    more.back().image = "zz_other.jpg";
    const auto after = calibrate(more, true_board());
    ASSERT_TRUE(after.ok());
    best_other = std::min(best_other, picture_sigma(*after, *before));
  }
  for (std::size_t i = 0; i < next.size(); ++i) {
    views.push_back(taken(true_camera(), next[i].cam_from_board, i + 1));
    const auto after = calibrate(views, true_board());
    ASSERT_TRUE(after.ok());
    const double reached = picture_sigma(*after, *before);
    EXPECT_NEAR(reached / next[i].picture_sigma_px, 1.0, 0.15) << next[i].sentence;
    EXPECT_LT(reached, best_other);
  }
}

// What the sentence says of the board is how it is held.
TEST(NextViews, SayHowTheBoardIsHeld) {
  const auto found = calibrate(poor_session(), true_board());
  ASSERT_TRUE(found.ok());
  const std::vector<NextView> next = next_views(*found, 8);
  bool any_tilt_x = false, any_tilt_y = false;
  for (const NextView& view : next) {
    const Eigen::Vector3d middle = 0.5 * target::corner_in_board(true_board(), 8, 5);
    EXPECT_NEAR((view.cam_from_board * middle).norm(), view.distance_m, 1e-9);
    EXPECT_LT((*camera::project(found->camera, view.cam_from_board * middle) - view.middle_px).norm(), 1e-6);
    EXPECT_NE(view.sentence.find("in the " + part_of_picture(found->camera, view.middle_px)),
              std::string::npos);
    // Depths of the outermost corners that are seen at the top, the bottom, the left and the right.
    double top = 1e9, bottom = -1e9, left = 1e9, right = -1e9, z_top = 0, z_bottom = 0, z_left = 0,
           z_right = 0;
    for (const Eigen::Vector3d& x : target::corners_in_board(true_board())) {
      const Eigen::Vector3d p = view.cam_from_board * x;
      const Eigen::Vector2d px = *camera::project(found->camera, p);
      if (px.y() < top) top = px.y(), z_top = p.norm();
      if (px.y() > bottom) bottom = px.y(), z_bottom = p.norm();
      if (px.x() < left) left = px.x(), z_left = p.norm();
      if (px.x() > right) right = px.x(), z_right = p.norm();
    }
    if (view.tilt_x_rad != 0.0 && view.tilt_y_rad == 0.0) {
      any_tilt_x = true;
      EXPECT_EQ(view.tilt_x_rad > 0.0, z_top < z_bottom) << view.sentence;
      EXPECT_NE(view.sentence.find(view.tilt_x_rad > 0.0 ? "its top towards" : "its bottom towards"),
                std::string::npos);
    }
    if (view.tilt_y_rad != 0.0 && view.tilt_x_rad == 0.0) {
      any_tilt_y = true;
      EXPECT_EQ(view.tilt_y_rad > 0.0, z_right < z_left) << view.sentence;
    }
  }
  EXPECT_TRUE(any_tilt_x || any_tilt_y);
}

TEST(NextViews, StayWithinReachAndWorkForSplinedAndWideLenses) {
  Session how;
  how.views = 40;
  CalibrateOptions options;
  for (const auto model : {camera::CameraModel::splined_stereographic, camera::CameraModel::fisheye}) {
    options.model = model;
    const auto found = calibrate(session(true_camera(), true_board(), how), true_board(), options);
    ASSERT_TRUE(found.ok());
    const auto next = next_views(*found, 2);
    ASSERT_EQ(next.size(), 2U);
    EXPECT_LT(next[0].picture_sigma_px, *picture_sigma_px(found->camera));
    for (const NextView& view : next) {
      EXPECT_GT(view.distance_m, 0.2);
      EXPECT_LT(view.distance_m, 2.5);
      for (const Eigen::Vector3d& x : target::corners_in_board(true_board())) {
        const auto px = camera::project(found->camera, view.cam_from_board * x);
        ASSERT_TRUE(px.has_value());
        EXPECT_TRUE(px->x() > 0 && px->y() > 0 && px->x() < 1279 && px->y() < 719);
      }
    }
  }
}

// The tilt of the boards is the thing that is missing where all are parallel to the picture.
TEST(NextViews, TiltTheBoardWhereAllWereParallel) {
  Session how;
  how.views = 30;
  how.largest_tilt_rad = 0.05;
  const auto views = session(true_camera(), true_board(), how);
  const auto found = calibrate(views, true_board());
  ASSERT_TRUE(found.ok());
  const auto next = next_views(*found, 1);
  ASSERT_EQ(next.size(), 1U);
  EXPECT_GT(std::hypot(next[0].tilt_x_rad, next[0].tilt_y_rad), 0.6) << next[0].sentence;
  const Verdict verdict = judge(*found, views);
  ASSERT_EQ(verdict.next_views.size(), 3U);
  EXPECT_EQ(verdict.gains.size(), views.size());
  EXPECT_NE(to_json(verdict).find(verdict.next_views[0].sentence), std::string::npos);
}

}  // namespace
}  // namespace furrow::calib
