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
    if (model == CameraModel::fisheye) continue;  // not one of mrcal's
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
  for (const CameraModel model : kPlaneModels) {
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
  for (const CameraModel model : kPlaneModels) {
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
  ASSERT_TRUE(splined.ok()) << splined.error().message();
  EXPECT_EQ(splined->spline.columns, 30);
  EXPECT_EQ(splined->spline.rows, 20);
  EXPECT_EQ(splined->spline.fov_x_deg, 170);
  EXPECT_EQ(splined->fy, 2058.977247);
  // A real spline through its own inverse, at places inside the pictures' covered part.
  for (const Eigen::Vector2d& px :
       {Eigen::Vector2d(3000, 2000), Eigen::Vector2d(1500, 1200), Eigen::Vector2d(4500, 3000)}) {
    const auto ray = unproject_ray(*splined, px);
    ASSERT_TRUE(ray.has_value());
    EXPECT_LT((*project(*splined, *ray) - px).norm(), 1e-9);
    const auto witness = mrcal_projection(mrcal_lensmodel(*splined), intrinsics(*splined), *ray);
    EXPECT_LT((*witness - px).norm(), 1e-8);
  }
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

/// Coefficients of OpenCV's order that each format has room for, and whether it knows the fisheye.
struct Room {
  const char* format;
  std::size_t coefficients;
  bool fisheye;
};
constexpr Room kRooms[] = {{"mrcal", 12, false}, {"opencv", 12, true}, {"ros", 8, true},
                           {"kalibr", 4, true},  {"colmap", 8, true},  {"metashape", 5, true},
                           {"pix4d", 5, false},  {"matlab", 5, false}};

bool has_room(const Room& room, const Camera& camera) {
  if (camera.model == CameraModel::fisheye) return room.fisheye;
  const bool plane =
      std::find(std::begin(kPlaneModels), std::end(kPlaneModels), camera.model) != std::end(kPlaneModels);
  return plane ? camera.distortion.size() <= room.coefficients : std::string(room.format) == "mrcal";
}

TEST(ModelFiles, EveryExportComesBackTheSameOrSaysWhyNot) {
  for (const CameraModel model : kAllModels) {
    for (const Room& room : kRooms) {
      Camera camera = test_camera(model);
      if (std::string(room.format) == "pix4d") camera.fy = camera.fx;
      const auto text = export_camera(camera, *format_from_name(room.format));
      ASSERT_EQ(text.ok(), has_room(room, camera)) << room.format << " " << model_name(model);
      if (text.ok()) {
        const auto back = parse_camera(*text, "back");
        ASSERT_TRUE(back.ok());
        EXPECT_NEAR(project(*back, {0.4, -0.2, 1.0})->x(), project(camera, {0.4, -0.2, 1.0})->x(), 1e-6);
      } else {
        EXPECT_EQ(text.error().code, "camera_export_failed");
      }
    }
  }
  EXPECT_FALSE(format_from_name("pixhawk").has_value());
  EXPECT_FALSE(export_camera(Camera{}, CameraFormat::ros).ok());
}

TEST(ModelFiles, RefusedExportsNameWhatHasNoRoom) {
  Camera camera = test_camera(CameraModel::opencv8);
  camera.fy = camera.fx;
  EXPECT_NE(
      export_camera(camera, CameraFormat::pix4d).error().message().find("Pix4D .cam has no room for k4"),
      std::string::npos);
  EXPECT_NE(export_camera(test_camera(CameraModel::opencv5), CameraFormat::pix4d)
                .error()
                .message()
                .find("one focal length"),
            std::string::npos);
  EXPECT_NE(
      export_camera(test_camera(CameraModel::fisheye), CameraFormat::mrcal).error().message().find("Kannala"),
      std::string::npos);
}

// The middle of a 640 x 480 picture is (319.5, 239.5) here; Metashape counts from the middle, p1 and p2 are
// the other way round, and b1 widens fx.
TEST(ModelFiles, MetashapeXml) {
  const auto camera = parse_camera(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<calibration>\n "
      "<projection>frame</projection><width>640</width>\n"
      " <height>480</height><f>500</f><cx>0</cx><cy>3</cy><b1>2</b1><k1>-0.1</k1><k3>0.01</k3><p1>0.001</p1>"
      "<p2>0.002</p2></calibration>\n",
      "camera.xml");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->fx, 502.0);
  EXPECT_EQ(camera->fy, 500.0);
  EXPECT_EQ(camera->cx, 319.5);
  EXPECT_EQ(camera->cy, 242.5);
  EXPECT_EQ(camera->distortion, (std::vector<double>{-0.1, 0.0, 0.002, 0.001, 0.01}));
  const auto refused = [](const std::string& element) {
    const auto read = parse_camera(
        "<calibration><width>640</width><height>480</height><f>500</f>" + element + "</calibration>", "x");
    return read.ok() ? std::string("ok") : read.error().message();
  };
  EXPECT_NE(refused("<b2>0.1</b2>").find("b2"), std::string::npos);
  EXPECT_NE(refused("<k4>0.1</k4>").find("k4"), std::string::npos);
  EXPECT_NE(refused("<projection>spherical</projection>").find("spherical"), std::string::npos);
  EXPECT_NE(refused("<k1>a lot</k1>"), "ok");
  EXPECT_NE(refused("<f"), "ok");
}

// A sensor of 17.5 mm with 4000 px: 15 mm are 3428.57 px; the corner of the picture is (-0.5, -0.5) here.
TEST(ModelFiles, Pix4dCam) {
  const std::string text =
      "Pix4D camera calibration file 0\n#Focal Length mm assuming a sensor width of 17.5x13.125mm\nF "
      "15\n#Principal Point "
      "mm\nPx 8.75\nPy 6.5625\n#Symmetrical Lens Distortion Coeffs\nK1 0.03\nK2 -0.01\nK3 0.02\n#Tangential "
      "Lens "
      "Distortion Coeffs\nT1 0.002\nT2 0.003\n";
  const auto without = parse_camera(text, "x.cam");
  ASSERT_FALSE(without.ok());
  EXPECT_NE(without.error().message().find("#Image size px"), std::string::npos);
  const auto camera = parse_camera(text + "#Image size px 4000x3000\n", "x.cam");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_NEAR(camera->fx, 15.0 * 4000.0 / 17.5, 1e-9);
  EXPECT_NEAR(camera->cx, 1999.5, 1e-9);
  EXPECT_NEAR(camera->cy, 1499.5, 1e-9);
  EXPECT_EQ(camera->distortion, (std::vector<double>{0.03, -0.01, 0.002, 0.003, 0.02}));
}

TEST(ModelFiles, MatlabText) {
  const auto camera = parse_camera(
      "  cameraIntrinsics with properties:\n\n             FocalLength: [714.1885 710.3786]\n          "
      "PrincipalPoint: "
      "[563.6511 355.7254]\n               ImageSize: [712 1072]\n        RadialDistortion: [-0.3535 "
      "0.1730]\n    "
      "TangentialDistortion: [0 0]\n                    Skew: 0\n",
      "matlab.txt");
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->width, 1072);
  EXPECT_EQ(camera->cx, 562.6511);
  EXPECT_EQ(camera->distortion[1], 0.1730);
  EXPECT_FALSE(parse_camera("FocalLength: [1 2]\nPrincipalPoint: [1 2]\nImageSize: [7]\n", "x").ok());
  EXPECT_FALSE(
      parse_camera("FocalLength: [1 2]\nPrincipalPoint: [1 2]\nImageSize: [7 8]\nSkew: 3\n", "x").ok());
}

