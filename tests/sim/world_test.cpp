#include "furrow/sim/world.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "furrow/base/random.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/simulate.h"
#include "sim/canopy.h"
#include "sim/lens.h"

namespace furrow::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// One still shot over rows without gaps, posts or grass.
Scene still_scene(double height_m, double pitch_deg) {
  Scene scene = empty_scene();
  scene.seed = 5;
  scene.flight.wander = {0, 0, 0, 0, 0};
  scene.log.gimbal_roll_bias_deg = 0.0;
  scene.field.gap_probability = scene.field.grass_cover = scene.field.post_spacing_m = 0.0;
  scene.pictures.noise = 0.0;
  Leg leg;
  leg.height_above_ground_m = leg.end_height_above_ground_m = height_m;
  leg.pitch_deg = leg.end_pitch_deg = pitch_deg;
  leg.shots = 1;
  scene.flight.legs = {leg};
  return scene;
}

/// Leaves are greener than red; the test scenes' soil, lit or in shadow, is redder than green.
bool green(const Image& picture, int u, int v) {
  const std::uint8_t* px = picture.at(u, v);
  return static_cast<int>(px[1]) > static_cast<int>(px[0]) + 4;
}

Vector2d pixel_of(const Scene& scene, const ShotTruth& shot, double s, double l, double height_m) {
  const auto px =
      camera::project(scene.camera, shot.cam_from_world * world_from_row(scene, {s, l, height_m}));
  EXPECT_TRUE(px.has_value());
  return px.value_or(Vector2d::Zero());
}

/// Part of a row's length that is green at lateral place l on the plane of the row tops.
double cover(const Scene& scene, const ShotTruth& shot, const Image& picture, double s0, double s1,
             double l) {
  int hits = 0, all = 0;
  for (double s = s0; s < s1; s += 0.02) {
    const Vector2d px = pixel_of(scene, shot, s, l, scene.field.row_height_m);
    const int u = static_cast<int>(std::lround(px.x())), v = static_cast<int>(std::lround(px.y()));
    if (u < 0 || v < 0 || u >= picture.width || v >= picture.height) continue;
    hits += green(picture, u, v);
    ++all;
  }
  return all > 0 ? static_cast<double>(hits) / all : 0.0;
}

/// Lateral place where cover falls through one half, going outwards from `from` to `to`.
double half_cover(const Scene& scene, const ShotTruth& shot, const Image& picture, double s0, double s1,
                  double from, double to) {
  const int steps = 200;
  double last = 1.0;
  for (int i = 0; i <= steps; ++i) {
    const double l = from + (to - from) * i / steps;
    const double here = cover(scene, shot, picture, s0, s1, l);
    if (here < 0.5) return l - (to - from) / steps * (0.5 - here) / std::max(last - here, 1e-9);
    last = here;
  }
  return to;
}

TEST(World, MeanSilhouetteFromAboveIsTheStatedWidthAndPlace) {
  // 8.3 m over the row tops a pixel is 1 cm. Roughness, whose mean over 6 m is not 0, is left out.
  Scene scene = still_scene(10.0, -90.0);
  scene.field.width_roughness_m = scene.field.height_roughness_m = 0.0;
  const auto shots = true_shots(scene);
  const Image picture = Renderer(scene).shot(0);
  const double s = shots[0].along_row_m;
  for (int row : {-1, 0, 1}) {
    const double l = row * scene.field.spacing_m;
    const double left = half_cover(scene, shots[0], picture, s - 3, s + 3, l + 0.3, l + 1.0);
    const double right = half_cover(scene, shots[0], picture, s - 3, s + 3, l - 0.3, l - 1.0);
    // The outer rows are seen 20 deg from above: leaves that stand up widen them by up to tan(20 deg) times a
    // leaf's radius at each side.
    EXPECT_NEAR(0.5 * (left - right), scene.field.half_width_m + (row == 0 ? 0.0 : 0.01),
                row == 0 ? 0.015 : 0.025)
        << "row " << row;
    // Were the tops 5 cm off their plane, the outer rows would stand 5 cm x 3 / 8.3 = 1.8 cm off.
    EXPECT_NEAR(0.5 * (left + right), l, 0.018) << "row " << row;
  }
}

