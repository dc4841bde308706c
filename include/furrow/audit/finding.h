#pragma once
#include <string>
#include <vector>

#include "furrow/audit/shot_record.h"
#include "furrow/calib/verdict.h"

namespace furrow::audit {

enum class Verdict { pass, fail, not_assessed };

/// A value against a limit, with the evidence.
struct Finding {
  std::string id;     ///< "calibration.rms", "heights.log_agreement", ...
  std::string title;  ///< one line for a person
  Verdict verdict = Verdict::not_assessed;
  std::string value;     ///< "0.41 px", "0.30 m"
  std::string limit;     ///< "at most 0.5 px"
  std::string evidence;  ///< shots, views and numbers that led to it; why not, when not assessed
};

/// Limits of the findings. Each is a plain reading of the quantity; change them for the job at hand.
struct Limits {
  double calibration_rms_px =
      1.0;  ///< RMS above this: blurred boards, a wrong board file or a wrong lens model
  double shots_with_height = 0.8;  ///< share of shots that must have a height
  double log_height_sigmas =
      3.0;  ///< mean difference of log and refined height, in its own sigma plus log_height_m
  double log_height_m = 0.5;    ///< what a barometric height is allowed to be off over a flight, m
  double focal_share = 0.03;    ///< focal length outside the range of the metadata, as a share; lenses are
                                ///< named within a few percent
  double pitch_bias_deg = 1.5;  ///< mean of refined minus gimbal pitch
};

/// The focal length in use against the one that the pictures' metadata state (35 mm equivalent). The
/// equivalent is by the diagonal (43.27 mm) of a sensor whose shape is not stated, so 4:3, 3:2 and 16:9 give
/// a range; a camera outside it by more than the limit was calibrated in another mode, zoom or crop than the
/// shots. Heights scale one to one with the focal length. `focal_px` at pictures of `width_px`;
/// `focal_length_35mm_mm` NaN is not assessed.
Finding assess_focal(double focal_px, int width_px, double focal_length_35mm_mm, const Limits& limits = {});

/// Reprojection error, and whether the calibration's own verdict trusts it.
std::vector<Finding> assess_calibration(const calib::Calibration& calibration, const calib::Verdict& verdict,
                                        const Limits& limits = {});

/// `row_height_m` takes the canopy heights to the ground for the comparison with the log; NaN leaves that
/// finding not assessed.
std::vector<Finding> assess_shots(const std::vector<ShotRecord>& records, double row_height_m,
                                  const Limits& limits = {});

}  // namespace furrow::audit
