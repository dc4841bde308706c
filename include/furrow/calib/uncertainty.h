#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "furrow/calib/calibrate.h"

namespace furrow::calib {

/// Covariance (px^2) of where a point projects that is seen at `px` from `distance_m` along its ray (infinity
/// allowed: a direction), by mrcal's definition: the point keeps its place among the boards, so what a change
/// of the lens and a change of the poses have in common drops out (docs/formulation/calibration.md, eq. 7).
/// Grows away from where the boards were, in the picture and in depth. Nothing where the camera has no ray
/// for `px` or the calibration no covariance.
std::optional<Eigen::Matrix2d> projection_covariance(const Calibration& calibration,
                                                     const Eigen::Vector2d& px, double distance_m);

/// Standard deviation in the worst direction, px: the number that mrcal's maps show.
std::optional<double> projection_sigma_px(const Calibration& calibration, const Eigen::Vector2d& px,
                                          double distance_m);

/// A quantity at the middles of columns x rows cells of the picture, row by row; NaN where there is none.
struct UncertaintyMap {
  int columns = 0, rows = 0;
  std::vector<double> values;
};
/// projection_sigma_px() over the picture.
UncertaintyMap projection_sigma_map(const Calibration& calibration, double distance_m, int columns = 48,
                                    int rows = 32);

/// One-sigma error, in percent, of a height that is found from a known length seen between the middle of the
/// picture and `px`, `distance_m` away: of the two pixels' distance, radially. Towards the middle it becomes
/// the focal length's. Nothing where projection_covariance() has nothing.
std::optional<double> height_error_percent_at(const Calibration& calibration, const Eigen::Vector2d& px,
                                              double distance_m);
UncertaintyMap height_error_map(const Calibration& calibration, double distance_m, int columns = 48,
                                int rows = 32);

/// Root mean square, over the picture, of the standard deviation (px, both coordinates together) of where a
/// direction is seen, with what a turn of the camera would do as well taken out: one number for how well the
/// lens is known. Nothing without a covariance.
std::optional<double> picture_sigma_px(const Camera& camera);

/// One-sigma height error, in percent of the height, that the focal length alone causes: a height from a
/// known length on the ground goes with f one to one. Nothing without a covariance.
std::optional<double> height_error_percent(const Camera& camera);

}  // namespace furrow::calib
