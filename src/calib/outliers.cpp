#include <algorithm>

#include "calib/round.h"
#include "furrow/base/text.h"
#include "furrow/stats/robust.h"

namespace furrow::calib {
bool is_left_out(const View& view, std::size_t corner) {
  return !view.left_out.empty() && view.left_out[corner];
}

bool drop_outlying_views(const Round& round, double ratio, std::vector<View>& views) {
  if (!(ratio > 0.0) || round.order.size() <= kFewestViews) return false;
  std::vector<double> rms_px;
  for (const std::size_t i : round.order) rms_px.push_back(views[i].rms_px);
  const double limit_px = ratio * stats::median(rms_px);
  std::vector<std::size_t> worst_first = round.order;
  std::stable_sort(worst_first.begin(), worst_first.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].rms_px > views[b].rms_px; });
  std::size_t left = round.order.size();
  bool any = false;
  for (const std::size_t i : worst_first) {
    if (!(views[i].rms_px > limit_px) || left == kFewestViews) break;
    views[i].used = false;
    views[i].reason = "RMS " + base::format_fixed(views[i].rms_px, 2) + " px is over " +
                      base::format_fixed(ratio, 1) + " times the median view's (" +
                      base::format_fixed(limit_px / ratio, 2) + " px)";
    --left;
    any = true;
  }
  return any;
}

bool leave_out_corners(const Round& round, double sigmas, std::vector<View>& views) {
  if (!(sigmas > 0.0)) return false;
  std::vector<double> distances_px;
  for (const std::size_t i : round.order) {
    for (std::size_t c = 0; c < views[i].residual_px.size(); ++c) {
      if (!is_left_out(views[i], c)) distances_px.push_back(views[i].residual_px[c].norm());
    }
  }
  constexpr double kRayleighMedian = 1.1774;
  const double limit_px = sigmas * stats::median(distances_px) / kRayleighMedian;
  bool any = false;
  for (const std::size_t i : round.order) {
    View& view = views[i];
    std::vector<bool> far(view.residual_px.size());
    for (std::size_t c = 0; c < far.size(); ++c)
      far[c] = is_left_out(view, c) || !(view.residual_px[c].norm() <= limit_px);
    if (2 * std::count(far.begin(), far.end(), true) > static_cast<std::ptrdiff_t>(far.size())) continue;
    any = any || std::count(far.begin(), far.end(), true) >
                     std::count(view.left_out.begin(), view.left_out.end(), true);
    view.left_out = far;
  }
  return any;
}

}  // namespace furrow::calib