// The numbers that stand in this picture's XMP.
TEST(ModelFiles, DjiPictureStatesItsCamera) {
  const auto file = data_folder() / "telemetry/dji_jpeg/p4rtk/DJI_0010.JPG";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no data at " << file << " (set FURROW_DATA)";
  const auto camera = read_camera(file);
  ASSERT_TRUE(camera.ok()) << camera.error().message();
  EXPECT_EQ(camera->model, CameraModel::opencv5);
  EXPECT_EQ(camera->width, 1600);
  EXPECT_EQ(camera->fx, 1973.0899658);
  EXPECT_EQ(camera->cx, 800.0 - 19.0419922);
  EXPECT_EQ(camera->distortion[4], -0.2643060);
  EXPECT_FALSE(parse_camera("\xFF\xD8\xFF nothing in here", "plain.jpg").ok());
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
      "cam0:\n  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  distortion_model: fov\n"
      "  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [640, 480]\n",
      "camchain.yaml");
  ASSERT_FALSE(camera.ok());
  EXPECT_EQ(camera.error().code, "camera_model_unsupported");
}

// A focal length of another unit or size, and a digit too many in one of the two.
TEST(ModelFiles, AFocalLengthThatNoLensHasIsRefused) {
  const auto camera = [](const std::string& fx, const std::string& fy) {
    return parse_camera(
        "image_width: 1280\nimage_height: 720\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [" + fx +
            ", 0, 640, 0, " + fy + ", 360, 0, 0, 1]\n",
        "camera.yaml");
  };
  ASSERT_TRUE(camera("874", "872").ok()) << camera("874", "872").error().message();
  for (const char* focal : {"8.8", "1e7", "0", "-874"}) {
    ASSERT_FALSE(camera(focal, focal).ok()) << focal;
    EXPECT_NE(camera(focal, focal).error().message().find("impossible fx"), std::string::npos);
  }
  ASSERT_FALSE(camera("8740", "872").ok());
  EXPECT_NE(camera("8740", "872").error().message().find("impossible fx / fy"), std::string::npos);
  ASSERT_FALSE(camera("874", ".nan").ok());
  EXPECT_EQ(camera("874", ".nan").error().message(),
            "camera.yaml:6: `camera_matrix` holds '.nan'; wanted finite numbers.");
}

