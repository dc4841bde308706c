#pragma once
#include <optional>
#include <vector>

#include "furrow/rows/row_lines.h"

namespace furrow::follow {

/// The thesis's half width of a row in pictures of 320x180 (section 4; 10 to 20 seen).
inline constexpr double kThesisHalfWidthPx = 15.0;
inline constexpr double kThesisHalfWidthCm = 60.0;

/// d = x1 - x0: the followed row's place on the middle picture row against the middle column, px; positive
/// when the row is to the right. Nothing when no row crosses the middle.
std::optional<double> deviation_px(const rows::RowLines& lines);

/// cm = d x 60 / half width in px (thesis, section 4).
double deviation_cm(double deviation_px, double half_width_px = kThesisHalfWidthPx);

/// Steering rule of the thesis over a sequence: the mean of the last five deviations (fewer at the start),
/// and the new deviation when its magnitude is smaller than the mean's, else the mean. The thesis compares
/// without absolute values; this compares magnitudes.
struct Steering {
  std::optional<double> deviation_px;  ///< of this shot
  std::optional<double> average_px;    ///< of the last five that had one
  std::optional<double> steer_px;      ///< what to steer by; nothing means hold
};
std::vector<Steering> thesis_steering(const std::vector<std::optional<double>>& deviations_px);

}  // namespace furrow::follow
