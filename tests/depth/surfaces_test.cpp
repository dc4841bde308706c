// Maps drawn from two level planes, canopy and soil, seen by a pitched camera.
#include "furrow/depth/surfaces.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"
#include "furrow/geom/attitude.h"

namespace furrow::depth {
namespace {

constexpr double kRowHeight = 1.7, kSpacing = 3.0, kHalfWidth = 0.6;

Camera test_camera() {
  Camera camera;
  camera.width = 1280, camera.height = 720;
  camera.fx = 874.33, camera.fy = 872.39, camera.cx = 640.49, camera.cy = 360.81;
  return camera;
}

/// Tops of rows along the view and the soil between them; no walls. `factor` is an error of the map's scale.
DepthMap draw_map(double height, double pitch_rad, double factor, double noise, base::Random& random) {
  DepthMap map{320, 96, {}};
  const Camera camera = camera::resize_camera(test_camera(), map.width, map.height);
  const Eigen::Matrix3d cam_from_level = geom::cam_from_level({0.0, pitch_rad, 0.0});
  for (int v = 0; v < map.height; ++v) {
    for (int u = 0; u < map.width; ++u) {
      const Eigen::Vector2d px(u, v);
      const auto ray = camera::unproject(camera, px);
      const Eigen::Vector3d d = cam_from_level.transpose() * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
      double z = std::numeric_limits<double>::quiet_NaN();
      if (d.z() < 0.0) {
        z = -height / d.z();
        const double beside = std::remainder(z * d.y(), kSpacing);
        if (std::abs(beside) > kHalfWidth) z = -(height + kRowHeight) / d.z();
        z *= factor * (1.0 + random.normal(0.0, noise));
      }
      map.values.push_back(static_cast<float>(z));
    }
  }
  return map;
}

SurfaceInput input_of(DepthMap map, double pitch_rad) {
  const double degree = geom::deg_to_rad(1.0);
  return {std::move(map),
          test_camera(),
          {pitch_rad, 0.3 * degree, 1},
          {0.0, 0.3 * degree, 1},
          {kRowHeight, 0.05, 1}};
}

TEST(HeightFromMap, IsExactForAPerfectMap) {
  base::Random random(1);
  for (const double pitch_deg : {-12.4, -30.0, -60.0, -90.0}) {
    const double pitch = geom::deg_to_rad(pitch_deg);
    const auto height = height_from_map(input_of(draw_map(6.0, pitch, 1.0, 0.0, random), pitch));
    ASSERT_TRUE(height.ok()) << height.error().message();
    EXPECT_NEAR(height->above_canopy_m.value, 6.0, 1e-3) << pitch_deg;
    EXPECT_GT(height->soil_share, 0.3);
    EXPECT_LT(height->soil_share, 0.9);
  }
}

/// A level plane under the camera.
DepthMap draw_plane(double height, double pitch_rad) {
  DepthMap map{320, 96, {}};
  const Camera camera = camera::resize_camera(test_camera(), map.width, map.height);
  for (int v = 0; v < map.height; ++v) {
    for (int u = 0; u < map.width; ++u) {
      const auto ray = camera::unproject(camera, {static_cast<double>(u), static_cast<double>(v)});
      const Eigen::Vector3d d =
          geom::cam_from_level({0.0, pitch_rad, 0.0}).transpose() * Eigen::Vector3d(ray->x(), ray->y(), 1.0);
      map.values.push_back(d.z() < 0.0 ? static_cast<float>(-height / d.z()) : std::nanf(""));
    }
  }
  return map;
}

TEST(HeightFromMap, APlaneTellsItsOwnPitch) {
  const double pitch = geom::deg_to_rad(-35.0);
  const auto height = height_from_map(input_of(draw_plane(3.0, pitch), pitch));
  ASSERT_TRUE(height.ok()) << height.error().message();
  EXPECT_NEAR(height->plane_pitch_rad, pitch, 1e-4);
  EXPECT_NEAR(height->plane_height_m, 3.0, 1e-3);
}

// Scale, pitch and noise drawn from their sigmas: the truth lies inside one and two of them as often as
// claimed.
TEST(HeightFromMap, ItsSigmaHolds) {
  base::Random random(3);
  constexpr int kTrials = 300;
  int in_one = 0, in_two = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double pitch = geom::deg_to_rad(random.uniform(-60.0, -15.0)), truth = random.uniform(1.5, 6.0);
    const double factor = 1.0 + random.normal(0.0, 0.1);
    SurfaceInput input = input_of(draw_map(truth, pitch, factor, 0.02, random), pitch);
    input.pitch_rad.value += random.normal(0.0, input.pitch_rad.sigma);
    const auto height = height_from_map(input);
    ASSERT_TRUE(height.ok()) << i << height.error().message();
    const double away = std::abs(height->above_canopy_m.value - truth) / height->above_canopy_m.sigma;
    in_one += away < 1.0;
    in_two += away < 2.0;
  }
  std::printf("within 1 sigma %.3f, 2 sigma %.3f\n", in_one / double(kTrials), in_two / double(kTrials));
  EXPECT_NEAR(in_one / double(kTrials), 0.683, 0.08);
  EXPECT_NEAR(in_two / double(kTrials), 0.954, 0.04);
}

// Nobody knows whether a single level is leaves or soil.
TEST(HeightFromMap, OneLevelOnlyLeavesTheSurfaceOpen) {
  const double pitch = geom::deg_to_rad(-40.0);
  const SurfaceInput input = input_of(draw_plane(3.0, pitch), pitch);
  const auto height = height_from_map(input);
  ASSERT_TRUE(height.ok()) << height.error().message();
  EXPECT_GT(height->above_canopy_m.sigma, 1.6);
}

TEST(HeightFromMap, NamesWhatIsMissing) {
  base::Random random(5);
  SurfaceInput input = input_of(draw_map(3.0, -0.5, 1.0, 0.0, random), -0.5);
  input.pitch_rad = {};
  EXPECT_EQ(height_from_map(input).error().code, "no_pitch");
  input = input_of(DepthMap{4, 4, std::vector<float>(16, 2.0F)}, -0.5);
  EXPECT_EQ(height_from_map(input).error().code, "map_too_small");
  // All at one z: a wall, no level ground.
  input = input_of(DepthMap{320, 96, std::vector<float>(320 * 96, 5.0F)}, -0.2);
  EXPECT_EQ(height_from_map(input).error().code, "no_surface");
}

}  // namespace
}  // namespace furrow::depth
