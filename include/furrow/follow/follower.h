#pragma once
#include <limits>
#include <optional>
#include <string>

#include "furrow/follow/guidance.h"
#include "furrow/follow/same_row.h"
#include "furrow/follow/thesis.h"
#include "furrow/follow/track_filter.h"

/// Following one row through a sequence, picture by picture: what a picture shows -> row number -> filter ->
/// guidance (docs/formulation/follow.md).
namespace furrow::follow {

/// What one picture says. "Offset" is the camera's cross-track in metres where the camera and a length are
/// known, else the thesis's deviation in px: both positive when the row is to the right, so one rule serves
/// both.
struct Sighting {
  base::Nanoseconds t_video_ns = 0;
  std::string status = "not run";  ///< "ok", or why nothing is known: a code ...
  std::string reason;              ///< ... and a sentence
  RowPlace place;
  std::optional<double> deviation_px;                         ///< of row 0
  std::optional<Estimate> half_width_px;                      ///< of row 0
  Estimate offset;                                            ///< from row 0
  double spacing = std::numeric_limits<double>::quiet_NaN();  ///< between rows, in the offset's unit
  /// Of `spacing`, and its covariance with the offset: what an offset from row k carries besides row 0's.
  double spacing_sigma = 0.0, offset_spacing_covariance = 0.0;
  Estimate heading_rad;  ///< camera against the rows, positive to the left
};

/// All that the rows of one picture say without a camera: deviation and spacing in px.
Sighting sighting_of(const rows::RowLines& lines, base::Nanoseconds t_video_ns);

/// What steering goes by.
enum class Rule {
  filtered,  ///< the offset through a Kalman filter (default)
  thesis,    ///< deviation or mean of five, whichever is smaller in magnitude
};

/// Which row is followed when the camera drifts past the middle between two.
enum class Hold {
  row,      ///< the row that was followed first, as long as rows can be told apart
  nearest,  ///< always the nearest to the picture's middle, as the thesis does
};

/// What the thesis's centimetres are counted by.
enum class HalfWidth {
  thesis,    ///< its 15 px at 320 px of width, in proportion for wider pictures
  measured,  ///< the followed row's own in each picture; no centimetres where it is not seen
  given,     ///< FollowerOptions::half_width_px
};

struct FollowerOptions {
  Rule rule = Rule::filtered;
  Hold hold = Hold::row;
  /// Whether offsets are metres; otherwise px, and only the thesis's rule can guide.
  bool is_metric = true;
  /// In metres; for px they are enlarged by the thesis's metric, 60 cm in 15 px at 320 px of width.
  FilterOptions offset;
  FilterOptions heading{.agility = 0.1, .start_rate_sigma = 0.2, .hold_sigma = 0.35};
  HalfWidth half_width = HalfWidth::thesis;
  double half_width_px = kThesisHalfWidthPx;  ///< read by HalfWidth::given only
  GuidanceOptions guidance;
};

/// What happened to the followed row in this picture.
enum class RowEvent {
  none,
  started,  ///< the first row, or a new count after continuity was lost
  changed,  ///< another row is followed (Hold::nearest)
};

/// What is known after a picture; also all that the next step needs.
struct Following {
  Sighting sighting;
  int width = 0;  ///< of the last picture whose size is known, px
  RowNumbers numbers;
  int count = 0;  ///< how often rows had to be counted anew; row numbers compare within one count only
  std::optional<int> row;  ///< number of the followed row, from left to right; the first followed row is 0
  std::optional<int> nearest_row;  ///< number of this picture's row 0
  RowEvent event = RowEvent::none;
  Steering thesis;
  std::optional<double> deviation_cm, steer_cm;  ///< by the thesis's metric
  Estimate measured;                             ///< offset from the followed row in this picture
  Filtered offset_filter, heading_filter;
  std::optional<Estimate> offset, heading_rad;  ///< filtered; nothing on hold
  Guidance guidance;
  bool is_hold = true;      ///< nothing to steer by
  std::string hold_reason;  ///< a sentence when is_hold
};

/// One more picture. Errors are in the sighting's status; nothing throws and nothing is made up.
Following follow_step(const Following& before, const Sighting& now, const FollowerOptions& options);

}  // namespace furrow::follow
