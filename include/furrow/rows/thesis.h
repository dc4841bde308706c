#pragma once
#include <string>
#include <vector>

#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"

namespace furrow::rows {

/// The thesis's chain, THESIS section 3, with its defaults where it gives them. Lengths in px of the working
/// picture, fractions of its height.
struct ThesisOptions {
  int width = 320, height = 180;  ///< working size (thesis: 320x180)
  /// Green band in HSV, OpenCV's units (hue 0 to 180, saturation and value 0 to 255). The thesis says "green
  /// mask" without numbers; these are the usual limits of green, 60 to 180 deg of hue. Widen for yellowing
  /// leaves.
  int hue_low = 30, hue_high = 90, saturation_low = 40, value_low = 20;
  double clear_top = 0.10;     ///< part of the height at the top that is cleared: sky, far field
  double clear_bottom = 0.05;  ///< part at the bottom
  double crop_top = 0.20;      ///< rows show from this height on; nothing above is used
  int clear_side_px = 2;       ///< cleared at the left and right border
  int blur_px = 5;             ///< box of the blur, odd
  /// The thesis found the blur steadier after the binary picture than before it.
  bool blur_after_threshold = true;
  int dilations = 2, erosions = 2;  ///< 3x3 each, after Otsu's threshold
  int skeleton_erosions = 4;  ///< repeated erosion that thins the rows, stopped for parts that would vanish
  int wanted_rows = 3;        ///< the sweep of the Hough threshold ends when so many rows are found
  int hough_start = 150, hough_stop = 20, hough_step = 2;  ///< votes
  double hough_rho_px = 1.0, hough_theta_deg = 1.0;
  double most_tilt_deg = 75.0;  ///< lines farther from vertical are faulty
  double same_rho_px = 30.0;    ///< lines closer than this on the middle row ...
  double same_theta_deg =
      10.0;  ///< ... or crossing each other at less than this and closer than twice same_rho_px are one row
};

/// One step of the chain as a picture (thesis figures 3.4 to 3.8).
struct StepPicture {
  std::string name;  ///< "01_green_mask", ... in order
  Image picture;
};

/// Rows by the thesis's chain, in px of the full picture, straight from its top to its bottom.
RowLines detect_thesis(const Image& picture, const ThesisOptions& options = {});

/// Every step of the same run, in order. Empty for an empty picture.
std::vector<StepPicture> thesis_steps(const Image& picture, const ThesisOptions& options = {});

}  // namespace furrow::rows