TEST(World, EveryLevelOfTheCanopyHasTheStatedShape) {
  const Scene scene = still_scene(3.0, -12.4);
  const Canopy canopy(scene);
  for (int level = 0; level < Canopy::kLevels; ++level) {
    std::vector<Leaf> leaves;
    // Other pieces than those on which the canopy was fitted.
    for (int piece = 100; piece < 206; ++piece) canopy.append_piece(0, piece, level, 0.0, 0, leaves);
    for (Leaf& leaf : leaves) leaf.centre.x() -= 103.0F;
    const Silhouette seen = measure_silhouette(leaves, 100.0, scene.field.half_width_m);
    // Coarse leaves are few, and so measure less exactly; they are drawn where 2 cm are under a pixel.
    const bool fine = Canopy::stretch_of(level) * Canopy::widen_of(level) <= 4.0;
    EXPECT_NEAR(seen.half_width_m, scene.field.half_width_m, fine ? 0.012 : 0.025) << "level " << level;
    EXPECT_NEAR(seen.top_m, scene.field.row_height_m, fine ? 0.012 : 0.025) << "level " << level;
  }
}

TEST(World, PiecesAreTheSameWheneverTheyAreAskedFor) {
  const Scene scene = still_scene(3.0, -12.4);
  const Canopy canopy(scene);
  std::vector<Leaf> once, again, other;
  canopy.append_piece(2, 7, 1, 0.0, 0, once);
  canopy.append_piece(3, 7, 1, 0.0, 0, other);
  canopy.append_piece(2, 7, 1, 0.0, 0, again);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) ASSERT_EQ(once[i].centre, again[i].centre);
  EXPECT_NE(once[0].centre, other[0].centre);
}

TEST(World, TruthIsConsistent) {
  Scene scene = demo_scene();
  scene.field.slope_along = 0.06;
  scene.field.slope_across = -0.04;
  scene.field.undulation_m = 0.3;
  scene.field.curvature_per_m = 0.002;
  const auto shots = true_shots(scene);
  ASSERT_EQ(shots.size(), 39U);
  for (const ShotTruth& shot : shots) {
    EXPECT_LT((shot.cam_from_world * shot.x_in_world).norm(), 1e-9);
    const Vector3d row = row_from_world(scene, shot.x_in_world);
    EXPECT_NEAR(row.x(), shot.along_row_m, 1e-6);
    EXPECT_NEAR(row.y() - shot.nearest_row * scene.field.spacing_m, shot.cross_track_m, 1e-6);
    EXPECT_NEAR(row.z(), shot.height_above_ground_m, 1e-6);
    EXPECT_LT((world_from_row(scene, row) - shot.x_in_world).norm(), 1e-6);
    // The optical axis: its elevation is the pitch, its direction over the ground the heading.
    const Vector3d axis = shot.cam_from_world.rotation.conjugate() * Vector3d::UnitZ();
    EXPECT_NEAR(std::asin(axis.z()), shot.attitude.pitch_rad, 1e-9);
    const double heading = geom::rad_to_deg(std::atan2(axis.x(), axis.y()));
    EXPECT_NEAR(std::remainder(heading - shot.heading_deg, 360.0), 0.0, 1e-6);
  }
  EXPECT_NEAR(shots[5].height_above_ground_m, 3.0, 0.3);
  EXPECT_NEAR(shots[38].height_above_ground_m, 5.0, 0.3);
}

TEST(World, RowsStandWhereTruthProjectsThem) {
  // The demo's own view: tops of the followed row straddle the projection of its edges at the picture's
  // middle row.
  const Scene scene = still_scene(4.0, -13.8);
  const auto shots = true_shots(scene);
  const Image picture = Renderer(scene).shot(0);
  const double s = shots[0].along_row_m;
  // Between 6 and 12 m ahead, averaged over the row's length.
  const double left = half_cover(scene, shots[0], picture, s + 6, s + 12, 0.2, 1.2);
  const double right = half_cover(scene, shots[0], picture, s + 6, s + 12, -0.2, -1.2);
  EXPECT_NEAR(0.5 * (left + right), 0.0, 0.02);
  // Seen along the row the silhouette is the leaves that stand out: wider than the mean, by less than one
  // leaf's radius and a sigma.
  EXPECT_NEAR(0.5 * (left - right), scene.field.half_width_m + 0.03, 0.05);
}

