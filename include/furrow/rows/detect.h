#pragma once
#include <optional>
#include <string>

#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"
#include "furrow/rows/thesis.h"

namespace furrow::rows {

enum class Method {
  thesis,  ///< the thesis's chain: green mask, Otsu, morphology, skeleton, swept Hough (thesis.h)
  field,   ///< one planar field of equally spaced rows fitted to the whole picture (default)
};

/// What is known about the shot before looking; each part helps and none is needed.
struct Priors {
  std::optional<double>
      horizon_v_px;  ///< picture row of the horizon at the middle column, from gimbal pitch and intrinsics
  double horizon_sigma_px = 40.0;
  /// dv/du of the horizon, from the gimbal's roll: the picture is levelled by it before the search. Below
  /// 0.01 and from 1 on it is not used. Without it the rows tell a tilt of 0.06 and more, up to a roll of
  /// about 20 deg.
  std::optional<double> horizon_slope;
};

/// What the shot before in a sequence showed; of its RowLines.
struct Previous {
  PlanarField field;           ///< px of the picture
  double tooth = 0.3;          ///< RowLines::tooth
  double score = 0.0;          ///< RowLines::score
  double horizon_slope = 0.0;  ///< RowLines::horizon_slope
};

/// Nothing when `lines` has no field.
std::optional<Previous> previous_of(const RowLines& lines);

struct DetectOptions {
  Method method = Method::field;
  Priors priors;
  /// Rows of the shot before, of a picture of the same size: they start this search, which then takes half
  /// the time. When they no longer fit (the score falls below 0.7 of theirs), the whole picture is searched
  /// as without them.
  std::optional<Previous> previous;
  ThesisOptions thesis;  ///< read by Method::thesis only
  /// Least score of the field method: below it the answer is "no_rows". The score is the mean correlation of
  /// the picture's strips with the field's rows; noise and lawn score below 0.04, the poorest real rows about
  /// 0.08, clear rows above 0.25. Raise it when a missed picture costs less than a wrong one.
  double least_score = 0.06;
  /// Step between the samples of a row, px of the picture; 10 at most.
  double sample_step_px = 10.0;
  /// Pixels of the reduced picture in which rows get their own edges. Fewer are faster, and edges coarser:
  /// their sigma is at least a quarter of such a pixel.
  double shape_pixels = 1280.0 * 720.0;
};

/// Finds the rows of a picture. Never fails: a picture without rows has a status that says so.
RowLines detect(const Image& picture, const DetectOptions& options = {});

}  // namespace furrow::rows
