#include "rows/levelled.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "rows/index_rows.h"

namespace furrow::rows {
namespace {

/// How a picture row's step compares with the levelled picture's along one row of plants: dv / dv_level. A
/// row that leans by m = du/dv_level has 1 + slope m.
double step_ratio(const PlanarField& field, double slope, const Eigen::Vector2d& at_level) {
  const double k = field.k_at(at_level.x(), at_level.y());
  return 1.0 + slope * (field.u_at(at_level.y() + 0.5, k) - field.u_at(at_level.y() - 0.5, k));
}

class Tilt {
 public:
  Tilt(const RowLines& lines, double slope)
      : field_(*lines.field), slope_(slope), u_middle_(0.5 * (lines.width - 1)), height_(lines.height) {}

  double v(const Eigen::Vector2d& at_level) const {
    return at_level.y() + slope_ * (at_level.x() - u_middle_);
  }

  /// False for a row that cannot be given from top to bottom of the picture.
  bool tilt(RowLine& row) const {
    constexpr double kLeastRatio = 0.3, kMostRatio = 2.0;
    std::vector<RowSample> kept;
    for (RowSample sample : row.samples) {
      const Eigen::Vector2d at_level = sample.centre_px;
      const double ratio = step_ratio(field_, slope_, at_level);
      if (!(ratio > kLeastRatio && ratio < kMostRatio)) return false;
      sample.centre_px.y() = v(at_level);
      // An edge runs along its row: on the centre's picture row it is nearer by the ratio.
      for (double* u : {&sample.left_u_px, &sample.right_u_px, &sample.top_left_u_px, &sample.top_right_u_px})
        *u = at_level.x() + (*u - at_level.x()) / ratio;
      for (double* sigma : {&sample.sigma_px, &sample.edge_sigma_px, &sample.top_sigma_px}) *sigma /= ratio;
      if (sample.centre_px.y() >= 0.0 && sample.centre_px.y() <= height_ - 1.0) kept.push_back(sample);
    }
    row.samples = std::move(kept);
    if (row.samples.size() < 2) return false;
    if (row.half_width_px) tilt_half_width(row);
    return true;
  }

 private:
  /// From the levelled picture's middle row to the picture's.
  void tilt_half_width(RowLine& row) const {
    const double v_middle = 0.5 * (height_ - 1.0);
    const auto u = u_at(row, v_middle);
    if (!u) {
      row.half_width_px.reset();
      return;
    }
    const Eigen::Vector2d at_level(*u, v_middle - slope_ * (*u - u_middle_));
    const double factor =
        field_.scale(at_level.y()) / field_.scale(v_middle) / step_ratio(field_, slope_, at_level);
    row.half_width_px->value *= factor;
    row.half_width_px->sigma *= factor;
  }

  const PlanarField& field_;
  double slope_, u_middle_, height_;
};

}  // namespace

Image levelled(const Image& picture, double slope) {
  Image result = image::make_image(picture.width, picture.height, picture.channels);
  const cv::Mat in(picture.height, picture.width, CV_8UC(picture.channels),
                   const_cast<std::uint8_t*>(picture.data.data()));
  cv::Mat out(picture.height, picture.width, CV_8UC(picture.channels), result.data.data());
  const cv::Matx23d picture_from_level(1.0, 0.0, 0.0, slope, 1.0, -slope * 0.5 * (picture.width - 1));
  cv::warpAffine(in, out, picture_from_level, out.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  return result;
}

GreenMap levelled(const GreenMap& map, double slope) {
  GreenMap result = map;
  result.light.clear(), result.chroma.clear();
  const double in_map = slope * map.scale_u / map.scale_v, u_middle = 0.5 * (map.width - 1);
  for (int v = 0; v < map.height; ++v) {
    float* out = result.value.data() + static_cast<std::ptrdiff_t>(v) * map.width;
    for (int u = 0; u < map.width; ++u) {
      const double from = std::clamp(v + in_map * (u - u_middle), 0.0, map.height - 1.0);
      const int above = std::min(static_cast<int>(from), std::max(0, map.height - 2));
      const float part = static_cast<float>(from - above);
      const float* line = map.row(above) + u;
      out[u] = map.height > 1 ? line[0] + part * (line[map.width] - line[0]) : line[0];
    }
  }
  return result;
}

void tilt_back(RowLines& lines, double slope) {
  lines.horizon_slope = slope;
  if (!lines.field) return;
  const Tilt tilt(lines, slope);
  std::erase_if(lines.rows, [&](RowLine& row) { return !tilt.tilt(row); });
  if (lines.vanishing_point_px) lines.vanishing_point_px->y() = tilt.v(*lines.vanishing_point_px);
  count_from_followed(lines);
}

}  // namespace furrow::rows
