#include "furrow/follow/thesis.h"

#include <cmath>
#include <numeric>

#include "furrow/base/result.h"

namespace furrow::follow {

std::optional<double> deviation_px(const rows::RowLines& lines) {
  if (!lines.ok() || lines.width <= 0 || lines.height <= 0) return std::nullopt;
  const double u_middle = 0.5 * (lines.width - 1), v_middle = 0.5 * (lines.height - 1);
  for (const rows::RowLine& row : lines.rows) {
    if (row.index != 0) continue;
    if (const auto u = rows::u_at(row, v_middle)) return *u - u_middle;
  }
  return std::nullopt;
}

double deviation_cm(double deviation_px, double half_width_px) {
  check(half_width_px > 0.0, "deviation_cm: the half width must be positive");
  return deviation_px * kThesisHalfWidthCm / half_width_px;
}

std::optional<Estimate> half_width_px(const rows::RowLines& lines) {
  if (!lines.ok()) return std::nullopt;
  for (const rows::RowLine& row : lines.rows) {
    if (row.index == 0) return row.half_width_px;
  }
  return std::nullopt;
}

Steering thesis_step(const Steering& before, const std::optional<double>& deviation_px) {
  constexpr std::size_t kAveraged = 5;  // thesis, section 4: the last five deviations
  Steering now;
  now.last_px = before.last_px;
  const bool is_seen = deviation_px && std::isfinite(*deviation_px);
  if (is_seen) now.last_px.push_back(*deviation_px);
  if (now.last_px.size() > kAveraged) now.last_px.erase(now.last_px.begin());
  if (now.last_px.empty()) return now;
  const double average =
      std::accumulate(now.last_px.begin(), now.last_px.end(), 0.0) / static_cast<double>(now.last_px.size());
  now.average_px = average;
  if (!is_seen) return now;
  now.deviation_px = deviation_px;
  now.steer_px = std::abs(*deviation_px) < std::abs(average) ? *deviation_px : average;
  return now;
}

std::vector<Steering> thesis_steering(const std::vector<std::optional<double>>& deviations_px) {
  std::vector<Steering> result;
  result.reserve(deviations_px.size());
  for (const auto& deviation : deviations_px)
    result.push_back(thesis_step(result.empty() ? Steering{} : result.back(), deviation));
  return result;
}

}  // namespace furrow::follow
