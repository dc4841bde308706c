#include "furrow/follow/follower.h"

#include <algorithm>
#include <cmath>

#include "furrow/base/text.h"

namespace furrow::follow {
namespace {

double thesis_half_width_px(int width) {
  return kThesisHalfWidthPx * width / kThesisWidthPx;
}

/// The filter's options in the offset's unit.
FilterOptions offset_filter_options(const FollowerOptions& options, int width) {
  FilterOptions scaled = options.offset;
  if (options.is_metric || width <= 0) return scaled;
  const double px_per_m = 100.0 * thesis_half_width_px(width) / kThesisHalfWidthCm;
  for (double* value : {&scaled.agility, &scaled.start_rate_sigma, &scaled.hold_sigma}) *value *= px_per_m;
  return scaled;
}

std::optional<double> half_width_for_cm(const Following& now, const FollowerOptions& options) {
  switch (options.half_width) {
    case HalfWidth::given:
      return options.half_width_px;
    case HalfWidth::measured:
      if (!now.sighting.half_width_px) return std::nullopt;
      return now.sighting.half_width_px->value;
    default:
      return thesis_half_width_px(now.width);
  }
}

/// Number of row 0 told by where the filter expects the followed row: when rows were not seen for too long
/// for their places in the picture to tell. Nothing when the filter is not sure within a sixth of a spacing,
/// or row 0 lies between two.
std::optional<int> number_by_prediction(const Following& now, const FilterOptions& options) {
  constexpr double kSure = 1.0 / 6.0, kDoubtful = 0.35;
  const Sighting& s = now.sighting;
  if (!now.row || !now.offset_filter.has_started || !s.offset.usable() || !(s.spacing > 0.0))
    return std::nullopt;
  const Filtered expected = filter_step(now.offset_filter, s.t_video_ns, {}, options);
  if (!(std::sqrt(expected.covariance(0, 0)) < kSure * s.spacing)) return std::nullopt;
  const double places = (expected.state[0] - s.offset.value) / s.spacing, nearest = std::round(places);
  if (std::abs(places - nearest) > kDoubtful) return std::nullopt;
  return *now.row - static_cast<int>(nearest);
}

/// Numbers are counted anew from this picture's row 0.
void start_count(Following& now) {
  now.numbers = next_number({}, now.sighting.place);
  now.count += now.row ? 1 : 0;
  now.row = now.nearest_row = now.numbers.number;
  now.offset_filter = {};
  now.event = RowEvent::started;
}

void change_row(Following& now, int to) {
  now.offset_filter = shifted(now.offset_filter, (to - *now.row) * now.sighting.spacing);
  now.row = to;
  now.event = RowEvent::changed;
}

/// Which row this is, and which is followed from here on.
void number_rows(Following& now, const FollowerOptions& options) {
  now.event = RowEvent::none;
  now.numbers = next_number(now.numbers, now.sighting.place);
  now.nearest_row = now.numbers.number;
  if (!now.sighting.place.is_seen()) return;
  const FilterOptions filter = offset_filter_options(options, now.width);
  if (!now.nearest_row) {
    now.nearest_row = number_by_prediction(now, filter);
    if (now.nearest_row) now.numbers = {now.sighting.place, now.nearest_row, 0, false, now.nearest_row};
  }
  // One strange picture does not end a row that the filter still knows the place of.
  const Filtered expected = filter_step(now.offset_filter, now.sighting.t_video_ns, {}, filter);
  if (!now.nearest_row && filtered_value(expected, filter)) return;
  if (!now.nearest_row || !now.row) return start_count(now);
  if (options.hold == Hold::nearest && *now.nearest_row != *now.row && now.sighting.spacing > 0.0)
    change_row(now, *now.nearest_row);
}

/// Row `row` lies (row - nearest_row) spacings to the right of row 0, and the camera so much farther to its
/// left.
Estimate offset_of_followed(const Following& now) {
  const Sighting& s = now.sighting;
  if (!now.row || !now.nearest_row || !s.offset.usable()) return {};
  const int places = *now.row - *now.nearest_row;
  if (places == 0) return s.offset;
  const double variance = s.offset.sigma * s.offset.sigma + 2.0 * places * s.offset_spacing_covariance +
                          places * places * s.spacing_sigma * s.spacing_sigma;
  return {s.offset.value + places * s.spacing, std::sqrt(std::max(0.0, variance)), s.offset.observations};
}

void apply_thesis(Following& now, const FollowerOptions& options) {
  now.thesis = thesis_step(now.thesis, now.sighting.deviation_px);
  now.deviation_cm.reset(), now.steer_cm.reset();
  const std::optional<double> half_width = half_width_for_cm(now, options);
  if (!half_width || !(*half_width > 0.0)) return;
  if (now.thesis.deviation_px) now.deviation_cm = deviation_cm(*now.thesis.deviation_px, *half_width);
  if (now.thesis.steer_px) now.steer_cm = deviation_cm(*now.thesis.steer_px, *half_width);
}

void apply_filters(Following& now, const FollowerOptions& options) {
  const base::Nanoseconds t = now.sighting.t_video_ns;
  now.measured = offset_of_followed(now);
  const FilterOptions filter = offset_filter_options(options, now.width);
  now.offset_filter = filter_step(now.offset_filter, t, now.measured, filter);
  now.heading_filter = filter_step(now.heading_filter, t, now.sighting.heading_rad, options.heading);
  now.offset = filtered_value(now.offset_filter, filter);
  now.heading_rad = filtered_value(now.heading_filter, options.heading);
}

/// What guidance gets: by the thesis's rule centimetres and no heading, else the filters'.
std::optional<SteeringError> steering_error(const Following& now, const FollowerOptions& options) {
  constexpr double kMetresPerCm = 0.01;
  if (options.rule == Rule::thesis) {
    if (!now.steer_cm) return std::nullopt;
    return SteeringError{kMetresPerCm * *now.steer_cm, 0.0, 0.0};
  }
  if (!options.is_metric || !now.offset) return std::nullopt;
  return SteeringError{now.offset->value, filtered_rate(now.offset_filter).value,
                       now.heading_rad ? now.heading_rad->value : 0.0};
}

std::string reason_to_hold(const Following& now, const FollowerOptions& options) {
  const Sighting& s = now.sighting;
  if (s.status != "ok") return s.reason.empty() ? s.status : s.reason;
  if (options.rule == Rule::thesis) return "no row crosses the picture's middle";
  if (now.offset_filter.intake == Intake::left_out)
    return "the row is not where it can be after the picture before";
  return "not sure enough of the row's place";
}

/// One-sigma of row 0's place on the picture's middle row, px; NaN when it does not cross it.
double deviation_sigma_px(const rows::RowLines& lines) {
  const double v_middle = 0.5 * (lines.height - 1);
  double nearest = std::numeric_limits<double>::infinity(), sigma = std::numeric_limits<double>::quiet_NaN();
  for (const rows::RowLine& row : lines.rows) {
    if (row.index != 0) continue;
    for (const rows::RowSample& sample : row.samples) {
      const double away = std::abs(sample.centre_px.y() - v_middle);
      if (away < nearest) nearest = away, sigma = sample.sigma_px;
    }
  }
  return sigma;
}

}  // namespace

Sighting sighting_of(const rows::RowLines& lines, base::Nanoseconds t_video_ns) {
  constexpr double kThesisSigmaPx =
      3.0;  // Hough lines come without one; a cell of its grid at 320 px, enlarged
  Sighting sighting;
  sighting.t_video_ns = t_video_ns;
  sighting.status = lines.status;
  sighting.reason = lines.reason;
  sighting.place = place_of(lines);
  sighting.deviation_px = deviation_px(lines);
  sighting.half_width_px = half_width_px(lines);
  sighting.spacing = sighting.place.spacing_px;
  if (!sighting.deviation_px) return sighting;
  const double sigma = deviation_sigma_px(lines);
  sighting.offset = {*sighting.deviation_px, std::isfinite(sigma) ? sigma : kThesisSigmaPx, 1};
  return sighting;
}

Following follow_step(const Following& before, const Sighting& now, const FollowerOptions& options) {
  Following next = before;
  next.sighting = now;
  if (now.place.width > 0) next.width = now.place.width;
  number_rows(next, options);
  apply_thesis(next, options);
  apply_filters(next, options);
  const double dt_s = base::ns_to_seconds(now.t_video_ns - before.sighting.t_video_ns);
  next.guidance = guidance_step(before.guidance, steering_error(next, options), dt_s, options.guidance);
  next.is_hold = options.rule == Rule::thesis ? !next.thesis.steer_px : !next.offset;
  next.hold_reason = next.is_hold ? reason_to_hold(next, options) : "";
  return next;
}

}  // namespace furrow::follow
