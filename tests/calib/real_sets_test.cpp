// Real pictures: the same corners must give OpenCV's calibrateCamera no better fit than ours, and the same
// camera.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <opencv2/calib3d.hpp>

#include "furrow/base/file.h"
#include "furrow/calib/calibrate.h"

namespace furrow::calib {
namespace {

std::filesystem::path data_folder() {
  const char* set = std::getenv("FURROW_DATA");
  return set != nullptr ? std::filesystem::path(set)
                        : std::filesystem::path(FURROW_SOURCE_DIR) / "../shared/data";
}

struct Witness {
  double rms_px, fx;
};

Witness opencv_solves(const std::vector<target::BoardDetection>& detections, const target::BoardSpec& board) {
  std::vector<std::vector<cv::Point3f>> in_board;
  std::vector<std::vector<cv::Point2f>> px;
  cv::Size size;
  for (const target::BoardDetection& one : detections) {
    if (!one.found) continue;
    size = {one.width, one.height};
    in_board.emplace_back();
    px.emplace_back();
    for (const Eigen::Vector3d& x : target::corners_in_board(board)) {
      in_board.back().emplace_back(static_cast<float>(x.x()), static_cast<float>(x.y()), 0.0F);
    }
    for (const Eigen::Vector2d& p : one.corners_px)
      px.back().emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  cv::Mat k, d;
  std::vector<cv::Mat> rotations, translations;
  const double rms_px =
      cv::calibrateCamera(in_board, px, size, k, d, rotations, translations, 0,
                          cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 200, 1e-12));
  return {rms_px, k.at<double>(0, 0)};
}

struct RealSet {
  const char* name;
  const char* pattern;  ///< under the data folder unless absolute
  int corners_x, corners_y;
  double square_m;
  int fewest_boards;
  double largest_rms_px;  ///< measured, rounded up: catches corners that get worse
};

// Boards found: left and right of opencv-doc, Bumblebee and Sony in every picture; Mini SE has three
// byte-identical copies.
constexpr RealSet kSets[] = {
    {"opencv_left", "/usr/share/doc/opencv-doc/examples/data/left??.jpg", 9, 6, 0.025, 13, 0.19},
    {"opencv_right", "/usr/share/doc/opencv-doc/examples/data/right??.jpg", 9, 6, 0.025, 13, 0.20},
    {"sourishg", "calib/sourishg-left/images/*.jpg", 9, 6, 0.02423, 29, 0.18},
    {"sony", "calib/boofcv-sony-hx5v/images/*.jpg", 6, 4, 0.030, 13, 0.16},
    {"bumblebee_left", "calib/boofcv-bumblebee2-left/images/*.jpg", 6, 4, 0.030, 11, 0.09},
    {"bumblebee_right", "calib/boofcv-bumblebee2-right/images/*.jpg", 6, 4, 0.030, 11, 0.09},
    {"gopro", "calib/gopro-hero4-udacity/images/*.jpg", 8, 6, 0.030, 35, 0.60},
    {"mini_se", "flights/mini-se/checkerboard/*.jpg", 9, 6, 0.025, 12, 0.16},
};

class RealSets : public ::testing::TestWithParam<RealSet> {};

TEST_P(RealSets, FitIsNoWorseThanOpenCvs) {
  const RealSet& set = GetParam();
  const auto files = base::expand_pattern(set.pattern, data_folder());
  if (!files.ok())
    GTEST_SKIP() << "no pictures: " << files.error().message() << " (set FURROW_DATA, install opencv-doc)";
  const target::BoardSpec board{set.name, set.corners_x, set.corners_y, set.square_m, 1.0};
  const auto detections = target::detect_boards(*files, board);
  const auto found = calibrate(detections, board);
  ASSERT_TRUE(found.ok()) << found.error().message();
  int used = 0;
  for (const View& view : found->views) used += view.used ? 1 : 0;
  EXPECT_GE(used, set.fewest_boards);
  EXPECT_LT(found->rms_px, set.largest_rms_px);
  // OpenCV takes corners as float: 3e-5 px at 1000 px is its own rounding.
  const Witness witness = opencv_solves(detections, board);
  EXPECT_LT(found->rms_px, witness.rms_px + 0.001);
  EXPECT_NEAR(found->rms_px, witness.rms_px, 0.01);
  const double sigma_fx = std::sqrt(found->camera.covariance(0, 0));
  EXPECT_NEAR(found->camera.fx, witness.fx, 0.1 * sigma_fx);
}

INSTANTIATE_TEST_SUITE_P(Calib, RealSets, ::testing::ValuesIn(kSets),
                         [](const auto& set) { return std::string(set.param.name); });

}  // namespace
}  // namespace furrow::calib
