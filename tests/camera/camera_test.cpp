#include "furrow/camera/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <Eigen/LU>
#include <limits>
#include <numbers>

#include "camera/cameras.h"
#include "camera/spline.h"
#include "furrow/base/random.h"

namespace furrow::camera {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(Camera, NamesGoBothWays) {
  for (const CameraModel model : kAllModels) EXPECT_EQ(model_from_name(model_name(model)), model);
  EXPECT_FALSE(model_from_name("fishbowl").has_value());
}

TEST(Camera, NothingBehindTheCamera) {
  const Camera camera = test_camera(CameraModel::opencv5);
  EXPECT_FALSE(project(camera, {0.1, 0.1, 0.0}).has_value());
  EXPECT_FALSE(project(camera, {0.1, 0.1, -1.0}).has_value());
  EXPECT_FALSE(project(camera, {0.1, std::nan(""), 1.0}).has_value());
  EXPECT_FALSE(project_with_jacobians(camera, {0.0, 0.0, -2.0}).has_value());
}

// Central differences of step h err by about h^2 / 6 times the third derivative: 1e-6 relative is far above
// that here.
TEST(Camera, JacobiansEqualCentralDifferences) {
  base::Random random(21);
  for (const CameraModel model : kAllModels) {
    const Camera camera = test_camera(model);
    for (int trial = 0; trial < 100; ++trial) {
      const double z = random.uniform(0.5, 5.0);
      const Eigen::Vector3d p(z * random.uniform(-0.9, 0.9), z * random.uniform(-0.9, 0.9), z);
      const auto at = project_with_jacobians(camera, p);
      ASSERT_TRUE(at.has_value());
      EXPECT_LT((at->px - *project(camera, p)).norm(), 1e-12);
      for (int i = 0; i < 3; ++i) {
        constexpr double kStep = 1e-6;
        const Eigen::Vector3d d = Eigen::Vector3d::Unit(i) * kStep;
        const Eigen::Vector2d numeric = (*project(camera, p + d) - *project(camera, p - d)) / (2.0 * kStep);
        EXPECT_LT((at->d_point.col(i) - numeric).norm(), 1e-5 * (1.0 + numeric.norm())) << model_name(model);
      }
      const Eigen::VectorXd values = intrinsics(camera);
      const Eigen::Matrix2Xd by_intrinsics = at->by_all_intrinsics(values.size());
      for (int i = 0; i < values.size(); ++i) {
        const double step = 1e-6 * std::max(1.0, std::abs(values[i]));
        const Eigen::VectorXd d = Eigen::VectorXd::Unit(values.size(), i) * step;
        const Eigen::Vector2d numeric = (*project(with_intrinsics(camera, values + d), p) -
                                         *project(with_intrinsics(camera, values - d), p)) /
                                        (2.0 * step);
        EXPECT_LT((by_intrinsics.col(i) - numeric).norm(), 1e-5 * (1.0 + numeric.norm()))
            << model_name(model) << " intrinsic " << i;
      }
    }
  }
}

TEST(Camera, JacobiansOfQuadraticPatchesEqualCentralDifferences) {
  const Camera camera = quadratic_camera();
  const Eigen::Vector3d p(0.31, -0.22, 1.1);
  const Eigen::VectorXd values = intrinsics(camera);
  const Eigen::Matrix2Xd by = project_with_jacobians(camera, p)->by_all_intrinsics(values.size());
  for (int i = 0; i < values.size(); ++i) {
    const Eigen::VectorXd d = Eigen::VectorXd::Unit(values.size(), i) * 1e-6;
    const Eigen::Vector2d numeric = (*project(with_intrinsics(camera, values + d), p) -
                                     *project(with_intrinsics(camera, values - d), p)) /
                                    2e-6;
    EXPECT_LT((by.col(i) - numeric).norm(), 1e-5 * (1.0 + numeric.norm()));
  }
}

TEST(Camera, UnprojectComesBackToTheSamePixel) {
  base::Random random(22);
  for (const CameraModel model : kAllModels) {
    const Camera camera = test_camera(model);
    int answered = 0;
    for (int trial = 0; trial < 2000; ++trial) {
      const Eigen::Vector2d px(random.uniform(0, 1279), random.uniform(0, 959));
      const auto xy = unproject(camera, px);
      if (!xy) continue;
      ++answered;
      EXPECT_LT((*project(camera, {xy->x(), xy->y(), 1.0}) - px).norm(), 1e-9) << model_name(model);
    }
    // Two fold within the picture; a fisheye's corners lie beyond 90 degrees, where the unit plane ends.
    const bool ends =
        model == CameraModel::opencv4 || model == CameraModel::opencv5 || model == CameraModel::fisheye;
    EXPECT_GT(answered, ends ? 1500 : 1999) << model_name(model);
  }
}

TEST(Camera, UnprojectFindsTheVeryPoint) {
  base::Random random(23);
  for (const CameraModel model : kPlaneModels) {
    const Camera camera = test_camera(model);
    const double widest = 0.95 * fold_radius(camera).value_or(1.5);
    for (int trial = 0; trial < 500; ++trial) {
      const double r = widest * std::sqrt(random.uniform()), angle = random.uniform(0, 2 * std::numbers::pi);
      const Eigen::Vector2d xy(r * std::cos(angle), r * std::sin(angle));
      const auto back = unproject(camera, *project(camera, {xy.x(), xy.y(), 1.0}));
      ASSERT_TRUE(back.has_value()) << model_name(model) << " r " << r;
      EXPECT_LT((*back - xy).norm(), 1e-9) << model_name(model);
    }
  }
}

// All directions up to 100 degrees off the axis; at 120 degrees and more a fisheye of this kind has folded.
TEST(Camera, RayOfAWideLensIsTheVeryDirection) {
  base::Random random(25);
  for (const CameraModel model : kWideModels) {
    const Camera camera = test_camera(model);
    const double widest = model == CameraModel::splined_stereographic ? 55.0 : 100.0;
    int answered = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      const double off = widest * kDegree * random.uniform(), turn = random.uniform(0, 2 * std::numbers::pi);
      const Eigen::Vector3d way(std::sin(off) * std::cos(turn), std::sin(off) * std::sin(turn),
                                std::cos(off));
      const auto px = project(camera, 3.7 * way);
      ASSERT_TRUE(px.has_value()) << model_name(model);
      const auto back = unproject_ray(camera, *px);
      if (!back) continue;
      ++answered;
      EXPECT_LT((*back - way).norm(), 1e-12) << model_name(model) << " " << off / kDegree;
      EXPECT_LT((*project(camera, *back) - *px).norm(), 1e-9);
    }
    EXPECT_EQ(answered, 1000) << model_name(model);
  }
}

