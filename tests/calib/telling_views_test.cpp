// Which pictures are shown, which part of them, and where the board's axes run.
#include "furrow/calib/telling_views.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "calib/synthetic.h"

namespace furrow::calib {
namespace {

/// Twelve good views, one of them with a corner far off, one blurred as a whole, a copy, and a picture without a board.
std::vector<target::BoardDetection> mixed_session() {
  auto detections = session(true_camera(), true_board(), {});
  for (std::size_t i = 0; i < detections.size(); ++i) {
    detections[i].sha256 = "picture " + std::to_string(i);
    detections[i].search_steps = 1000;
  }
  detections[3].corners_px[7] += Eigen::Vector2d(9.0, 0.0);
  base::Random random(5);
  for (auto& px : detections[5].corners_px) px += Eigen::Vector2d(random.normal(0, 4.0), random.normal(0, 4.0));
  target::BoardDetection copy = detections[2], without = detections[1];
  copy.found = without.found = false;
  copy.corners_px.clear();
  without.corners_px.clear();
  copy.reason = "byte-identical to view_102.jpg";
  without.reason = "no board of 9x6 inner corners found";
  copy.image = "copy.jpg";
  without.image = "without.jpg";
  without.sha256 = "without";
  detections.push_back(copy);
  detections.push_back(without);
  return detections;
}

TEST(TellingViews, AreTheBestTheMedianTheWorstThatWithOutliersAndThoseNotUsed) {
  const auto detections = mixed_session();
  CalibrateOptions options;
  options.view_outlier_ratio = 3.0;
  options.corner_outlier_sigmas = 6.0;
  const auto calibration = calibrate(detections, true_board(), options);
  ASSERT_TRUE(calibration.ok()) << calibration.error().message();
  ASSERT_FALSE(calibration->views[5].used);
  const TellingViews telling = telling_views(*calibration, detections);
  ASSERT_GE(telling.views.size(), 4u);
  ASSERT_LE(telling.views.size(), 5u);
  std::vector<double> rms_px;
  for (const View& view : calibration->views) {
    if (view.used) rms_px.push_back(view.rms_px);
  }
  std::sort(rms_px.begin(), rms_px.end());
  const auto rms_of = [&](std::size_t shown) { return calibration->views[telling.views[shown].view].rms_px; };
  EXPECT_EQ(rms_of(0), rms_px.front());
  EXPECT_EQ(rms_of(1), rms_px[rms_px.size() / 2]);
  EXPECT_EQ(rms_of(2), rms_px.back());
  const auto why = [&](std::size_t view) -> std::string {
    for (const TellingView& one : telling.views) {
      if (one.view == view) return one.why;
    }
    return "";
  };
  EXPECT_NE(why(3).find("most corners left out"), std::string::npos);
  EXPECT_EQ(why(5), "not used");
  EXPECT_EQ(why(12), "") << "a copy shows nothing new";
}

TEST(TellingViews, APictureWithoutABoardIsShownAndACopyIsNot) {
  const auto detections = mixed_session();
  const auto calibration = calibrate(detections, true_board());
  ASSERT_TRUE(calibration.ok());
  const TellingViews telling = telling_views(*calibration, detections);
  ASSERT_EQ(telling.views.size(), 4u);
  EXPECT_EQ(telling.views.back().view, 13u);
  EXPECT_TRUE(telling.views.back().x_axis_px.empty());
  EXPECT_EQ(telling.views.back().width_px, true_camera().width);
}

TEST(TellingViews, ShowThePartAroundASmallBoardAndAxesFromItsFirstCorner) {
  Session how;
  how.nearest_m = 1.2;
  how.farthest_m = 1.6;
  how.noise_px = 0.05;
  const auto detections = session(true_camera(), true_board(), how);
  const auto calibration = calibrate(detections, true_board());
  ASSERT_TRUE(calibration.ok());
  for (const TellingView& one : telling_views(*calibration, detections).views) {
    const View& view = calibration->views[one.view];
    EXPECT_LT(one.width_px, true_camera().width);
    EXPECT_GE(std::min(one.left_px, one.top_px), 0);
    EXPECT_LE(one.left_px + one.width_px, true_camera().width);
    EXPECT_LE(one.top_px + one.height_px, true_camera().height);
    for (const auto& px : view.observed_px) {
      EXPECT_TRUE(px.x() > one.left_px - 0.5 && px.x() < one.left_px + one.width_px - 0.5);
      EXPECT_TRUE(px.y() > one.top_px - 0.5 && px.y() < one.top_px + one.height_px - 0.5);
    }
    ASSERT_EQ(one.x_axis_px.size(), 3u);
    ASSERT_EQ(one.y_axis_px.size(), 3u);
    // Rows of nine corners: the third of the first row, and the first of the third row.
    EXPECT_LT((one.x_axis_px[2] - (view.observed_px[2] - view.residual_px[2])).norm(), 1e-9);
    EXPECT_LT((one.y_axis_px[2] - (view.observed_px[18] - view.residual_px[18])).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace furrow::calib
