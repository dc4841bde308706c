// The view from above, against a world whose every metre is known.
#include "furrow/altitude/birds_eye.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "altitude/field_generator.h"
#include "furrow/geom/angles.h"

namespace furrow::altitude {
namespace {

using geom::deg_to_rad;

testing::World world() {
  testing::World w;
  w.height_above_canopy_m = 2.5;
  w.attitude = {deg_to_rad(3.0), deg_to_rad(-30.0), deg_to_rad(-1.0)};
  w.cross_track_m = 0.4;
  return w;
}

RefinedShot pose_of(const testing::World& w) {
  RefinedShot shot;
  shot.height_above_canopy_m.value = w.height_above_canopy_m;
  shot.yaw_rad.value = w.attitude.yaw_rad;
  shot.pitch_rad.value = w.attitude.pitch_rad;
  shot.roll_rad.value = w.attitude.roll_rad;
  shot.cross_track_m.value = w.cross_track_m;
  shot.row_spacing_m.value = w.spacing_m;
  shot.half_width_m.value = w.half_width_m;
  shot.usable = true;
  return shot;
}

/// Grey 200 where the ground point's lateral place is within 0.1 m of a row's axis, else 40.
Image striped(const testing::World& w, const Camera& camera) {
  Image picture = image::make_image(camera.width, camera.height, 3);
  const Eigen::Matrix3d row_from_cam = geom::cam_from_level(w.attitude).transpose();
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      const auto direction = camera::unproject(camera, {u, v});
      const Eigen::Vector3d ray = row_from_cam * Eigen::Vector3d(direction->x(), direction->y(), 1.0);
      const double left = ray.y() * w.height_above_canopy_m / -ray.z() + w.cross_track_m;
      const bool axis = ray.z() < 0.0 && std::abs(std::remainder(left, w.spacing_m)) < 0.1;
      std::fill_n(picture.at(u, v), 3, static_cast<std::uint8_t>(axis ? 200 : 40));
    }
  }
  return picture;
}

TEST(BirdsEye, RowsRunUprightAtTheirPlaces) {
  const auto w = world();
  const Camera camera = testing::thesis_camera();
  const auto lines = testing::picture_of(w, camera);
  const auto view = birds_eye(striped(w, camera), lines, camera, pose_of(w));
  ASSERT_TRUE(view.ok()) << view.error().message();
  EXPECT_LE(std::max(view->picture.width, view->picture.height), 1000);
  int seen = 0;
  for (int k = -1; k <= 1; ++k) {
    const double left_m = -w.cross_track_m - k * w.spacing_m;
    const int u = static_cast<int>((view->left_m - left_m) * view->px_per_m);
    for (int v = 0; v < view->picture.height; ++v) {
      const int value = view->picture.at(u, v)[0];
      if (value == 0) continue;  // outside the picture
      EXPECT_GT(value, 150) << "row " << k << " at " << v;
      ++seen;
    }
  }
  EXPECT_GT(seen, 500);
}

TEST(BirdsEye, FoundEdgesLieAtTheRowsEdges) {
  const auto w = world();
  const Camera camera = testing::thesis_camera();
  const auto lines = testing::picture_of(w, camera);
  const auto view = birds_eye(striped(w, camera), lines, camera, pose_of(w));
  ASSERT_TRUE(view.ok()) << view.error().message();
  int seen = 0;
  for (const GroundRow& row : view->rows) {
    if (row.index > 0) continue;  // of rows to the left the left edge is the top's
    seen += static_cast<int>(row.left_m.size());
    for (const auto& point : row.left_m)
      EXPECT_NEAR(point.y(), -w.cross_track_m - row.index * w.spacing_m + w.half_width_m, 0.02) << row.index;
  }
  EXPECT_GT(seen, 20);
}

TEST(BirdsEye, StraightDownToo) {
  auto w = world();
  w.height_above_canopy_m = 20.0;
  w.attitude = {0.0, deg_to_rad(-90.0), 0.0};
  const Camera camera = testing::thesis_camera();
  const auto view = birds_eye(striped(w, camera), testing::picture_of(w, camera), camera, pose_of(w));
  ASSERT_TRUE(view.ok()) << view.error().message();
  EXPECT_LT(view->ahead_m - view->picture.height / view->px_per_m, 0.0);  // the ground behind is seen too
}

TEST(BirdsEye, NothingIsSeenWhereTheLensFoldsBack) {
  auto w = world();
  Camera camera = testing::thesis_camera();
  camera.model = camera::CameraModel::opencv4;
  camera.distortion = {-0.35, 0.0, 0.0,
                       0.0};  // folds at 0.98 on the unit plane, beyond the picture's corners
  w.height_above_canopy_m = 1.2;
  w.attitude = {0.0, deg_to_rad(-12.0), 0.0};
  const auto view = birds_eye(striped(w, camera), testing::picture_of(w, camera), camera, pose_of(w));
  ASSERT_TRUE(view.ok()) << view.error().message();
  const double fold = *camera::fold_radius(camera);
  const Eigen::Matrix3d cam_from_row = geom::cam_from_level(w.attitude);
  int beyond = 0;
  for (int v = 0; v < view->picture.height; ++v) {
    for (int u = 0; u < view->picture.width; ++u) {
      const Eigen::Vector3d point =
          cam_from_row * Eigen::Vector3d(view->ahead_m - (v + 0.5) / view->px_per_m,
                                         view->left_m - (u + 0.5) / view->px_per_m, -w.height_above_canopy_m);
      if (point.z() <= 0.0 || point.head<2>().norm() < fold * point.z()) continue;
      ++beyond;
      ASSERT_EQ(view->picture.at(u, v)[0], 0) << u << ", " << v;
    }
  }
  EXPECT_GT(beyond, 1000);
}

TEST(BirdsEye, NoGroundNoPoseNoFit) {
  auto w = world();
  const Camera camera = testing::thesis_camera();
  const auto lines = testing::picture_of(w, camera);
  const Image picture = striped(w, camera);
  auto shot = pose_of(w);
  shot.pitch_rad.value = deg_to_rad(60.0);  // into the sky
  EXPECT_EQ(birds_eye(picture, lines, camera, shot).error().code, "no_ground");
  shot.usable = false;
  EXPECT_EQ(birds_eye(picture, lines, camera, shot).error().code, "not_refined");
  EXPECT_EQ(birds_eye(image::make_image(64, 36, 3), lines, camera, pose_of(w)).error().code,
            "picture_size_differs");
}

}  // namespace
}  // namespace furrow::altitude
