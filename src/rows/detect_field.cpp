#include "rows/detect_field.h"

#include <algorithm>
#include <cmath>

#include "rows/field_search.h"
#include "rows/green_map.h"
#include "rows/index_rows.h"

namespace furrow::rows {
namespace {

constexpr double kSearchPixels = 320.0 * 240.0;

PlanarField in_picture(const PlanarField& map_field, const GreenMap& map) {
  PlanarField field = map_field;
  field.u0 = map.u_in_picture(map_field.u0);
  field.v0 = map.v_in_picture(map_field.v0);
  field.length = map_field.length * map.scale_v;
  for (double* px : {&field.spacing, &field.offset, &field.slope, &field.bend, &field.bend2})
    *px *= map.scale_u;
  return field;
}

/// Centre and spacing of the followed field on a row of the picture; beyond its strips the planar field's,
/// moved to meet it.
struct Cut {
  double centre = 0.0, spacing = 0.0;  // px of the picture; centre of row 0
};
Cut cut_at(const FollowedField& followed, const PlanarField& field, const GreenMap& map, double v) {
  const double v_map = (v + 0.5) / map.scale_v - 0.5;
  if (followed.v.empty()) return {field.u_at(v, 0.0), field.spacing_at(v)};
  std::size_t upper = 0;
  while (upper < followed.v.size() && followed.v[upper] < v_map) ++upper;
  double centre = 0.0, spacing = 0.0;
  const auto relative = [&](std::size_t i, double& shift, double& stretch) {
    const double at = map.v_in_picture(followed.v[i]);
    stretch = followed.spacing[i] * map.scale_u / field.spacing_at(at);
    shift = (map.u_in_picture(followed.centre[i]) - field.u_at(at, followed.centre_k)) / field.spacing_at(at);
  };
  double shift = 0.0, stretch = 1.0;
  if (upper == 0 || upper == followed.v.size()) {
    relative(upper == 0 ? 0 : upper - 1, shift, stretch);
  } else {
    double shift_b = 0.0, stretch_b = 1.0;
    relative(upper - 1, shift, stretch);
    relative(upper, shift_b, stretch_b);
    const double part = (v_map - followed.v[upper - 1]) / (followed.v[upper] - followed.v[upper - 1]);
    shift += part * (shift_b - shift);
    stretch += part * (stretch_b - stretch);
  }
  spacing = field.spacing_at(v) * stretch;
  centre = field.u_at(v, followed.centre_k) + shift * field.spacing_at(v) - followed.centre_k * spacing;
  return {centre, spacing};
}

RowLine row_of(const PlanarField& field, const FollowedField& followed, const GreenMap& map, int k,
               const RowLines& lines, const std::vector<double>& sample_v) {
  RowLine row;
  row.index = k;
  for (const double v : sample_v) {
    if (field.scale(v) <= 0.02) continue;
    const Cut cut = cut_at(followed, field, map, v);
    const double spacing = cut.spacing, u = cut.centre + k * spacing;
    if (u < -spacing || u > lines.width - 1.0 + spacing) continue;
    RowSample sample;
    sample.centre_px = {u, v};
    sample.sigma_px = 0.05 * spacing;
    sample.seen = u >= 0.0 && u <= lines.width - 1.0;
    row.samples.push_back(sample);
  }
  return row;
}

}  // namespace

RowLines detect_field(const Image& picture, const DetectOptions& options) {
  RowLines lines;
  lines.method = "field";
  lines.width = picture.width;
  lines.height = picture.height;
  if (picture.empty()) {
    lines.status = "picture_empty";
    lines.reason = "the picture has no pixels";
    return lines;
  }
  const GreenMap map = green_map(picture, kSearchPixels);
  SearchPriors priors;
  if (options.priors.horizon_v_px) {
    priors.horizon_v = (*options.priors.horizon_v_px + 0.5) / map.scale_v - 0.5;
    priors.horizon_sigma = std::max(options.priors.horizon_sigma_px / map.scale_v, 1.0);
  }
  const auto found = search_field(map, priors);
  if (!found) {
    lines.status = "no_rows";
    lines.reason = "the picture shows no pattern of rows";
    return lines;
  }
  const PlanarField field = in_picture(found->field, map);
  lines.field = field;
  const FollowedField& followed = found->followed;
  lines.vanishing_point_px = field.vanishing_point();
  const auto sample_v = sample_rows(picture.height, std::min(options.sample_step_px, picture.height / 60.0));
  // Rows that cross the picture below the horizon.
  int first = 0, last = -1;
  for (const double v : sample_v) {
    if (field.scale(v) < 0.1) continue;
    const int left = static_cast<int>(std::ceil(field.k_at(0.0, v))),
              right = static_cast<int>(std::floor(field.k_at(picture.width - 1.0, v)));
    if (last < first) {
      first = left, last = right;
    } else {
      first = std::min(first, left), last = std::max(last, right);
    }
  }
  for (int k = first; k <= last; ++k) {
    RowLine row = row_of(field, followed, map, k, lines, sample_v);
    if (row.samples.size() >= 2) lines.rows.push_back(std::move(row));
  }
  index_rows(lines);
  lines.status = lines.rows.empty() ? "no_rows" : "ok";
  lines.confidence = std::clamp(found->score, 0.0, 1.0);
  return lines;
}

}  // namespace furrow::rows
