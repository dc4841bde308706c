#pragma once
#include <optional>
#include <vector>

#include "furrow/rows/row_lines.h"

namespace furrow::follow {

/// The thesis's half width of a row in pictures of 320x180 (section 4; 10 to 20 seen).
inline constexpr double kThesisHalfWidthPx = 15.0;
inline constexpr int kThesisWidthPx = 320;
inline constexpr double kThesisHalfWidthCm = 60.0;

/// d = x1 - x0: the followed row's place on the middle picture row against the middle column, px; positive
/// when the row is to the right. Nothing when no row crosses the middle.
std::optional<double> deviation_px(const rows::RowLines& lines);

/// cm = d x 60 / half width in px (thesis, section 4).
double deviation_cm(double deviation_px, double half_width_px = kThesisHalfWidthPx);

/// Half width of the followed row at the picture's middle row as the picture shows it, or nothing.
std::optional<Estimate> half_width_px(const rows::RowLines& lines);

/// Steering rule of the thesis: the mean of the last five deviations (fewer at the start), and the new
/// deviation when its magnitude is smaller than the mean's, else the mean. The thesis compares without
/// absolute values; this compares magnitudes.
struct Steering {
  std::optional<double> deviation_px;  ///< of this shot
  std::optional<double> average_px;    ///< of the last five that had one
  std::optional<double> steer_px;      ///< what to steer by; nothing means hold
  std::vector<double> last_px;         ///< those averaged, oldest first: what the next step needs
};
/// One more picture after `before`; a default Steering stands before the first.
Steering thesis_step(const Steering& before, const std::optional<double>& deviation_px);
/// A whole sequence.
std::vector<Steering> thesis_steering(const std::vector<std::optional<double>>& deviations_px);

}  // namespace furrow::follow
