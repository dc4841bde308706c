#pragma once
#include <string>
#include <vector>

#include "furrow/camera/compare.h"
#include "furrow/camera/describe.h"
#include "furrow/figures/figures.h"

namespace furrow::figures {

/// How often which residual occurred, both coordinates together, with the Gaussian of their standard
/// deviation. Errors: nothing_to_draw (no used view).
Result<Figure> residual_histogram(const calib::Calibration& calibration, const FigureOptions& options = {});

/// Every corner that was used, over the cells of the coverage criterion with the count of corners in each.
/// Errors: nothing_to_draw (no used view).
Result<Figure> coverage_map(const calib::Calibration& calibration, const FigureOptions& options = {});

/// A quantity over the picture, cell by cell.
struct PictureMap {
  std::string name;      ///< file stem, snake_case
  std::string quantity;  ///< with unit: "projection sigma at infinity / px"
  std::string caption;
  int columns = 0, rows = 0;
  int width_px = 0, height_px = 0;  ///< of the picture
  std::vector<double> values;       ///< row by row; NaN is left white and named
};
/// Cells in viridis with a colour bar. Errors: nothing_to_draw (no finite value).
Result<Figure> picture_map(const PictureMap& map, const FigureOptions& options = {});

/// The length of the difference of two cameras over the picture, as a map to draw.
PictureMap difference_map(const std::string& name, const std::string& caption, const Camera& camera,
                          const camera::CameraDifference& difference);

/// How far the lens moves a pixel from where a pinhole of the same focal length has it, over the distance
/// from the principal point. Errors: nothing_to_draw (no ray).
Result<Figure> distortion_curve(const std::vector<camera::DistortionPoint>& curve,
                                const FigureOptions& options = {});

}  // namespace furrow::figures
