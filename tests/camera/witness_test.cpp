// The same parameters must give the same pixels in two programs that share no code with ours.
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "camera/cameras.h"
#include "camera/mrcal_witness.h"
#include "furrow/base/random.h"

namespace furrow::camera {
namespace {

constexpr double kWitnessPx = 1e-9;
constexpr double kWidestTangent = 0.9;  // covers the picture's corners of test_camera()

Eigen::Vector3d random_point(base::Random& random) {
  const double z = random.uniform(0.2, 20.0);
  return {z * random.uniform(-kWidestTangent, kWidestTangent),
          z * random.uniform(-kWidestTangent, kWidestTangent), z};
}

TEST(Witness, OpenCvsFisheyeProjectsTheSamePixels) {
  base::Random random(13);
  const Camera camera = test_camera(CameraModel::fisheye);
  const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  std::vector<cv::Point3d> points;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d p = random_point(random);
    points.emplace_back(3.0 * p.x(), 3.0 * p.y(), p.z());  // up to 75 degrees off
  }
  std::vector<cv::Point2d> expected;
  cv::fisheye::projectPoints(points, expected, cv::Vec3d::zeros(), cv::Vec3d::zeros(), k, camera.distortion);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto px = project(camera, {points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(px.has_value());
    EXPECT_NEAR(px->x(), expected[i].x, kWitnessPx);
    EXPECT_NEAR(px->y(), expected[i].y, kWitnessPx);
  }
}

TEST(Witness, MrcalsWideLensesProjectTheSamePixels) {
  base::Random random(14);
  const std::pair<Camera, const char*> lenses[] = {
      {test_camera(CameraModel::stereographic), "LENSMODEL_STEREOGRAPHIC"},
      {test_camera(CameraModel::latlon), "LENSMODEL_LATLON"},
      {test_camera(CameraModel::splined_stereographic),
       "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3_Nx=14_Ny=11_fov_x_deg=120"},
      {quadratic_camera(), "LENSMODEL_SPLINED_STEREOGRAPHIC_order=2_Nx=14_Ny=11_fov_x_deg=120"}};
  for (const auto& [camera, name] : lenses) {
    for (int i = 0; i < 2000; ++i) {
      // All round, behind the camera too; the splined ones leave their grid there.
      const Eigen::Vector3d p(random.normal(), random.normal(), random.normal());
      const auto expected = mrcal_projection(name, intrinsics(camera), p);
      const auto px = project(camera, p);
      ASSERT_TRUE(expected && px) << name;
      EXPECT_LT((*px - *expected).norm(), kWitnessPx * (1.0 + 1e-3 * expected->norm()))
          << name << " " << p.transpose();
    }
  }
}

TEST(Witness, OpenCvProjectsTheSamePixels) {
  base::Random random(11);
  for (const CameraModel model : kPlaneModels) {
    const Camera camera = test_camera(model);
    const cv::Matx33d k(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
    std::vector<cv::Point3d> points;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d p = random_point(random);
      points.emplace_back(p.x(), p.y(), p.z());
    }
    std::vector<cv::Point2d> expected;
    cv::projectPoints(points, cv::Vec3d::zeros(), cv::Vec3d::zeros(), k, camera.distortion, expected);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto px = project(camera, {points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(px.has_value());
      EXPECT_NEAR(px->x(), expected[i].x, kWitnessPx) << model_name(model);
      EXPECT_NEAR(px->y(), expected[i].y, kWitnessPx) << model_name(model);
    }
  }
}

TEST(Witness, MrcalProjectsTheSamePixels) {
  base::Random random(12);
  const std::pair<CameraModel, const char*> models[] = {{CameraModel::pinhole, "LENSMODEL_PINHOLE"},
                                                        {CameraModel::opencv4, "LENSMODEL_OPENCV4"},
                                                        {CameraModel::opencv5, "LENSMODEL_OPENCV5"},
                                                        {CameraModel::opencv8, "LENSMODEL_OPENCV8"},
                                                        {CameraModel::opencv12, "LENSMODEL_OPENCV12"}};
  for (const auto& [model, name] : models) {
    const Camera camera = test_camera(model);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d p = random_point(random);
      const auto expected = mrcal_projection(name, intrinsics(camera), p);
      const auto px = project(camera, p);
      ASSERT_TRUE(expected && px) << name;
      EXPECT_LT((*px - *expected).norm(), kWitnessPx) << name;
    }
  }
}

}  // namespace
}  // namespace furrow::camera
