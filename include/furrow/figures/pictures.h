#pragma once
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/birds_eye.h"
#include "furrow/calib/telling_views.h"
#include "furrow/figures/figures.h"
#include "furrow/image/image.h"

namespace furrow::figures {

/// A picture with the words that stand under it.
struct NamedPicture {
  std::string name;
  Image picture;
};

/// Pictures side by side in reading order, as the steps of row detection. Errors: nothing_to_draw (no
/// picture, or an empty one).
Result<Figure> contact_sheet(const std::string& name, const std::string& caption,
                             const std::vector<NamedPicture>& pictures, const FigureOptions& options = {});

/// What the thesis's following view shows of one shot, px from the middle column, positive to the right.
struct FollowingView {
  std::optional<double> deviation_px;  ///< the followed row at the middle picture row (red)
  std::optional<double> steer_px;      ///< what to steer by (blue)
};

/// The picture with three upright lines: its middle (green), the followed row (red) and the steering line
/// (blue), each also with its own dash and a mark at its foot. Errors: nothing_to_draw (empty picture).
Result<Figure> following_overlay(const Image& picture, const FollowingView& view, const std::string& shot_id,
                                 const FigureOptions& options = {});

/// A shot from straight above with the fitted field (axes and edges at their places) and the rows as found,
/// on axes of metres from the camera's foot. Errors: nothing_to_draw (empty view).
Result<Figure> birds_eye(const altitude::BirdsEye& view, const std::string& shot_id,
                         const FigureOptions& options = {});

/// Every corner's residual (observed - projected) as an arrow from its place in the picture, enlarged by a
/// stated factor: a pattern here is what the lens model leaves over. Errors: nothing_to_draw (no used view).
Result<Figure> residual_map(const calib::Calibration& calibration, const FigureOptions& options = {});

/// One of the telling views over its photograph, `corners_view_<number>`: corners as found and as projected, what
/// lies between enlarged by a stated factor and coloured by length, alike for all of `views`; corners left out
/// apart; the board's first corner and axes. `picture` is the part of the photograph that the view names, at any
/// scale. A view without corners is the photograph alone. Errors: nothing_to_draw (empty picture).
Result<Figure> corners_overlay(const Image& picture, const calib::Calibration& calibration,
                               const calib::TellingViews& views, std::size_t which,
                               const FigureOptions& options = {});

}  // namespace furrow::figures
