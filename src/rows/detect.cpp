#include "furrow/rows/detect.h"

#include <algorithm>
#include <cmath>

#include "rows/detect_field.h"
#include "rows/index_rows.h"

namespace furrow::rows {

std::vector<double> sample_rows(int height, double step_px) {
  const double last = std::max(height - 1, 0);
  const int intervals = std::max(1, static_cast<int>(std::ceil(last / std::clamp(step_px, 0.5, 10.0))));
  std::vector<double> rows;
  rows.reserve(static_cast<std::size_t>(intervals) + 1);
  for (int i = 0; i <= intervals; ++i) rows.push_back(last * i / intervals);
  return rows;
}

std::optional<double> u_at(const RowLine& row, double v) {
  constexpr double kReachPx = 10.0;  // extension past the first and last sample (row_lines.h)
  const auto& samples = row.samples;
  if (samples.empty() || !std::isfinite(v)) return std::nullopt;
  if (v < samples.front().centre_px.y() - kReachPx || v > samples.back().centre_px.y() + kReachPx)
    return std::nullopt;
  if (samples.size() == 1) return samples.front().centre_px.x();
  auto upper = std::lower_bound(samples.begin(), samples.end(), v,
                                [](const RowSample& sample, double at) { return sample.centre_px.y() < at; });
  if (upper == samples.begin()) ++upper;
  if (upper == samples.end()) --upper;
  const Eigen::Vector2d a = (upper - 1)->centre_px, b = upper->centre_px;
  return a.x() + (b.x() - a.x()) * (v - a.y()) / (b.y() - a.y());
}

namespace {
double u_nearest(const RowLine& row, double v) {
  const auto nearest =
      std::min_element(row.samples.begin(), row.samples.end(), [&](const RowSample& a, const RowSample& b) {
        return std::abs(a.centre_px.y() - v) < std::abs(b.centre_px.y() - v);
      });
  return nearest->centre_px.x();
}
/// Where a row crosses the picture's middle row, or ends nearest to it.
double middle_place(const RowLines& lines, const RowLine& row) {
  const double v_middle = 0.5 * (lines.height - 1);
  return u_at(row, v_middle).value_or(u_nearest(row, v_middle));
}

/// The row nearest the picture's middle column at its middle row.
std::vector<RowLine>::iterator followed_row(RowLines& lines) {
  const auto off = [&](const RowLine& row) {
    return std::abs(middle_place(lines, row) - 0.5 * (lines.width - 1));
  };
  return std::min_element(lines.rows.begin(), lines.rows.end(),
                          [&](const RowLine& a, const RowLine& b) { return off(a) < off(b); });
}
}  // namespace

RowLines begun(const Image& picture, const char* method) {
  RowLines lines;
  lines.method = method;
  lines.width = picture.width;
  lines.height = picture.height;
  if (picture.empty()) {
    lines.status = "picture_empty";
    lines.reason = "the picture has no pixels";
  }
  return lines;
}

void index_rows(RowLines& lines) {
  if (lines.rows.empty()) return;
  std::stable_sort(lines.rows.begin(), lines.rows.end(), [&](const RowLine& a, const RowLine& b) {
    return middle_place(lines, a) < middle_place(lines, b);
  });
  const int zero = static_cast<int>(followed_row(lines) - lines.rows.begin());
  for (int i = 0; i < static_cast<int>(lines.rows.size()); ++i)
    lines.rows[static_cast<std::size_t>(i)].index = i - zero;
}

void count_from_followed(RowLines& lines) {
  if (lines.rows.empty()) return;
  const int zero = followed_row(lines)->index;
  for (RowLine& row : lines.rows) row.index -= zero;
}

RowLines detect(const Image& picture, const DetectOptions& options) {
  return options.method == Method::thesis ? detect_thesis(picture, options.thesis)
                                          : detect_field(picture, options);
}

}  // namespace furrow::rows
