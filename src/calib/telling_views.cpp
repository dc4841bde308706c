// Which pictures of a session show best how well its corners were found.
#include "furrow/calib/telling_views.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <tuple>

#include "calib/model.h"
#include "calib/round.h"
#include "furrow/stats/robust.h"

namespace furrow::calib {
namespace {

constexpr std::size_t kMostShown = 5;

std::ptrdiff_t count_left_out(const View& view) {
  return std::count(view.left_out.begin(), view.left_out.end(), true);
}

/// Adds a view, or another reason to look at it.
void add(std::size_t view, const std::string& why, std::vector<TellingView>& out) {
  const auto same =
      std::find_if(out.begin(), out.end(), [&](const TellingView& one) { return one.view == view; });
  if (same != out.end()) {
    same->why += ", " + why;
  } else {
    TellingView one;
    one.view = view;
    one.why = why;
    out.push_back(std::move(one));
  }
}

void add_used(const std::vector<View>& views, std::vector<TellingView>& out) {
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].used && std::isfinite(views[i].rms_px)) used.push_back(i);
  }
  if (used.empty()) return;
  std::sort(used.begin(), used.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(views[a].rms_px, views[a].image) < std::tie(views[b].rms_px, views[b].image);
  });
  add(used.front(), "lowest RMS", out);
  add(used[used.size() / 2], "median RMS", out);
  add(used.back(), "highest RMS", out);
  // Of equals the one of the higher RMS.
  const auto most = std::max_element(used.rbegin(), used.rend(), [&](std::size_t a, std::size_t b) {
    return count_left_out(views[a]) < count_left_out(views[b]);
  });
  if (count_left_out(views[*most]) > 0) add(*most, "most corners left out", out);
}

/// Dropped for their error: corners and residuals are known.
bool was_dropped(const View& view) {
  return !view.used && !view.residual_px.empty() && view.residual_px.size() == view.observed_px.size();
}

void add_not_used(const Calibration& calibration, const std::vector<target::BoardDetection>& detections,
                  std::vector<TellingView>& out) {
  const std::vector<View>& views = calibration.views;
  std::vector<std::size_t> dropped, without;
  std::set<std::string> seen;
  for (std::size_t i = 0; i < std::min(views.size(), detections.size()); ++i) {
    const target::BoardDetection& one = detections[i];
    const bool is_copy = !one.sha256.empty() && !seen.insert(one.sha256).second;
    const bool same_size = one.width == calibration.camera.width && one.height == calibration.camera.height;
    if (views[i].used || is_copy || !same_size) continue;
    if (was_dropped(views[i])) dropped.push_back(i);
    if (!one.found && one.search_steps > 0) without.push_back(i);
  }
  std::stable_sort(dropped.begin(), dropped.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].rms_px > views[b].rms_px; });
  std::stable_sort(without.begin(), without.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].image < views[b].image; });
  dropped.insert(dropped.end(), without.begin(), without.end());
  for (const std::size_t i : dropped) {
    if (out.size() < kMostShown) add(i, "not used", out);
  }
}

void set_window(const Camera& camera, const View& view, TellingView& out) {
  out.width_px = camera.width;
  out.height_px = camera.height;
  if (view.observed_px.empty()) return;
  Eigen::Array2d low = view.observed_px.front().array(), high = low;
  for (const Eigen::Vector2d& px : view.observed_px) {
    low = low.min(px.array());
    high = high.max(px.array());
  }
  const Eigen::Array2d size(camera.width, camera.height);
  const double share = ((high - low) / size).maxCoeff();
  constexpr double kEnough = 0.5;
  if (!(share < kEnough) || !(share > 0.0)) return;
  const Eigen::Array2d part = (size * (share / kEnough)).ceil();
  const Eigen::Array2d corner = (0.5 * (low + high) - 0.5 * part).floor().max(0.0).min(size - part);
  out.left_px = static_cast<int>(corner.x());
  out.top_px = static_cast<int>(corner.y());
  out.width_px = static_cast<int>(part.x());
  out.height_px = static_cast<int>(part.y());
}

void set_axes(const Calibration& calibration, const View& view, TellingView& out) {
  if (view.residual_px.empty()) return;
  const target::BoardSpec& board = calibration.board;
  const auto solved = [](const Estimate& e) { return e.observations > 0 ? e.value : 0.0; };
  const Eigen::Vector2d warp_m(solved(calibration.board_warp_x_m), solved(calibration.board_warp_y_m));
  constexpr int kCorners = 3;
  const auto along = [&](int step_x, int step_y) {
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < kCorners; ++i) {
      const auto px = camera::project(
          calibration.camera, view.cam_from_board * warped_corner(board, warp_m, i * step_x, i * step_y));
      if (!px) break;
      points.push_back(*px);
    }
    return points;
  };
  out.x_axis_px = along(1, 0);
  out.y_axis_px = along(0, 1);
}

double typical_residual_px(const std::vector<View>& views) {
  std::vector<double> lengths;
  for (const View& view : views) {
    for (std::size_t c = 0; view.used && c < view.residual_px.size(); ++c) {
      if (!is_left_out(view, c) && view.residual_px[c].allFinite())
        lengths.push_back(view.residual_px[c].norm());
    }
  }
  if (lengths.empty()) return kNan;
  std::sort(lengths.begin(), lengths.end());
  return lengths[lengths.size() * 95 / 100];
}

double typical_spacing_px(const Calibration& calibration, const std::vector<TellingView>& shown) {
  std::vector<double> nearest;
  for (const TellingView& one : shown) {
    const auto& corners = calibration.views[one.view].observed_px;
    for (std::size_t a = 0; corners.size() > 1 && a < corners.size(); ++a) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t b = 0; b < corners.size(); ++b) {
        if (a != b) least = std::min(least, (corners[a] - corners[b]).norm());
      }
      nearest.push_back(least);
    }
  }
  return nearest.empty() ? kNan : stats::median(nearest);
}

}  // namespace

TellingViews telling_views(const Calibration& calibration,
                           const std::vector<target::BoardDetection>& detections) {
  TellingViews out;
  add_used(calibration.views, out.views);
  add_not_used(calibration, detections, out.views);
  for (TellingView& one : out.views) {
    set_window(calibration.camera, calibration.views[one.view], one);
    set_axes(calibration, calibration.views[one.view], one);
  }
  out.residual_px = typical_residual_px(calibration.views);
  out.spacing_px = typical_spacing_px(calibration, out.views);
  return out;
}

}  // namespace furrow::calib
