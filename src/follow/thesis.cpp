#include "furrow/follow/thesis.h"

#include <cmath>
#include <deque>
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

std::vector<Steering> thesis_steering(const std::vector<std::optional<double>>& deviations_px) {
  constexpr std::size_t kAveraged = 5;  // thesis, section 4: the last five deviations
  std::deque<double> last;
  std::vector<Steering> result;
  result.reserve(deviations_px.size());
  for (const auto& deviation : deviations_px) {
    Steering steering;
    if (deviation && std::isfinite(*deviation)) {
      steering.deviation_px = deviation;
      last.push_back(*deviation);
      if (last.size() > kAveraged) last.pop_front();
      const double average =
          std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(last.size());
      steering.average_px = average;
      steering.steer_px = std::abs(*deviation) < std::abs(average) ? *deviation : average;
    } else if (!last.empty()) {
      steering.average_px = std::accumulate(last.begin(), last.end(), 0.0) / static_cast<double>(last.size());
    }
    result.push_back(steering);
  }
  return result;
}

}  // namespace furrow::follow
