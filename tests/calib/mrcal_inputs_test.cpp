// mrcal's own Python opens what we write and computes its uncertainty from it.
#include "furrow/calib/mrcal_inputs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <sstream>

#include "calib/npz.h"
#include "calib/synthetic.h"
#include "furrow/base/file.h"
#include "furrow/calib/uncertainty.h"
#include "furrow/camera/model_files.h"

namespace furrow::calib {
namespace {

// What base64.b85encode(b"furrow!") says in Python.
TEST(MrcalInputs, Base85IsPythons) {
  EXPECT_EQ(base85(""), "");
  EXPECT_EQ(base85(std::string("\0\0\0\0", 4)), "00000");
  EXPECT_EQ(base85("furrow!"), "W_5CMZ+9U");
}

bool has_mrcal() {
  return std::system("/usr/bin/python3 -c 'import mrcal' > /dev/null 2>&1") == 0;
}

/// Runs Python on the folder's camera.cameramodel; its numbers.
std::vector<double> python_says(const std::filesystem::path& folder, const std::string& script) {
  EXPECT_TRUE(base::write_file(folder / "ask.py", script).ok());
  const std::string command =
      "cd '" + folder.string() + "' && /usr/bin/python3 ask.py > said.txt 2> error.txt";
  EXPECT_EQ(std::system(command.c_str()), 0) << *base::read_file(folder / "error.txt");
  std::istringstream said(*base::read_file(folder / "said.txt"));
  std::vector<double> out;
  for (double value = 0.0; said >> value;) out.push_back(value);
  return out;
}

TEST(MrcalInputs, MrcalComputesOurUncertaintyFromOurFile) {
  if (!has_mrcal()) GTEST_SKIP() << "no mrcal for /usr/bin/python3 (install python3-mrcal)";
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "furrow_mrcal_inputs";
  std::filesystem::create_directories(folder);
  auto views = session(true_camera(), true_board(), Session{});
  views[3].corners_px[7] += Eigen::Vector2d(9.0, -4.0);  // one corner rejected
  CalibrateOptions options;
  options.corner_outlier_sigmas = 6.0;
  for (const bool warp : {false, true}) {
    options.solve_warp = warp;
    const auto found = calibrate(views, true_board(), options);
    ASSERT_TRUE(found.ok());
    ASSERT_TRUE(
        base::write_file(folder / "camera.cameramodel",
                         camera::to_mrcal_cameramodel(found->camera, mrcal_optimization_inputs(*found)))
            .ok());
    std::string script =
        "import mrcal, numpy as np\nm = mrcal.cameramodel('camera.cameramodel')\n"
        "f, c = m.intrinsics(), m.imagersize()\n"
        "for q in ((640., 360.), (200., 120.), (1080., 600.), (30., 30.)):\n"
        "  v = mrcal.unproject(np.array(q), *f, normalize=True)\n"
        "  for far, p in ((False, v * 0.8), (True, v)):\n"
        "    print(mrcal.projection_uncertainty(p, model=m, atinfinity=far, what='worstdirection-stdev', "
        "observed_pixel_uncertainty=" +
        std::to_string(found->sigma0_px) + "))\n";
    const std::vector<double> said = python_says(folder, script);
    ASSERT_EQ(said.size(), 8U);
    std::size_t at = 0;
    for (const Eigen::Vector2d& px : {Eigen::Vector2d(640, 360), Eigen::Vector2d(200, 120),
                                      Eigen::Vector2d(1080, 600), Eigen::Vector2d(30, 30)}) {
      for (const double distance_m : {0.8, std::numeric_limits<double>::infinity()})
        EXPECT_NEAR(*projection_sigma_px(*found, px, distance_m) / said[at++], 1.0, 0.01)
            << px.transpose() << " at " << distance_m;
    }
  }
}

// mrcal's own optimiser, started from our solution and its regularisation off, stays where it is.
TEST(MrcalInputs, MrcalsOptimiserFindsNothingToMend) {
  if (!has_mrcal()) GTEST_SKIP() << "no mrcal for /usr/bin/python3 (install python3-mrcal)";
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "furrow_mrcal_optimum";
  std::filesystem::create_directories(folder);
  const auto found = calibrate(session(true_camera(), true_board(), Session{}), true_board());
  ASSERT_TRUE(found.ok());
  ASSERT_TRUE(base::write_file(folder / "camera.cameramodel",
                               camera::to_mrcal_cameramodel(found->camera, mrcal_optimization_inputs(*found)))
                  .ok());
  const std::vector<double> said = python_says(
      folder,
      "import mrcal\nm = mrcal.cameramodel('camera.cameramodel')\no = m.optimization_inputs()\n"
      "r = mrcal.optimize(**o)['rms_reproj_error__pixels']\nprint(r)\nprint(*o['intrinsics'][0])\n");
  ASSERT_EQ(said.size(), 10U);
  EXPECT_NEAR(std::sqrt(2.0) * said[0], found->rms_px, 1e-4);  // mrcal's is per coordinate
  EXPECT_NEAR(said[1], found->camera.fx, 0.05 * std::sqrt(found->camera.covariance(0, 0)));
}

TEST(MrcalInputs, NothingWhereMrcalHasNoSuchProblem) {
  auto found = calibrate(session(true_camera(), true_board(), Session{}), true_board());
  ASSERT_TRUE(found.ok());
  Calibration stretched = *found;
  stretched.board.aspect = 1.01;
  EXPECT_EQ(mrcal_optimization_inputs(stretched), "");
  Calibration fisheye = *found;
  fisheye.camera.model = camera::CameraModel::fisheye;
  EXPECT_EQ(mrcal_optimization_inputs(fisheye), "");
}

}  // namespace
}  // namespace furrow::calib
