#pragma once
#include <cstdint>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "furrow/camera/camera.h"
#include "furrow/geom/rigid3.h"
#include "furrow/stats/estimate.h"
#include "furrow/target/board.h"
#include "furrow/target/detect.h"

namespace furrow::calib {

struct CalibrateOptions {
  camera::CameraModel model = camera::CameraModel::opencv5;
  /// A view whose own RMS is over this many times the median view's RMS is dropped and the rest solved again,
  /// until none is; 0 keeps all. 3 drops what a person would.
  double view_outlier_ratio = 0.0;
  /// A corner farther from its projection than this many times the noise is left out and the rest solved
  /// again, until none is; 0 keeps all, 5 is beyond one in a hundred thousand of Gaussian ones. The noise is
  /// the median distance over 1.1774 (Rayleigh's median).
  double corner_outlier_sigmas = 0.0;
  int max_iterations = 200;
  /// Weigh each corner by 1 / sigma_px^2 of its detection (relative to the mean); off, all corners count the
  /// same, as in OpenCV.
  bool use_corner_sigma = false;
  /// fx = fy. For sensors with square pixels; needed to free the board's aspect.
  bool square_pixels = false;
  /// Solve the board's aspect (height / width of a square), for boards on monitors and stretched prints.
  /// Implies square_pixels: both aspects at once cannot be told apart.
  bool solve_aspect = false;
  /// Solve how far the board bends along x and y: two parabolas, as mrcal's calobject_warp.
  bool solve_warp = false;
};

/// What became of one picture.
struct View {
  std::string image;
  bool used = false;
  double rms_px = 0.0;  ///< root mean square over its corners of the distance in px; NaN when not used
  double mean_error_px =
      0.0;             ///< mean distance in px, the thesis's "mean reprojection error"; NaN when not used
  std::string reason;  ///< why it was not used; empty when it was
  /// What the search for its board cost, and whether it left something out: target::BoardDetection.
  std::int64_t search_steps = 0;
  bool search_cut = false;
  Rigid3 cam_from_board;
  std::vector<Eigen::Vector2d> observed_px;
  /// Which corner each one is (a place in target::corners_in_board); empty: all of them.
  std::vector<int> corner_ids;
  std::vector<Eigen::Vector2d> residual_px;  ///< observed - projected
  std::vector<double> weight;                ///< of each corner in the solve; empty: all alike
  std::vector<bool>
      left_out;  ///< corners rejected as outliers; empty when none was looked for. Not counted in rms_px.
};

/// A solved camera with everything a report needs.
struct Calibration {
  Camera camera;  ///< with covariance
  target::BoardSpec board;
  std::vector<View> views;  ///< in the order of the detections
  double rms_px =
      0.0;  ///< sqrt(sum of squared distances / corners): OpenCV's definition (mrcal prints this / sqrt 2)
  double mean_error_px = 0.0;  ///< mean distance over all corners, the thesis's number
  int corners = 0;             ///< counted in rms_px
  int corners_left_out = 0;  ///< rejected as outliers; a share of some percent hides a lens of another model
  int iterations = 0;
  std::string termination;  ///< Ceres' own words
  bool usable = false;
  /// Residual standard deviation per coordinate, px: sqrt(squared sum / degrees of freedom). It scales the
  /// covariance.
  double sigma0_px = 0.0;
  int degrees_of_freedom = 0;  ///< 2 corners - parameters, poses counted
  /// Covariance of (intrinsics, the board's aspect, its warp along x and y), 0 for what was not solved; the
  /// camera's own is its top-left part. 0 x 0 when unknown.
  Eigen::MatrixXd lens_and_board_covariance;
  /// Covariance of (intrinsics, mean turn of the boards as seen from the camera in rad, their mean shift in
  /// m): all that projection uncertainty needs of the poses. 0 x 0 when unknown.
  Eigen::MatrixXd drift_covariance;
  Estimate board_aspect;  ///< observations 0 when it was not solved
  Estimate
      board_warp_x_m;  ///< height of the board's middle over its ends along x; observations 0 when not solved
  Estimate board_warp_y_m;
  /// How the lens model was chosen, in words; empty when it was named by the caller.
  std::string model_choice;
  /// What a person should know before using this camera, one sentence each.
  std::vector<std::string> warnings;
};

/// Solves intrinsics and board poses together (docs/formulation.md). Start values need no guess.
/// Errors: too_few_boards (fewer than 3 usable), picture_sizes_differ (names two pictures), solve_failed
/// (with the solver's reason).
Result<Calibration> calibrate(const std::vector<target::BoardDetection>& detections,
                              const target::BoardSpec& board, const CalibrateOptions& options = {});

/// calibration.json: image_size, model, fx fy cx cy, distortion, rms_px, views[] {image, used, rms_px,
/// reason}, covariance, ...
std::string to_json(const Calibration& calibration);

}  // namespace furrow::calib