TEST(Camera, WideLensesSayWhereTheyHaveNoInverse) {
  Camera camera = test_camera(CameraModel::fisheye);
  camera.distortion = {-0.1, 0.0, 0.0, 0.0};  // theta (1 - 0.1 theta^2) turns at sqrt(1 / 0.3), 104.6 deg
  const double fold = std::sqrt(1.0 / 0.3), edge_px = camera.fx * fold * 2.0 / 3.0;
  EXPECT_TRUE(unproject_ray(camera, {camera.cx + edge_px - 1e-3, camera.cy}).has_value());
  EXPECT_FALSE(unproject_ray(camera, {camera.cx + edge_px + 1e-3, camera.cy}).has_value());
  EXPECT_FALSE(fold_radius(camera).has_value());  // beyond 90 degrees
  camera.distortion[0] = -1.0 / 3.0;              // at 57.3 deg
  EXPECT_NEAR(fold_radius(camera).value_or(0.0), std::tan(1.0), 1e-9);
  const Camera latlon = test_camera(CameraModel::latlon);
  EXPECT_FALSE(unproject_ray(latlon, {latlon.cx + latlon.fx * 1.6, latlon.cy}).has_value());
  EXPECT_FALSE(unproject(latlon, {latlon.cx, latlon.cy + latlon.fy * 1.6}).has_value());  // 91.7 deg off
  Camera torn = test_camera(CameraModel::splined_stereographic);
  for (double& knot : torn.distortion) knot *= 30.0;
  int without = 0;
  for (int u = 0; u < 1280; u += 40) without += unproject_ray(torn, {u + 0.0, 480.0}).has_value() ? 0 : 1;
  EXPECT_GT(without, 0);
}

// On the border of two cubic patches both give one value, and so do their slopes.
TEST(Camera, PatchesMeetWithoutAStep) {
  const Camera camera = test_camera(CameraModel::splined_stereographic);
  base::Random random(26);
  for (int trial = 0; trial < 100; ++trial) {
    const double border = 4.0 + random.below(6);
    const Eigen::Vector2d u((border - 0.5 * (camera.spline.columns - 1)) / knots_per_unit(camera.spline),
                            random.uniform(-0.5, 0.5));
    const Eigen::Vector3d p(u.x(), u.y(), 1.0 - 0.25 * u.squaredNorm());
    const SplinePatch right{static_cast<int>(border) - 1, spline_patch(camera, p)->row};
    const auto a = project_by_patch(camera, p, right),
               b = project_by_patch(camera, p, {right.column - 1, right.row});
    EXPECT_LT((a->px - b->px).norm(), 1e-9);
    EXPECT_LT((a->d_point - b->d_point).norm(), 1e-8);
    const Eigen::Vector3d inside = p + Eigen::Vector3d(1e-3, 0.0, 0.0);
    EXPECT_EQ(project_by_patch(camera, inside, *spline_patch(camera, inside))->px, *project(camera, inside));
  }
}

