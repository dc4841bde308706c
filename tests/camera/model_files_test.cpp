#include "furrow/camera/model_files.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>

#include "camera/cameras.h"
#include "camera/mrcal_witness.h"
#include "furrow/base/file.h"
#include "furrow/base/random.h"

namespace furrow::camera {
namespace {

std::filesystem::path data_folder() {
  const char* set = std::getenv("FURROW_DATA");
  return set != nullptr ? std::filesystem::path(set)
                        : std::filesystem::path(FURROW_SOURCE_DIR) / "../shared/data";
}

TEST(ModelFiles, MrcalReadsWhatWeWriteToTheLastBit) {
  for (const CameraModel model : kAllModels) {
    Camera camera = test_camera(model);
    camera.fx = 1000.0 / 3.0;
    int width = 0, height = 0;
    const Eigen::VectorXd read = mrcal_reads(to_mrcal_cameramodel(camera), width, height);
    ASSERT_EQ(read.size(), intrinsics(camera).size()) << model_name(model);
    EXPECT_EQ(read, intrinsics(camera));
    EXPECT_EQ(width, 1280);
    EXPECT_EQ(height, 960);
  }
}

TEST(ModelFiles, OurReaderReadsWhatWeWrite) {
  for (const CameraModel model : kAllModels) {
    Camera camera = test_camera(model);
    camera.fx = 1000.0 / 3.0;
    camera.covariance = Eigen::MatrixXd::Random(4 + distortion_count(model), 4 + distortion_count(model));
    camera.covariance = (camera.covariance * camera.covariance.transpose()).eval();
    const auto mrcal = parse_camera(to_mrcal_cameramodel(camera), "x.cameramodel");
    ASSERT_TRUE(mrcal.ok()) << mrcal.error().message();
    EXPECT_EQ(mrcal->model, model);
    EXPECT_EQ(intrinsics(*mrcal), intrinsics(camera));
    if (model == CameraModel::pinhole) continue;  // written to YAML as five zeros
    const auto yaml = parse_camera(to_opencv_yaml(camera), "x.yaml");
    ASSERT_TRUE(yaml.ok()) << yaml.error().message();
    EXPECT_EQ(yaml->model, model);
    EXPECT_EQ(intrinsics(*yaml), intrinsics(camera));
    EXPECT_EQ(yaml->covariance, camera.covariance);
  }
}

TEST(ModelFiles, OpenCvReadsWhatWeWrite) {
  for (const CameraModel model : kAllModels) {
    Camera camera = test_camera(model);
    camera.fx = 1000.0 / 3.0;
    camera.provenance = "a \"quoted\" word: and a colon";
    const cv::FileStorage file(to_opencv_yaml(camera), cv::FileStorage::READ | cv::FileStorage::MEMORY);
    cv::Mat k, d;
    file["camera_matrix"] >> k;
    file["distortion_coefficients"] >> d;
    EXPECT_EQ(static_cast<int>(file["image_width"]), 1280);
    EXPECT_EQ(static_cast<std::string>(file["provenance"]), camera.provenance);
    ASSERT_EQ(k.rows, 3);
    EXPECT_EQ(k.at<double>(0, 0), camera.fx);
    EXPECT_EQ(k.at<double>(1, 2), camera.cy);
    ASSERT_EQ(static_cast<int>(d.total()),
              std::max(5 * (model == CameraModel::pinhole), distortion_count(model)));
    for (std::size_t i = 0; i < camera.distortion.size(); ++i)
      EXPECT_EQ(d.at<double>(static_cast<int>(i)), camera.distortion[i]);
  }
}

TEST(ModelFiles, ShortNamesAndPaddedCoefficients) {
  const auto camera = parse_camera(
      "image_width: 640\nimage_height: 480\nK: [[500, 0, 320], [0, 501, 240], [0, 0, 1]]\n"
      "D: [0.1, 0.2, 0.001, 0.002, 0.3, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n",
      "x.yaml");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->fy, 501.0);
  EXPECT_EQ(camera->distortion.size(), 12U);
  EXPECT_EQ(camera->distortion[4], 0.3);
}

TEST(ModelFiles, CalibrationJson) {
  const auto camera =
      parse_camera(R"({"image_size": [640, 480], "model": "opencv5", "fx": 500.5, "fy": 501.5, "cx": 320,
    "cy": 240, "distortion": [0.1, 0.2, 0.001, 0.002, 0.3], "rms_px": 0.2, "views": []})",
                   "calibration.json");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->width, 640);
  EXPECT_EQ(camera->distortion[4], 0.3);
}

// Values printed in the files' own text.
TEST(ModelFiles, ReadsMrcalsPublishedModels) {
  const auto folder = data_folder() / "calib/mrcal-board-24mp";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data at " << folder << " (set FURROW_DATA)";
  const auto camera = read_camera(folder / "opencv8-0.cameramodel");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->model, CameraModel::opencv8);
  EXPECT_EQ(camera->width, 6016);
  EXPECT_EQ(camera->height, 4016);
  EXPECT_EQ(camera->fx, 2073.872915);
  EXPECT_EQ(camera->distortion[7], 0.001407513313);
  const auto splined = read_camera(folder / "splined-0.cameramodel");
  ASSERT_FALSE(splined.ok());
  EXPECT_EQ(splined.error().code, "camera_model_unsupported");
}

