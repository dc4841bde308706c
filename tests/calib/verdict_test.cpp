#include "furrow/calib/verdict.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "calib/synthetic.h"
#include "furrow/base/file.h"
#include "furrow/base/value.h"

namespace furrow::calib {
namespace {

const Criterion& criterion(const Verdict& verdict, const std::string& name) {
  const auto it = std::find_if(verdict.criteria.begin(), verdict.criteria.end(),
                               [&](const Criterion& c) { return c.name == name; });
  check(it != verdict.criteria.end(), "no such criterion");
  return *it;
}

Session good_session() {
  Session how;
  how.views = 30;
  return how;
}

TEST(Verdict, GoodSessionIsTrustedAndItsSigmaStays) {
  Camera camera = true_camera();
  camera.fy = camera.fx;
  const auto views = session(camera, true_board(), good_session());
  const auto found = calibrate(views, true_board());
  ASSERT_TRUE(found.ok());
  const Verdict verdict = judge(*found, views);
  EXPECT_TRUE(verdict.trusted) << verdict.summary;
  EXPECT_EQ(verdict.summary, "Enough.");
  EXPECT_LT(verdict.sigma_factor, 2.5);
  EXPECT_NEAR(verdict.halves_rms_px / verdict.halves_expected_rms_px, 1.0, 1.0);
  EXPECT_TRUE(base::parse_json(to_json(verdict), "v").ok());
}

// The ratio of the halves' difference to its prediction, over many sessions: its mean square must be 1.
TEST(Verdict, HalvesDifferByWhatTheirCovariancesPredict) {
  double ratio_squared = 0.0;
  constexpr int kTrials = 40;
  for (int trial = 0; trial < kTrials; ++trial) {
    Session how = good_session();
    how.seed = 500 + static_cast<std::uint64_t>(trial);
    const auto views = session(true_camera(), true_board(), how);
    const auto found = calibrate(views, true_board());
    ASSERT_TRUE(found.ok());
    const Verdict verdict = judge(*found, views);
    ratio_squared += std::pow(verdict.halves_rms_px / verdict.halves_expected_rms_px, 2) / kTrials;
  }
  EXPECT_NEAR(std::sqrt(ratio_squared), 1.0, 0.25);
}

TEST(Verdict, ParallelBoardsAreNamedAsSuch) {
  Session how = good_session();
  how.largest_tilt_rad = 0.03;
  const auto views = session(true_camera(), true_board(), how);
  const auto found = calibrate(views, true_board());
  if (!found.ok()) {
    EXPECT_EQ(found.error().code, "solve_failed");
    return;
  }
  const Verdict verdict = judge(*found, views);
  EXPECT_FALSE(verdict.trusted);
  EXPECT_FALSE(criterion(verdict, "tilt").met);
  EXPECT_NE(verdict.summary.find("cannot be told apart"), std::string::npos) << verdict.summary;
  EXPECT_TRUE(std::any_of(verdict.next_pictures.begin(), verdict.next_pictures.end(),
                          [](const std::string& s) { return s.find("tilt about x") != std::string::npos; }));
}

TEST(Verdict, BoardInOneCornerLacksCoverage) {
  auto views = session(true_camera(), true_board(), Session{60, 0.2, 0.7, 1.5, 2.5, 4});
  std::erase_if(views, [](const target::BoardDetection& view) {
    return std::any_of(view.corners_px.begin(), view.corners_px.end(),
                       [](const Eigen::Vector2d& p) { return p.x() > 640 || p.y() > 360; });
  });
  ASSERT_GE(views.size(), 6U);
  const auto found = calibrate(views, true_board());
  ASSERT_TRUE(found.ok()) << found.error().message();
  const Verdict verdict = judge(*found, views);
  EXPECT_FALSE(criterion(verdict, "coverage").met);
  EXPECT_TRUE(std::any_of(verdict.next_pictures.begin(), verdict.next_pictures.end(),
                          [](const std::string& s) { return s.find("lower right") != std::string::npos; }));
}

TEST(Verdict, StretchedBoardAndStretchedPicturesAreToldApart) {
  Camera square = true_camera();
  square.fy = square.fx;
  target::BoardSpec stretched = true_board();
  stretched.aspect = 1.02;
  const auto on_monitor = session(square, stretched, good_session());
  auto found = calibrate(on_monitor, true_board());
  ASSERT_TRUE(found.ok());
  Verdict verdict = judge(*found, on_monitor);
  EXPECT_FALSE(criterion(verdict, "aspect").met);
  EXPECT_NE(criterion(verdict, "aspect").sentence.find("squares are not square"), std::string::npos);
  Camera squashed = square;
  squashed.fy *= 1.02;
  Session rolled = good_session();
  rolled.largest_roll_rad = 1.5;  // without a roll both explanations fit
  const auto resampled = session(squashed, true_board(), rolled);
  found = calibrate(resampled, true_board());
  ASSERT_TRUE(found.ok());
  verdict = judge(*found, resampled);
  EXPECT_TRUE(criterion(verdict, "aspect").met);
  EXPECT_NE(criterion(verdict, "aspect").sentence.find("pictures themselves"), std::string::npos);
}

/// The first pictures of one session and the last of another, as one set.
std::vector<target::BoardDetection> zoomed_after(std::size_t first, const Camera& before,
                                                 const Camera& after) {
  auto views = session(before, true_board(), good_session());
  Session how = good_session();
  how.seed = 9;
  const auto others = session(after, true_board(), how);
  for (std::size_t i = first; i < views.size(); ++i) {
    views[i].corners_px = others[i].corners_px;
  }
  return views;
}

TEST(Verdict, ZoomInMidSetIsNamedWithItsPicture) {
  Camera camera = true_camera();
  camera.fy = camera.fx;
  for (const double zoom : {1.03, 1.3}) {
    Camera longer = camera;
    longer.fx *= zoom;
    longer.fy *= zoom;
    const auto views = zoomed_after(18, camera, longer);
    const auto found = calibrate(views, true_board());
    ASSERT_TRUE(found.ok());
    const Verdict verdict = judge(*found, views);
    EXPECT_FALSE(verdict.trusted);
    EXPECT_FALSE(criterion(verdict, "zoom").met) << zoom;
    EXPECT_NEAR(criterion(verdict, "zoom").value, 100.0 * (zoom - 1.0), 1.5);
    EXPECT_NE(verdict.summary.find("up to view_117.jpg"), std::string::npos) << verdict.summary;
    EXPECT_NE(verdict.summary.find("from view_118.jpg on"), std::string::npos) << verdict.summary;
  }
  const auto views = session(camera, true_board(), good_session());
  EXPECT_TRUE(criterion(judge(*calibrate(views, true_board()), views), "zoom").met);
}

TEST(Verdict, BentBoardIsNamedWhenItMovesTheFocalLength) {
  Camera camera = true_camera();
  camera.fy = camera.fx;
  const auto bent = session(camera, true_board(), good_session(), {0.003, 0.002});
  CalibrateOptions options;
  auto found = calibrate(bent, true_board(), options);
  ASSERT_TRUE(found.ok());
  const Verdict verdict = judge(*found, bent, options);
  EXPECT_FALSE(criterion(verdict, "bend").met) << criterion(verdict, "bend").sentence;
  EXPECT_NE(verdict.summary.find("--warp"), std::string::npos) << verdict.summary;
  EXPECT_NE(verdict.summary.find("a board bent by "), std::string::npos) << verdict.summary;
  options.solve_warp = true;
  found = calibrate(bent, true_board(), options);
  EXPECT_TRUE(criterion(judge(*found, bent, options), "bend").met);
  const auto flat = session(camera, true_board(), good_session());
  EXPECT_TRUE(criterion(judge(*calibrate(flat, true_board()), flat), "bend").met);
}

TEST(Verdict, TurnedPicturesAreWarnedOf) {
  auto views = session(true_camera(), true_board(), good_session());
  EXPECT_TRUE(calibrate(views, true_board())->warnings.empty());
  views[4].exif_orientation = 6;
  const auto found = calibrate(views, true_board());
  ASSERT_EQ(found->warnings.size(), 1U);
  EXPECT_NE(found->warnings[0].find("1 of 30 pictures ask to be turned"), std::string::npos);
  EXPECT_NE(found->warnings[0].find("view_104.jpg"), std::string::npos);
}

TEST(Verdict, WidenedCameraCarriesTheFactor) {
  const auto views = session(true_camera(), true_board(), Session{});
  const auto found = calibrate(views, true_board());
  ASSERT_TRUE(found.ok());
  Verdict verdict;
  verdict.sigma_factor = 3.0;
  const Camera camera = widened_camera(*found, verdict);
  EXPECT_NEAR(camera.covariance(0, 0), 9.0 * found->camera.covariance(0, 0), 1e-12);
  EXPECT_NE(camera.provenance.find("3.0 times"), std::string::npos);
}

// Its RMS looks well, and its focal length runs from 1406 to 2623 px with the solver: nothing to fly by.
TEST(VerdictReal, TelloIsNotTrusted) {
  const char* set = std::getenv("FURROW_DATA");
  const std::filesystem::path data =
      set != nullptr ? set : std::filesystem::path(FURROW_SOURCE_DIR) / "../shared/data";
  const auto files = base::expand_pattern("calib/tello-archdrone/images/*.jpg", data);
  if (!files.ok()) GTEST_SKIP() << "no pictures: " << files.error().message() << " (set FURROW_DATA)";
  const target::BoardSpec board{"tello", 7, 7, 0.03, 1.0};
  const auto detections = target::detect_boards(*files, board);
  EXPECT_EQ(std::count_if(detections.begin(), detections.end(), [](const auto& d) { return d.found; }), 19);
  const auto found = calibrate(detections, board);
  ASSERT_TRUE(found.ok()) << found.error().message();
  const Verdict verdict = judge(*found, detections);
  EXPECT_FALSE(verdict.trusted);
  EXPECT_FALSE(criterion(verdict, "focal_sigma").met);
  EXPECT_EQ(verdict.summary.rfind("Do not trust", 0), 0U);
}

}  // namespace
}  // namespace furrow::calib
