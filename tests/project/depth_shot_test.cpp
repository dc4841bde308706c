// A shot with a depth map: the thesis's height from the distance at its middle, and that of all of the map.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "furrow/base/file.h"
#include "furrow/geom/angles.h"
#include "furrow/image/image.h"
#include "project/shot_chain.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 1024, kHeight = 320;
constexpr double kFocalPx = 873.35, kPitchDeg = -13.8, kAboveCanopy_m = 1.312;

Camera camera() {
  Camera camera;
  camera.width = kWidth, camera.height = kHeight;
  camera.fx = camera.fy = kFocalPx;
  camera.cx = 0.5 * kWidth, camera.cy = 0.5 * kHeight;
  return camera;
}

/// Metres along the optical axis to a level canopy; 0, which is not known, above its horizon.
std::vector<float> level_canopy() {
  const double pitch = geom::deg_to_rad(kPitchDeg);
  std::vector<float> metres;
  for (int v = 0; v < kHeight; ++v) {
    const double drop = std::cos(pitch) * (v - 0.5 * kHeight) / kFocalPx - std::sin(pitch);
    metres.insert(metres.end(), kWidth, drop > 0.05 ? static_cast<float>(kAboveCanopy_m / drop) : 0.0F);
  }
  return metres;
}

float& middle_of(std::vector<float>& map) {
  return map[static_cast<std::size_t>(kHeight / 2 * kWidth + kWidth / 2)];
}

/// A network's answer that means these metres.
std::vector<float> as_disparity(std::vector<float> map) {
  for (float& value : map)
    if (value > 0.0F) value = (5.4F / value - 0.01F) / 9.99F;
  return map;
}

class DepthShot : public ::testing::Test {
 protected:
  DepthShot()
      : folder_(fs::temp_directory_path() / ("furrow_depth_shot_test_" + std::to_string(::getpid()))) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    shot_.shot_id = "a1", shot_.image = folder_ / "a1.png";
    EXPECT_TRUE(image::write_image(shot_.image, image::make_image(kWidth, kHeight, 3)).ok());
    pose_.state.gimbal_pitch_deg = kPitchDeg;
    project_.depth = ProjectDepth{{folder_ / "other.pfm", folder_ / "a1.pfm"}, false, 1.0, 0.05};
    project_.field.row_height_m = {1.7, 0.05, 1};
  }
  ~DepthShot() override { fs::remove_all(folder_); }

  /// The shot with this map, whose rows a .pfm has from bottom to top.
  ShotResult process(const std::vector<float>& map) {
    std::string bytes = "Pf\n" + std::to_string(kWidth) + " " + std::to_string(kHeight) + "\n-1.0\n";
    for (int v = kHeight; v-- > 0;)
      bytes.append(reinterpret_cast<const char*>(map.data() + static_cast<std::ptrdiff_t>(v) * kWidth),
                   kWidth * sizeof(float));
    EXPECT_TRUE(base::write_file(folder_ / "a1.pfm", bytes).ok());
    return process_shot(shot_, pose_, camera(), project_);
  }

  fs::path folder_;
  telemetry::Shot shot_;
  sync::ShotPose pose_;
  Project project_;
};

TEST_F(DepthShot, MetresGiveTheThesissHeightAndThatOfAllOfTheMap) {
  const ShotResult result = process(level_canopy());
  EXPECT_EQ(result.depth_reason, "");
  const Estimate& thesis = result.record.above_canopy_depth_thesis_m;
  EXPECT_NEAR(thesis.value, kAboveCanopy_m, 1e-4);
  EXPECT_TRUE(std::isnan(thesis.sigma));  // the thesis gives none
  EXPECT_EQ(thesis.observations, 1);
  EXPECT_NEAR(result.record.above_canopy_depth_m.value, kAboveCanopy_m, 0.02);
  EXPECT_TRUE(result.record.above_canopy_depth_m.usable());
  EXPECT_EQ(result.depth.above_canopy_m.value, result.record.above_canopy_depth_m.value);
}

// The thesis takes a network's distance as it is; all of the map is put right for the lens (fx over the
// width).
TEST_F(DepthShot, OfANetworkOnlyAllOfTheMapHearsOfTheFocalLength) {
  project_.depth->disparity = true;
  const ShotResult result = process(as_disparity(level_canopy()));
  EXPECT_EQ(result.depth_reason, "");
  EXPECT_NEAR(result.record.above_canopy_depth_thesis_m.value, kAboveCanopy_m, 1e-3);
  const double factor = kFocalPx / kWidth / 0.58;
  EXPECT_NEAR(result.record.above_canopy_depth_m.value, factor * kAboveCanopy_m, 0.03);
}

TEST_F(DepthShot, AHoleAtTheMiddleTakesOnlyTheThesissHeight) {
  std::vector<float> map = level_canopy();
  middle_of(map) = 0.0F;
  const ShotResult result = process(map);
  EXPECT_TRUE(std::isnan(result.record.above_canopy_depth_thesis_m.value));
  EXPECT_EQ(result.record.above_canopy_depth_thesis_m.observations, 0);
  EXPECT_NEAR(result.record.above_canopy_depth_m.value, kAboveCanopy_m, 0.02);
}

// Neither height without a pitch; nor with one at the horizon, from which no distance means a height.
TEST_F(DepthShot, WithoutAPitchBelowTheHorizonThereIsNoHeight) {
  pose_.state.gimbal_pitch_deg = std::nan("");
  const ShotResult untold = process(level_canopy());
  EXPECT_TRUE(std::isnan(untold.record.above_canopy_depth_thesis_m.value));
  EXPECT_TRUE(std::isnan(untold.record.above_canopy_depth_m.value));
  EXPECT_EQ(untold.depth_reason, "");  // nothing is wrong with the map
  pose_.state.gimbal_pitch_deg = 0.0;
  EXPECT_TRUE(std::isnan(process(level_canopy()).record.above_canopy_depth_thesis_m.value));
}

TEST_F(DepthShot, AMapThatCannotBeReadSaysSo) {
  process(level_canopy());
  EXPECT_TRUE(base::write_file(folder_ / "a1.pfm", "Pf\n1 1\n").ok());
  const ShotResult result = process_shot(shot_, pose_, camera(), project_);
  EXPECT_NE(result.depth_reason.find("a1.pfm"), std::string::npos) << result.depth_reason;
  EXPECT_TRUE(std::isnan(result.record.above_canopy_depth_thesis_m.value));
}

}  // namespace
}  // namespace furrow::project