TEST(ModelFiles, ReadsOpenCvsOwnExample) {
  const std::filesystem::path file = "/usr/share/doc/opencv-doc/examples/data/left_intrinsics.yml";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file << " (install opencv-doc)";
  const auto camera = read_camera(file);
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->fx, 5.3591573396163199e+02);
  EXPECT_EQ(camera->distortion[4], 2.3839153080878486e-01);
  EXPECT_EQ(camera->width, 640);
}

TEST(ModelFiles, RefusalsNameLineAndKey) {
  const auto message = [](const std::string& text) {
    const auto camera = parse_camera(text, "f");
    return camera.ok() ? std::string("ok") : camera.error().message();
  };
  EXPECT_NE(message("").find("empty"), std::string::npos);
  EXPECT_NE(message("hello: 3\n").find("none of the keys"), std::string::npos);
  EXPECT_NE(message("{\n 'lensmodel': 'LENSMODEL_OPENCV5',\n 'intrinsics': [1, 2,\n").find("f:4"),
            std::string::npos);
  EXPECT_NE(message("{\n 'lensmodel': 'LENSMODEL_OPENCV5',\n 'intrinsics': [1, 2],\n 'imagersize': [3, 4] }")
                .find("f:3"),
            std::string::npos);
  EXPECT_NE(
      message("{'lensmodel': 'LENSMODEL_CAHVOR', 'intrinsics': [1], 'imagersize': [3, 4]}").find("CAHVOR"),
      std::string::npos);
  EXPECT_NE(message("camera_matrix: [1, 2, 3]\n").find("9"), std::string::npos);
  EXPECT_NE(message("K: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n").find("image_width"), std::string::npos);
  EXPECT_NE(
      message("image_width: 640\nimage_height: 480\nK: [-500, 0, 320, 0, 500, 240, 0, 0, 1]\n").find("fx"),
      std::string::npos);
  EXPECT_NE(message(std::string(100000, '[')), "ok");
  EXPECT_NE(message("{" + std::string(100000, '(')), "ok");
  EXPECT_FALSE(read_camera("no/such/file.yaml").ok());
}

TEST(ModelFiles, EveryExportComesBackTheSame) {
  for (const CameraModel model : kAllModels) {
    const Camera camera = test_camera(model);
    for (const char* name : {"mrcal", "opencv", "ros", "kalibr", "colmap"}) {
      const auto text = export_camera(camera, *format_from_name(name));
      const bool too_small =
          (std::string(name) == "kalibr" && camera.distortion.size() > 4) ||
          (camera.distortion.size() > 8 && (std::string(name) == "ros" || std::string(name) == "colmap"));
      ASSERT_EQ(text.ok(), !too_small) << name << " " << model_name(model);
      if (too_small) {
        EXPECT_EQ(text.error().code, "camera_export_failed");
      }
    }
  }
  EXPECT_FALSE(format_from_name("pixhawk").has_value());
  EXPECT_FALSE(export_camera(Camera{}, CameraFormat::ros).ok());
}

// COLMAP's principal point of a 640 x 480 picture's middle is (320, 240); ours is (319.5, 239.5).
TEST(ModelFiles, ColmapIsHalfAPixelOff) {
  const auto camera =
      parse_camera("# Camera list\n1 SIMPLE_RADIAL 640 480 500 320 240 -0.1\n", "cameras.txt");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->cx, 319.5);
  EXPECT_EQ(camera->cy, 239.5);
  EXPECT_EQ(camera->fy, 500.0);
  EXPECT_EQ(camera->distortion[0], -0.1);
  EXPECT_FALSE(parse_camera("1 OPENCV 640 480 500 500 320\n", "cameras.txt").ok());
  EXPECT_FALSE(parse_camera("1 PINHOLE 640 480 x 500 320 240\n", "cameras.txt").ok());
}

TEST(ModelFiles, KalibrWithAnotherLensIsRefused) {
  const auto camera = parse_camera(
      "cam0:\n  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  distortion_model: equidistant\n"
      "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 480]\n",
      "camchain.yaml");
  ASSERT_FALSE(camera.ok());
  EXPECT_EQ(camera.error().code, "camera_model_unsupported");
}

// Any prefix and any single damaged byte must end in a camera or an error, never in a crash or an exception.
TEST(ModelFiles, DamagedFilesNeverThrow) {
  base::Random random(31);
  Camera camera = test_camera(CameraModel::opencv8);
  camera.covariance = Eigen::MatrixXd::Identity(12, 12);
  Camera small = test_camera(CameraModel::opencv4);
  for (const std::string& text :
       {to_mrcal_cameramodel(camera), to_opencv_yaml(camera), *export_camera(small, CameraFormat::colmap),
        *export_camera(small, CameraFormat::kalibr)}) {
    for (std::size_t n = 0; n < text.size(); n += 3)
      EXPECT_NO_THROW((void)parse_camera(text.substr(0, n), "f"));
    for (int trial = 0; trial < 1500; ++trial) {
      std::string damaged = text;
      for (int i = 0; i < 1 + trial % 4; ++i) {
        damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] =
            static_cast<char>(random.below(256));
      }
      EXPECT_NO_THROW((void)parse_camera(damaged, "f"));
    }
  }
}

}  // namespace
}  // namespace furrow::camera
