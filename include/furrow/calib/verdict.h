#pragma once
#include <optional>
#include <string>
#include <vector>

#include "furrow/calib/calibrate.h"
#include "furrow/calib/views.h"
#include "furrow/camera/compare.h"

namespace furrow::calib {

/// What a calibration must reach to be trusted with a height. The defaults are for heights good to about a
/// percent.
struct TrustLimits {
  /// Largest one-sigma of the focal length, percent: it is the height's error, one to one.
  double focal_sigma_percent = 0.5;
  /// Largest RMS, px per 1280 px of width: above, the lens model or the corners are wrong, whatever the sigma
  /// says.
  double rms_px_per_1280 = 1.0;
  /// Smallest angle between the two boards that differ most, degrees: below, focal length and distance cannot
  /// be told apart.
  double smallest_tilt_deg = 15.0;
  /// Smallest share of the picture's 6 x 4 cells that hold a corner.
  double smallest_coverage = 0.5;
  /// Fewest views; halves of three each can still be compared.
  int fewest_views = 6;
  /// Largest difference of the focal lengths of two halves of the views, percent.
  double halves_focal_percent = 1.0;
  /// Largest share of corners rejected as outliers, percent: a wrong lens model hides behind many.
  double left_out_percent = 3.0;
  /// How far fx / fy may be from 1, percent, before the board's squares are doubted: sensors have square
  /// pixels.
  double aspect_percent = 0.5;
};

/// One condition against its limit.
struct Criterion {
  std::string name;    ///< "focal_sigma", "rms", "tilt", "coverage", "views", "outliers", "halves", "aspect",
                       ///< "zoom", "bend"
  double value = 0.0;  ///< NaN when it could not be assessed
  double limit = 0.0;
  bool met = false;
  std::string sentence;  ///< what it means and what to do
};

/// Whether the calibration can be trusted, why, and by how much its sigmas should be widened.
struct Verdict {
  bool trusted = false;
  std::vector<Criterion> criteria;
  /// "Enough." or "Do not trust: ..." with the conditions that fail.
  std::string summary;
  /// Difference of two halves over what their covariances predict, at least 1; NaN when the views do not make
  /// two halves.
  double sigma_factor = 1.0;
  double halves_rms_px =
      0.0;  ///< root mean square difference of the two halves over the picture; NaN as above
  double halves_expected_rms_px = 0.0;             ///< what their covariances predict for it
  std::optional<camera::CameraDifference> halves;  ///< of the two halves over the picture, for a map
  std::vector<std::string> next_pictures;          ///< what is missing among the boards, in words
  std::vector<NextView> next_views;                ///< which pictures would help most, in this order
  std::vector<ViewGain> gains;                     ///< what each view adds, in the views' order
};

/// Judges a calibration that calibrate() made of these detections with these options; solves two halves of
/// the views (every other in name order).
Verdict judge(const Calibration& calibration, const std::vector<target::BoardDetection>& detections,
              const CalibrateOptions& options = {}, const TrustLimits& limits = {});

/// The camera with its covariance widened by the verdict's factor squared, for stages that take its sigma at
/// its word.
Camera widened_camera(const Calibration& calibration, const Verdict& verdict);

/// Largest angle between the normals of two used boards, radians; NaN for fewer than two.
double largest_tilt_rad(const Calibration& calibration);

/// Count of corners in each of columns x rows cells of the picture, row by row.
std::vector<int> coverage(const Calibration& calibration, int columns, int rows);

/// The verdict as JSON, for calibration reports.
std::string to_json(const Verdict& verdict);

}  // namespace furrow::calib