TEST(Camera, NothingStraightBehindAWideLens) {
  for (const CameraModel model : kWideModels) {
    const Camera camera = test_camera(model);
    const auto nadir = project(camera, {0.0, 0.0, -1.0});
    EXPECT_EQ(nadir.has_value(), model == CameraModel::latlon) << model_name(model);
    EXPECT_TRUE(project(camera, {0.0, 0.0, 1.0}).has_value());
    EXPECT_FALSE(project(camera, {std::nan(""), 0.0, 1.0}).has_value());
  }
}

TEST(Camera, FocalLengthOnTheAxis) {
  for (const CameraModel model : kAllModels) {
    if (model == CameraModel::splined_stereographic) continue;
    const Camera camera = test_camera(model);
    EXPECT_NEAR(focal_on_axis_px(camera).x(), camera.fx, 1e-9) << model_name(model);
    EXPECT_NEAR(focal_on_axis_px(camera).y(), camera.fy, 1e-9) << model_name(model);
  }
  Camera splined = test_camera(CameraModel::splined_stereographic);
  splined.distortion.assign(splined.distortion.size(), 0.01);  // all knots moved alike: a shift, no stretch
  EXPECT_NEAR(focal_on_axis_px(splined).x(), splined.fx, 1e-9);
}

// 1 + 3 k1 s = 0 for r (1 + k1 r^2): with k1 = -0.3 the fold is at r = sqrt(1 / 0.9) and its image at 2/3 of
// that.
TEST(Camera, NothingBeyondTheFold) {
  Camera camera = test_camera(CameraModel::opencv4);
  camera.fx = camera.fy = 500.0;
  camera.cx = 640.0;
  camera.cy = 480.0;
  camera.distortion = {-0.3, 0.0, 0.0, 0.0};
  const double fold = std::sqrt(1.0 / 0.9);
  ASSERT_TRUE(fold_radius(camera).has_value());
  EXPECT_NEAR(*fold_radius(camera), fold, 1e-12);
  const double edge_px = 500.0 * fold * 2.0 / 3.0;
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector2d way(std::cos(10 * i * kDegree), std::sin(10 * i * kDegree));
    const Eigen::Vector2d centre(640.0, 480.0);
    const auto inside = unproject(camera, centre + way * (edge_px - 1e-3));
    ASSERT_TRUE(inside.has_value());
    EXPECT_LT(inside->norm(), fold);
    EXPECT_FALSE(unproject(camera, centre + way * (edge_px + 1e-3)).has_value());
    EXPECT_FALSE(unproject(camera, centre + way * 2000.0).has_value());
  }
  camera.distortion = {0.3, 0.0, 0.0, 0.0};
  EXPECT_FALSE(fold_radius(camera).has_value());
}

TEST(Camera, FoldOfARationalModelIsWhereItsSlopeVanishes) {
  Camera camera = test_camera(CameraModel::opencv8);
  camera.distortion = {0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0};  // r / (1 + r^2) turns at r = 1
  ASSERT_TRUE(fold_radius(camera).has_value());
  EXPECT_NEAR(*fold_radius(camera), 1.0, 1e-12);
  camera.distortion = {0.0, 0.0, 0.0, 0.0, 0.0, -0.25, 0.0, 0.0};  // a pole at r = 2
  ASSERT_TRUE(fold_radius(camera).has_value());
  EXPECT_NEAR(*fold_radius(camera), 2.0, 1e-9);
}

TEST(Camera, UnprojectedPointNeverLiesBeyondAFoldWhateverTheCoefficients) {
  base::Random random(24);
  for (int trial = 0; trial < 3000; ++trial) {
    Camera camera = test_camera(CameraModel::opencv12);
    for (double& k : camera.distortion) k = random.normal(0.0, trial % 2 == 0 ? 0.05 : 2.0);
    const Eigen::Vector2d px(random.uniform(-500, 2000), random.uniform(-500, 1500));
    const auto xy = unproject(camera, px);
    if (!xy) continue;
    EXPECT_LT((*project(camera, {xy->x(), xy->y(), 1.0}) - px).norm(), 1e-9);
    const auto at = project_with_jacobians(camera, {xy->x(), xy->y(), 1.0});
    EXPECT_GT(at->d_point.leftCols<2>().determinant(), 0.0);
    EXPECT_TRUE(unproject_jacobian(camera, *xy).has_value());
  }
}

