#include "calib/set_faults.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>

#include "calib/model.h"
#include "furrow/base/text.h"
#include "furrow/calib/uncertainty.h"

namespace furrow::calib {
namespace {

using base::format_fixed;
constexpr double kPercent = 100.0;

/// By what share a view alone would have the focal length longer, and that share's sigma.
struct OwnFocal {
  std::size_t view;
  double share, sigma;
};

/// One step of Gauss-Newton in (focal length, pose), the rest of the lens held.
OwnFocal own_focal(const Calibration& calibration, std::size_t i) {
  const View& view = calibration.views[i];
  const Eigen::Vector2d warp_m(calibration.board_warp_x_m.value, calibration.board_warp_y_m.value);
  const bool warped = calibration.board_warp_x_m.observations > 0;
  const SharedModel model =
      make_shared_model(calibration.camera, calibration.board, warped ? warp_m : Eigen::Vector2d::Zero(), {});
  const SeenCorners seen{view.corner_ids, view.observed_px};
  std::vector<double> weight(seen.px.size(), 1.0);
  for (std::size_t c = 0; c < view.left_out.size(); ++c) weight[c] = view.left_out[c] ? 0.0 : 1.0;
  const auto rows = static_cast<Eigen::Index>(2 * seen.px.size());
  Eigen::VectorXd residual(rows);
  RowMajor by_lens(rows, model.count), by_pose(rows, 6);
  OwnFocal out{i, 0.0, std::numeric_limits<double>::infinity()};
  if (!evaluate_view(model, shared_of(model), pose_vector(view.cam_from_board), seen, weight, residual.data(),
                     by_lens.data(), by_pose.data()))
    return out;
  // A share of both focal lengths: their columns come first.
  Eigen::VectorXd by = by_lens.col(0) * calibration.camera.fx + by_lens.col(1) * calibration.camera.fy;
  by -= by_pose * by_pose.colPivHouseholderQr().solve(by).eval();
  const double information = by.squaredNorm();
  if (!(information > 0.0)) return out;
  out.share = -by.dot(residual) / information;
  out.sigma = calibration.sigma0_px / std::sqrt(information);
  return out;
}

std::vector<OwnFocal> in_name_order(const Calibration& calibration) {
  std::vector<OwnFocal> out;
  for (std::size_t i = 0; i < calibration.views.size(); ++i) {
    if (calibration.views[i].used) out.push_back(own_focal(calibration, i));
  }
  std::stable_sort(out.begin(), out.end(), [&](const OwnFocal& a, const OwnFocal& b) {
    return base::natural_less(calibration.views[a.view].image, calibration.views[b.view].image);
  });
  return out;
}

/// Where two runs differ most in units of their noise: the first place of the second run.
struct Break {
  std::size_t at = 0;
  double sigmas = 0.0;
};

Break largest_break(const std::vector<OwnFocal>& all) {
  constexpr std::size_t kFewest = 3;
  Break out;
  for (std::size_t at = kFewest; at + kFewest <= all.size(); ++at) {
    double sum[2] = {0.0, 0.0}, information[2] = {0.0, 0.0};
    for (std::size_t i = 0; i < all.size(); ++i) {
      const double weight = 1.0 / (all[i].sigma * all[i].sigma);
      sum[i < at ? 0 : 1] += weight * all[i].share;
      information[i < at ? 0 : 1] += weight;
    }
    const double apart = std::abs(sum[0] / information[0] - sum[1] / information[1]) /
                         std::sqrt(1.0 / information[0] + 1.0 / information[1]);
    if (apart > out.sigmas) out = {at, apart};
  }
  return out;
}

double focal_px(const Calibration& calibration) {
  return camera::focal_on_axis_px(calibration.camera).mean();
}

double focal_sigma_px(const Calibration& calibration) {
  return height_error_percent(calibration.camera).value_or(0.0) / kPercent * focal_px(calibration);
}

double squared_sum(const Calibration& calibration) {
  return calibration.rms_px * calibration.rms_px * calibration.corners;
}

}  // namespace

Criterion zoom_criterion(const Calibration& calibration,
                         const std::vector<target::BoardDetection>& detections,
                         const CalibrateOptions& options, double sigma_factor) {
  constexpr double kLimit_percent = 1.0, kSigmas = 5.0, kWorthATry = 4.0;
  Criterion out{"zoom", 0.0, kLimit_percent, true, "no change of the focal length from one picture on"};
  const std::vector<OwnFocal> all = in_name_order(calibration);
  const Break found = largest_break(all);
  if (!(found.sigmas > kWorthATry)) return out;
  std::vector<target::BoardDetection> part[2];
  for (std::size_t i = 0; i < all.size(); ++i) part[i < found.at ? 0 : 1].push_back(detections[all[i].view]);
  target::BoardSpec board = calibration.board;
  if (options.solve_aspect) board.aspect = 1.0;
  const auto before = calibrate(part[0], board, options), after = calibrate(part[1], board, options);
  if (!before.ok() || !after.ok()) return out;
  const double f = focal_px(*before), g = focal_px(*after);
  const double sigma =
      std::max(1.0, sigma_factor) * std::hypot(focal_sigma_px(*before), focal_sigma_px(*after));
  const double rms_px =
      std::sqrt((squared_sum(*before) + squared_sum(*after)) / std::max(1, before->corners + after->corners));
  out.value = kPercent * std::abs(g - f) / std::min(f, g);
  out.limit = std::max(kLimit_percent, kPercent * kSigmas * sigma / std::min(f, g));
  const bool changed = rms_px < calibration.rms_px && out.value > out.limit;
  if (!changed) return out;
  out.met = false;
  out.sentence = "the zoom changes in mid-set: up to " + calibration.views[all[found.at - 1].view].image +
                 " the focal length is " + format_fixed(f, 0) + " px, from " +
                 calibration.views[all[found.at].view].image + " on " + format_fixed(g, 0) +
                 " px (RMS apart " + format_fixed(rms_px, 3) + " px, together " +
                 format_fixed(calibration.rms_px, 3) + " px); calibrate each by itself";
  return out;
}

Criterion bend_criterion(const Calibration& calibration,
                         const std::vector<target::BoardDetection>& detections,
                         const CalibrateOptions& options, double limit_percent) {
  Criterion out{"bend", 0.0, limit_percent, true, "the bend of the board is solved"};
  if (options.solve_warp) return out;
  CalibrateOptions bent_options = options;
  bent_options.solve_warp = true;
  const auto bent = calibrate(detections, calibration.board, bent_options);
  out.sentence = "whether the board is flat cannot be told from these pictures";
  if (!bent.ok() || bent->camera.covariance.size() == 0) return out;
  constexpr double kSigmas = 3.0, kMm = 1e3;
  const double sigma_percent = kPercent * focal_sigma_px(*bent) / focal_px(*bent);
  out.value = kPercent * std::abs(focal_px(*bent) / focal_px(calibration) - 1.0);
  out.limit = std::max(limit_percent, kSigmas * sigma_percent);
  out.met = out.value <= out.limit;
  const auto mm = [](const Estimate& e) { return format_fixed(kMm * e.value, 2) + " mm"; };
  out.sentence = "a board bent by " + mm(bent->board_warp_x_m) + " and " + mm(bent->board_warp_y_m) +
                 " along its sides " + (out.met ? "would move" : "moves") + " the focal length by " +
                 format_fixed(out.value, 2) + " %";
  if (!out.met)
    out.sentence += " and fits with RMS " + format_fixed(bent->rms_px, 3) + " px instead of " +
                    format_fixed(calibration.rms_px, 3) + " px: solve the bend (--warp), or use a flat board";
  return out;
}

}  // namespace furrow::calib