TEST(World, TrueRowsAreOrderedAndProjected) {
  const Scene scene = demo_scene();
  const auto shots = true_shots(scene);
  for (std::size_t i : {0U, 20U, 38U}) {
    const auto rows = true_rows(scene, shots[i]);
    ASSERT_GT(rows.size(), 10U);
    for (std::size_t k = 1; k < rows.size(); ++k) EXPECT_EQ(rows[k].index, rows[k - 1].index + 1);
    const auto zero =
        std::find_if(rows.begin(), rows.end(), [](const TrueRow& row) { return row.index == 0; });
    ASSERT_NE(zero, rows.end());
    EXPECT_EQ(zero->row, 0) << "the flight follows row 0";
    // The middle of the list lies on the ray through the row's plane: go back from the pixel to the plane of
    // the tops.
    const RowCrossing& at = zero->crossings[zero->crossings.size() / 2];
    const Vector2d ray = camera::unproject(scene.camera, {at.u_px, at.v_px}).value();
    const Vector3d toward = shots[i].cam_from_world.rotation.conjugate() * Vector3d(ray.x(), ray.y(), 1.0);
    const double t = (scene.field.row_height_m - shots[i].x_in_world.z()) / toward.z();
    const Vector3d row = row_from_world(scene, shots[i].x_in_world + t * toward);
    EXPECT_NEAR(row.y(), 0.0, 2e-3);
    EXPECT_LT(at.left_u_px, at.u_px);
    EXPECT_LT(at.u_px, at.right_u_px);
  }
}

TEST(World, BoardCornersAreWhereTheyAreProjected) {
  Scene scene = demo_scene();
  const auto poses = true_boards(scene);
  ASSERT_EQ(poses.size(), 20U);
  const Renderer renderer(scene);
  double square_sum = 0.0;
  Vector2d mean = Vector2d::Zero();
  int count = 0;
  for (int board : {0, 7, 13}) {
    const Image picture = renderer.board(board);
    cv::Mat colour(picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.data.data())),
        grey;
    cv::cvtColor(colour, grey, cv::COLOR_RGB2GRAY);
    std::vector<Vector2d> truth;
    std::vector<cv::Point2f> found;
    base::Random random(3);
    for (int i = 0; i < scene.boards.corners_x * scene.boards.corners_y; ++i) {
      const Vector3d at(i % scene.boards.corners_x * scene.boards.square_m,
                        i / scene.boards.corners_x * scene.boards.square_m, 0.0);
      truth.push_back(camera::project(scene.camera, poses[static_cast<std::size_t>(board)] * at).value());
      found.emplace_back(static_cast<float>(truth.back().x() + random.uniform(-1, 1)),
                         static_cast<float>(truth.back().y() + random.uniform(-1, 1)));
    }
    cv::cornerSubPix(grey, found, {5, 5}, {-1, -1},
                     {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 100, 1e-4});
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const Vector2d miss =
          Vector2d(static_cast<double>(found[i].x), static_cast<double>(found[i].y)) - truth[i];
      square_sum += miss.squaredNorm();
      mean += miss;
      ++count;
    }
  }
  EXPECT_LT(std::sqrt(square_sum / count), 0.06);
  EXPECT_LT((mean / count).norm(), 0.01);
}

TEST(World, BoardsFillThePictureAndTilt) {
  const Scene scene = demo_scene();
  double left = 1e9, right = 0, top = 1e9, bottom = 0, most_tilt = 0;
  for (const Rigid3& pose : true_boards(scene)) {
    for (int i : {0, 8, 45, 53}) {
      const Vector3d at(i % 9 * scene.boards.square_m, i / 9 * scene.boards.square_m, 0.0);
      const Vector2d px = camera::project(scene.camera, pose * at).value();
      EXPECT_TRUE(px.x() > 12 && px.y() > 12 && px.x() < 1267 && px.y() < 707);
      left = std::min(left, px.x());
      right = std::max(right, px.x());
      top = std::min(top, px.y());
      bottom = std::max(bottom, px.y());
    }
    most_tilt = std::max(most_tilt, std::acos((pose.rotation * Vector3d::UnitZ()).z()));
  }
  EXPECT_LT(left, 90);
  EXPECT_GT(right, 1190);
  EXPECT_LT(top, 80);
  EXPECT_GT(bottom, 640);
  EXPECT_GT(geom::rad_to_deg(most_tilt), 33.0);
  EXPECT_LE(geom::rad_to_deg(most_tilt), 40.0 + 1e-6);
}