TEST(Camera, UnprojectAnswersNothingToNonsense) {
  const Camera camera = test_camera(CameraModel::opencv5);
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(unproject(camera, {nan, 3.0}).has_value());
  EXPECT_FALSE(unproject(camera, {inf, 3.0}).has_value());
  EXPECT_FALSE(unproject(test_camera(CameraModel::pinhole), {nan, 3.0}).has_value());
}

TEST(Camera, UnprojectJacobianIsTheInverse) {
  const Camera camera = test_camera(CameraModel::opencv12);
  const Eigen::Vector2d px(900.0, 200.0);
  const Eigen::Vector2d xy = *unproject(camera, px);
  const Eigen::Matrix2d analytic = *unproject_jacobian(camera, xy);
  for (int i = 0; i < 2; ++i) {
    constexpr double kStep = 1e-3;
    const Eigen::Vector2d d = Eigen::Vector2d::Unit(i) * kStep;
    const Eigen::Vector2d numeric = (*unproject(camera, px + d) - *unproject(camera, px - d)) / (2.0 * kStep);
    EXPECT_LT((analytic.col(i) - numeric).norm(), 1e-9);
  }
}

// Pixel centres: the point seen at u in the large picture is seen at (u + 0.5) / 2 - 0.5 in the half one.
TEST(Camera, ResizedCameraSeesTheSameField) {
  Camera camera = test_camera(CameraModel::opencv5);
  camera.covariance = Eigen::MatrixXd::Identity(9, 9);
  const Camera half = resize_camera(camera, 640, 480);
  const Eigen::Vector3d p(0.2, -0.1, 1.3);
  const Eigen::Vector2d large = *project(camera, p), small = *project(half, p);
  EXPECT_NEAR(small.x(), (large.x() + 0.5) / 2 - 0.5, 1e-12);
  EXPECT_NEAR(small.y(), (large.y() + 0.5) / 2 - 0.5, 1e-12);
  EXPECT_DOUBLE_EQ(half.covariance(0, 0), 0.25);
  EXPECT_DOUBLE_EQ(half.covariance(3, 3), 0.25);
  EXPECT_DOUBLE_EQ(half.covariance(4, 4), 1.0);
}

TEST(Camera, CarriedOnlyToTheSameAspect) {
  const Camera camera = resize_camera(test_camera(CameraModel::opencv5), 1280, 720);
  EXPECT_TRUE(carry_camera(camera, 4000, 2250).ok());
  EXPECT_TRUE(carry_camera(camera, 320, 180).ok());
  EXPECT_TRUE(carry_camera(camera, 427, 240).ok());  // 426.67 rounded
  const auto crop = carry_camera(camera, 1280, 960);
  ASSERT_FALSE(crop.ok());
  EXPECT_EQ(crop.error().code, "camera_aspect_differs");
  EXPECT_FALSE(carry_camera(camera, 0, 0).ok());
  EXPECT_FALSE(carry_camera(Camera{}, 640, 480).ok());
}

TEST(Camera, ValidateNamesTheField) {
  Camera camera = test_camera(CameraModel::opencv5);
  EXPECT_TRUE(validate(camera).ok());
  camera.fy = -1.0;
  EXPECT_NE(validate(camera).error().message().find("fy"), std::string::npos);
  camera = test_camera(CameraModel::opencv5);
  camera.distortion.pop_back();
  EXPECT_FALSE(validate(camera).ok());
  camera = test_camera(CameraModel::opencv5);
  camera.distortion[2] = std::nan("");
  EXPECT_FALSE(validate(camera).ok());
  EXPECT_FALSE(validate(Camera{}).ok());
}

// The thesis, section 2: 874.33 px over 1280 px of a 13.2 mm sensor is 9.016 mm; 13.2 x 8.8 mm behind 8.8 mm
// is 73.74, 53.13, 84 deg.
TEST(Camera, ThesisFocalLengthAndFieldOfView) {
  EXPECT_NEAR(focal_length_mm(874.33, 13.2, 1280), 9.016, 1e-3);  // 9.01653, which the thesis cuts short
  const FieldOfView fov = field_of_view(13.2, 8.8, 8.8);
  EXPECT_NEAR(fov.horizontal_rad / kDegree, 73.74, 5e-3);
  EXPECT_NEAR(fov.vertical_rad / kDegree, 53.13, 5e-3);
  EXPECT_NEAR(fov.diagonal_rad / kDegree, 84.0, 0.1);
}

}  // namespace
}  // namespace furrow::camera
