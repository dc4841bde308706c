#pragma once
#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "furrow/rows/planar_field.h"
#include "furrow/stats/estimate.h"

namespace furrow::rows {

/// One cut across a row of plants.
struct RowSample {
  Eigen::Vector2d centre_px;                                   ///< middle of the visible row
  double sigma_px = std::numeric_limits<double>::quiet_NaN();  ///< of the centre, across the row
  /// Where the visible green begins and ends on the same picture row; NaN when that side is not seen (out of
  /// the picture, or grown into the neighbour).
  double left_u_px = std::numeric_limits<double>::quiet_NaN();
  double right_u_px = std::numeric_limits<double>::quiet_NaN();
  double edge_sigma_px = std::numeric_limits<double>::quiet_NaN();
  /// The far edge of the row's top where leaves of the next row stand behind it, told by its light; NaN where
  /// it was not found. On the left of rows left of the followed one, on the right of the others.
  double top_left_u_px = std::numeric_limits<double>::quiet_NaN();
  double top_right_u_px = std::numeric_limits<double>::quiet_NaN();
  double top_sigma_px = std::numeric_limits<double>::quiet_NaN();  ///< common to all samples of the row
  /// False where only the common field model carries the row: outside the picture, or nothing green near it.
  bool seen = true;
};

/// One row of plants in a picture.
struct RowLine {
  int index = 0;  ///< from left to right; 0 is the followed row: nearest the picture's middle column at its
                  ///< middle row
  std::vector<RowSample> samples;  ///< from top to bottom, at most 10 px apart
  /// Half the width between the edges where the row crosses the picture's middle row, or nothing: of the
  /// outline as it is seen from there, which at grazing angles is that of the outermost leaves. The sigma is
  /// the outline's.
  std::optional<Estimate> half_width_px;
  /// True when the row was seen itself; false when only the common field model carries it.
  bool seen = true;
};

/// All that was found in one picture.
struct RowLines {
  std::string method;         ///< "thesis" or "field"
  int width = 0, height = 0;  ///< of the picture, px
  /// Common point of the rows; nothing when they are parallel in the picture (nadir).
  std::optional<Eigen::Vector2d> vanishing_point_px;
  std::vector<RowLine> rows;  ///< by index
  /// Probability that the rows are right, in [0, 1].
  double confidence = 0.0;
  std::string status = "not run";  ///< "ok", or a code: "no_rows", "picture_unreadable", ...
  std::string reason;              ///< a sentence when status is not "ok"
  /// The common model of all rows, px of the picture (method "field" only). Where horizon_slope is not 0, of
  /// the picture levelled by it: v - horizon_slope (u - middle column).
  std::optional<PlanarField> field;
  double horizon_slope = 0.0;  ///< dv/du of the horizon that was told (Priors::horizon_slope), or that
                               ///< the rows showed
  double score = 0.0;  ///< mean correlation of the picture with the field's rows (method "field" only)
  double tooth = 0.0;  ///< width of a row that explains most, spacings (method "field" only)

  bool ok() const { return status == "ok"; }
};

/// u of the row's centre line on picture row `v` (linear between samples, extended by at most 10 px), or
/// nothing.
std::optional<double> u_at(const RowLine& row, double v);

}  // namespace furrow::rows
