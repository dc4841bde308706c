#include "furrow/project/plan_job.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;

/// The thesis's flight at 4 m above ground.
PlanRequest thesis_request() {
  PlanRequest request;
  request.camera =
      plan_camera({.focal_mm = 8.8, .sensor_mm = 13.2, .width_px = 1280, .height_px = 720}).value();
  request.field.row_spacing_m = {3.0, 0.03, 1};
  request.field.half_width_m = {0.6, 0.06, 1};
  request.field.row_height_m = {1.7, 0.05, 1};
  request.pose.height_above_canopy_m = 2.3;
  request.pose.pitch_rad = geom::deg_to_rad(-13.8);
  return request;
}

TEST(PlanCamera, TakesPixelsOrMillimetres) {
  EXPECT_NEAR(thesis_request().camera.fx, 853.33, 0.01);
  EXPECT_EQ(thesis_request().camera.cx, 639.5);
  EXPECT_EQ(plan_camera({.focal_px = 800.0, .width_px = 640, .height_px = 480})->fx, 800.0);
  EXPECT_EQ(plan_camera({.focal_px = 800.0}).error().code, "bad_lens");
  // A plan of so many pixels never ended.
  constexpr int kMost = std::numeric_limits<int>::max();
  EXPECT_EQ(plan_camera({.focal_px = 1e9, .width_px = kMost, .height_px = kMost}).error().code,
            "camera_invalid");
  EXPECT_EQ(plan_camera({.focal_mm = 8.8, .width_px = 640, .height_px = 480}).error().code, "bad_lens");
}

TEST(PlanJob, SaysWhatToExpectAndWritesTables) {
  const fs::path folder = fs::temp_directory_path() / ("furrow_plan_test_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  const auto outcome = plan_job(thesis_request(), folder);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message();
  ASSERT_TRUE(outcome->shot.ok());
  EXPECT_EQ(outcome->words.size(), 3U);
  const auto budget = base::read_csv(folder / "plan_budget.csv").value();
  double percent = 0.0, squares = 0.0;
  for (const auto& row : budget.rows) {
    percent += base::parse_double(row[2]).value();
    squares += std::pow(base::parse_double(row[1]).value(), 2);
  }
  EXPECT_NEAR(percent, 100.0, 0.3);
  EXPECT_NEAR(std::sqrt(squares), outcome->shot->height_above_canopy_m.sigma, 2e-4);
  EXPECT_EQ(base::read_csv(folder / "plan.csv")->rows[0][0], "planned");
  EXPECT_TRUE(fs::exists(folder / "plan_over_pitch.png"));
  EXPECT_TRUE(fs::exists(folder / "plan_over_height.svg"));
  fs::remove_all(folder);
}

TEST(PlanJob, NamesWhatNoOtherPoseCanMend) {
  PlanRequest request = thesis_request();
  request.pose.pitch_rad = 0.2;
  EXPECT_EQ(plan_job(request).error().code, "bad_pose");
  request = thesis_request();
  request.field.row_spacing_m = {};
  EXPECT_EQ(plan_job(request).error().code, "no_spacing");
  request = thesis_request();
  request.field.row_spacing_m = {0.05, 0.001, 1};
  request.field.half_width_m = {0.01, 0.001, 1};
  request.pose.height_above_canopy_m = 200.0;
  EXPECT_EQ(plan_job(request).error().code, "no_plan");
}

// A pose without a height still gets advice.
TEST(PlanJob, AdvisesWhereThePoseItselfHasNoHeight) {
  PlanRequest request = thesis_request();
  request.pose = {1.3, geom::deg_to_rad(-85.0), 0.0, 0.0};  // one row in the picture
  const auto outcome = plan_job(request);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message();
  EXPECT_FALSE(outcome->shot.ok());
  EXPECT_TRUE(outcome->advice.best_pitch);
  EXPECT_NE(outcome->words[1].find("A better pitch"), std::string::npos);
}

}  // namespace
}  // namespace furrow::project
