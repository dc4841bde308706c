#include "furrow/calib/calibrate.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "calib/round.h"

namespace furrow::calib {
namespace {

bool all_finite(const std::vector<Eigen::Vector2d>& points) {
  return std::all_of(points.begin(), points.end(), [](const Eigen::Vector2d& p) { return p.allFinite(); });
}

/// Rising, and each one of the board's corners.
bool are_ids(const std::vector<int>& ids, std::size_t corners) {
  return ids.empty() || (ids.front() >= 0 && static_cast<std::size_t>(ids.back()) < corners &&
                         std::adjacent_find(ids.begin(), ids.end(), std::greater_equal<>()) == ids.end());
}

View start_view(const target::BoardDetection& detection, const target::BoardSpec& board) {
  View view;
  view.image = detection.image;
  view.search_steps = detection.search_steps;
  view.search_cut = detection.search_cut;
  view.rms_px = view.mean_error_px = kNan;
  const auto all = static_cast<std::size_t>(board.corners_x) * static_cast<std::size_t>(board.corners_y);
  const auto wanted = detection.corner_ids.empty() ? all : detection.corner_ids.size();
  if (!detection.found) {
    view.reason = detection.reason.empty() ? "no board found" : detection.reason;
  } else if (detection.corners_px.size() != wanted) {
    view.reason = std::to_string(detection.corners_px.size()) + " corners, not " + std::to_string(wanted);
  } else if (!all_finite(detection.corners_px)) {
    view.reason = "corners that are not finite";
  } else if (!are_ids(detection.corner_ids, all)) {
    view.reason = "corners that are not the board's";
  } else {
    view.used = true;
    view.observed_px = detection.corners_px;
    view.corner_ids = detection.corner_ids;
  }
  return view;
}

Error too_few(const std::vector<View>& views, std::size_t usable) {
  std::string reasons;
  constexpr std::size_t kShown = 3;
  std::size_t shown = 0;
  for (const View& view : views) {
    if (view.used || shown == kShown) continue;
    reasons += (shown++ == 0 ? ": " : "; ") + view.image + ": " + view.reason;
  }
  return {
      "too_few_boards", "calibration",
      std::to_string(usable) + " usable boards in " + std::to_string(views.size()) + " pictures" + reasons,
      "at least " + std::to_string(kFewestViews),
      "check the board's corner counts (inner corners, not squares), and take pictures in which the whole "
      "board shows"};
}

/// Places of the used views in an order that does not depend on the order of the files.
std::vector<std::size_t> in_name_order(const std::vector<View>& views) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].used) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return views[a].image < views[b].image; });
  return order;
}

Status check_sizes(const std::vector<target::BoardDetection>& detections, const std::vector<View>& views,
                   Job& job) {
  const target::BoardDetection* first = nullptr;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (!views[i].used) continue;
    const target::BoardDetection& one = detections[i];
    if (first == nullptr) first = &one;
    if (one.width != first->width || one.height != first->height) {
      return Error{"picture_sizes_differ", one.image,
                   std::to_string(one.width) + "x" + std::to_string(one.height) + ", while " + first->image +
                       " has " + std::to_string(first->width) + "x" + std::to_string(first->height),
                   "pictures of one size", "calibrate each size by itself"};
    }
  }
  if (first == nullptr) return Done{};
  job.width = first->width;
  job.height = first->height;
  return Done{};
}

}  // namespace

Result<Calibration> calibrate(const std::vector<target::BoardDetection>& detections,
                              const target::BoardSpec& board, const CalibrateOptions& options) {
  FURROW_DO(target::validate(board));
  if (options.solve_aspect && options.model == camera::CameraModel::splined_stereographic) {
    return Error{"bad_option", "calibration", "a splined lens with the board's aspect free", "one of the two",
                 "splines take up any stretch; measure the board"};
  }
  std::vector<View> views;
  for (const target::BoardDetection& detection : detections) views.push_back(start_view(detection, board));
  Job job{detections, board, options};
  FURROW_DO(check_sizes(detections, views, job));
  int rounds = 0;
  while (true) {
    const std::vector<std::size_t> order = in_name_order(views);
    if (order.size() < kFewestViews) return too_few(views, order.size());
    FURROW_TRY(const Round round, solve_round(job, order, views));
    for (std::size_t i = 0; i < order.size(); ++i) fill_view(round, i, views[order[i]]);
    // Corners only ever leave, so this ends; a few rounds find all that a better fit uncovers.
    constexpr int kMostRounds = 10;
    const bool again =
        rounds++ < kMostRounds && leave_out_corners(round, options.corner_outlier_sigmas, views);
    if (!again && !drop_outlying_views(round, options.view_outlier_ratio, views))
      return summarize(job, round, std::move(views));
  }
}

}  // namespace furrow::calib