TEST(World, RayTableIsTheLens) {
  const Camera camera = thesis_camera();
  const RayTable rays(camera);
  base::Random random(8);
  for (int i = 0; i < 2000; ++i) {
    const int u = static_cast<int>(random.below(1280)), v = static_cast<int>(random.below(720));
    const Vector2d& ray = rays.pixel(u, v);
    const Vector2d px = camera::project(camera, {ray.x(), ray.y(), 1.0}).value();
    ASSERT_LT((px - Vector2d(u, v)).norm(), 1e-4) << u << " " << v;
  }
}

TEST(World, RollingShutterShearsWhatMoves) {
  // Flying sideways is not planned for; a fast climb at nadir scales the picture from top to bottom instead.
  // Here: forward flight at nadir moves the picture along v, so that a rolling picture of the posts is longer
  // or shorter along v.
  Scene scene = still_scene(10.0, -90.0);
  scene.camera = camera::resize_camera(scene.camera, 320, 180);
  scene.flight.speed_mps = 10.0;
  scene.pictures.exposure_time_s = 0.0;
  const Image still = Renderer(scene).shot(0);
  scene.pictures.readout_time_s = 0.03;
  const Image rolled = Renderer(scene).shot(0);
  EXPECT_NE(still.data, rolled.data);
  // The middle row is exposed at the same moment in both.
  const auto difference = [&](int v) {
    double sum = 0.0;
    for (int u = 0; u < still.width; ++u)
      sum += std::abs(static_cast<int>(still.at(u, v)[1]) - static_cast<int>(rolled.at(u, v)[1]));
    return sum / still.width;
  };
  EXPECT_LT(difference(90), 0.5 * difference(5));
}

TEST(World, OddScenesRender) {
  Scene base = still_scene(3.0, -12.4);
  base.camera = camera::resize_camera(base.camera, 64, 36);
  base.field.rows_each_side = 2;
  base.field.after_m = 15.0;
  const std::vector<std::pair<const char*, void (*)(Scene&)>> oddities = {
      {"one row", [](Scene& s) { s.field.rows_each_side = 0; }},
      {"inside the canopy", [](Scene& s) { s.flight.legs[0].height_above_ground_m = 1.2; }},
      {"on the soil, looking up",
       [](Scene& s) {
         s.flight.legs[0].height_above_ground_m = 0.1;
         s.flight.legs[0].pitch_deg = 30.0;
       }},
      {"very high", [](Scene& s) { s.flight.legs[0].height_above_ground_m = 500.0; }},
      {"straight down with yaw",
       [](Scene& s) {
         s.flight.legs[0].pitch_deg = -90.0;
         s.flight.legs[0].yaw_deg = 179.0;
       }},
      {"no rows at all", [](Scene& s) { s.field.gap_probability = 1.0; }},
      {"steep and wavy",
       [](Scene& s) {
         s.field.slope_along = -0.5;
         s.field.undulation_m = 3.0;
         s.field.undulation_wavelength_m = 5.0;
       }},
      {"curved to the right", [](Scene& s) { s.field.curvature_per_m = -0.005; }},
      {"low sun", [](Scene& s) { s.sun.elevation_deg = 5.0; }},
      {"long exposure and slow shutter",
       [](Scene& s) {
         s.pictures.exposure_time_s = 1.0;
         s.pictures.readout_time_s = 1.0;
       }},
      {"few thin leaves", [](Scene& s) { s.field.leaf_layers = 0.1; }},
      {"folding lens",
       [](Scene& s) {
         s.camera.distortion = {-0.9, 0.0, 0.0, 0.0, 0.0};
       }},
      {"sparse corn",
       [](Scene& s) {
         s.field.crop = Crop::corn;
         s.field.foliage_bottom_m = 0.0;
         s.field.row_height_m = 0.05;
       }},
  };
  for (const auto& [name, make] : oddities) {
    Scene scene = base;
    make(scene);
    ASSERT_TRUE(validate(scene).ok()) << name << ": " << validate(scene).error().message();
    const Image picture = Renderer(scene).shot(0);
    EXPECT_EQ(picture.width, 64) << name;
    EXPECT_TRUE(std::any_of(picture.data.begin(), picture.data.end(), [](std::uint8_t x) { return x > 10; }))
        << name;
    EXPECT_NO_THROW(true_rows(scene, true_shots(scene)[0])) << name;
  }
  Scene tiny_leaves = base;
  tiny_leaves.field.leaf_m = 0.01;
  EXPECT_EQ(validate(tiny_leaves).error().code, "scene_invalid");
}

}  // namespace
}  // namespace furrow::sim