TEST(ModelFiles, AVarianceBelowZeroIsRefused) {
  Camera camera = test_camera(CameraModel::opencv5);
  camera.covariance = Eigen::MatrixXd::Identity(9, 9);
  EXPECT_TRUE(parse_camera(to_opencv_yaml(camera), "camera.yaml").ok());
  camera.covariance(2, 2) = -1.0;
  const auto negative = parse_camera(to_opencv_yaml(camera), "camera.yaml");
  ASSERT_FALSE(negative.ok());
  EXPECT_NE(negative.error().message().find("impossible covariance"), std::string::npos);
  camera.covariance = Eigen::MatrixXd::Identity(9, 9);
  camera.covariance(0, 1) = camera.covariance(1, 0) = 1.5;
  EXPECT_FALSE(parse_camera(to_opencv_yaml(camera), "camera.yaml").ok());
}

/// A damaged file is a camera that can be used or an error that says where.
void expect_sound(const Result<Camera>& camera) {
  if (!camera.ok()) {
    EXPECT_FALSE(camera.error().code.empty());
    EXPECT_FALSE(camera.error().where.empty());
    return;
  }
  EXPECT_TRUE(validate(*camera).ok());
  for (const Eigen::Vector2d& px : {Eigen::Vector2d(0, 0), Eigen::Vector2d(camera->cx, camera->cy)}) {
    const auto ray = unproject_ray(*camera, px);
    EXPECT_TRUE(!ray || ray->allFinite());
  }
}

// Any prefix and any single damaged byte must end in a camera or an error, never in a crash or an exception.
TEST(ModelFiles, DamagedFilesNeverThrow) {
  base::Random random(31);
  Camera camera = test_camera(CameraModel::opencv8);
  camera.covariance = Eigen::MatrixXd::Identity(12, 12);
  Camera small = test_camera(CameraModel::opencv4);
  Camera square = test_camera(CameraModel::opencv5);
  square.fy = square.fx;
  Camera splined = test_camera(CameraModel::splined_stereographic);
  splined.spline = {3, 5, 4, 120};
  splined.distortion.resize(40);
  std::vector<std::string> texts{to_mrcal_cameramodel(camera, "abc"), to_opencv_yaml(camera),
                                 to_mrcal_cameramodel(splined)};
  for (const char* name : {"colmap", "kalibr", "ros"})
    texts.push_back(*export_camera(small, *format_from_name(name)));
  for (const char* name : {"metashape", "pix4d", "matlab"})
    texts.push_back(*export_camera(square, *format_from_name(name)));
  texts.push_back(
      "{\"image_size\": [640, 480], \"model\": \"splined_stereographic\", \"spline\": [3, 4, 4, 90], \"fx\": "
      "500, \"fy\": "
      "500, \"cx\": 320, \"cy\": 240, \"distortion\": "
      "[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0]}");
  texts.push_back(
      "\xFF\xD8\xFF\xE1 "
      "drone-dji:DewarpData=\"2018-09-06;3684.48,3677.57,2.24,22.05,-0.26,0.10,3e-5,-3e-4,-0.03\"");
  for (const std::string& text : texts) {
    for (std::size_t n = 0; n < text.size(); n += 3)
      EXPECT_NO_THROW(expect_sound(parse_camera(text.substr(0, n), "f")));
    for (int trial = 0; trial < 800; ++trial) {
      std::string damaged = text;
      for (int i = 0; i < 1 + trial % 4; ++i) {
        damaged[random.below(static_cast<std::uint32_t>(damaged.size()))] =
            static_cast<char>(random.below(256));
      }
      EXPECT_NO_THROW(expect_sound(parse_camera(damaged, "f")));
    }
  }
}

}  // namespace
}  // namespace furrow::camera
