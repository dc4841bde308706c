#include "furrow/calib/choose_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "calib/pose.h"
#include "furrow/base/text.h"

namespace furrow::calib {
namespace {

using camera::CameraModel;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kParts = 3;

/// The view of one detection with its pose fitted, nothing of `model` being free.
View located(const SharedModel& model, const target::BoardDetection& detection) {
  View view;
  view.image = detection.image;
  view.rms_px = view.mean_error_px = kNan;
  view.reason = detection.reason.empty() ? "no board found" : detection.reason;
  if (!detection.found) return view;
  const SeenCorners seen{detection.corner_ids, detection.corners_px};
  const auto start = pose_from_corners(model.camera, model.board, seen);
  const auto pose = start ? refine_pose(model, pose_vector(*start), seen) : std::nullopt;
  view.reason = "its corners allow no pose with this camera";
  if (!pose) return view;
  Eigen::VectorXd residual(static_cast<Eigen::Index>(2 * seen.px.size()));
  if (!evaluate_view(model, shared_of(model), *pose, seen, {}, residual.data(), nullptr, nullptr))
    return view;
  view.used = true;
  view.reason = "";
  view.cam_from_board = pose_of(*pose);
  view.observed_px = seen.px;
  view.corner_ids = seen.ids;
  double distance = 0.0;
  for (std::size_t c = 0; c < seen.px.size(); ++c) {
    view.residual_px.push_back(-residual.segment<2>(static_cast<Eigen::Index>(2 * c)));
    distance += view.residual_px.back().norm();
  }
  const auto corners = static_cast<double>(seen.px.size());
  view.rms_px = residual.norm() / std::sqrt(corners);
  view.mean_error_px = distance / corners;
  return view;
}

SharedModel held(const Camera& camera, const target::BoardSpec& board, const Eigen::Vector2d& warp_m) {
  FreeTerms nothing;
  nothing.core = false;
  return make_shared_model(camera, board, warp_m, nothing);
}

/// Places of the found boards in name order.
std::vector<std::size_t> found_in_name_order(const std::vector<target::BoardDetection>& detections) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    if (detections[i].found) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return detections[a].image < detections[b].image; });
  return order;
}

/// Squared distances and corners of the part left out, foretold by a camera solved from the rest.
struct HeldOut {
  double squared = 0.0;
  std::size_t corners = 0;
};

Result<HeldOut> foretell(const std::vector<target::BoardDetection>& detections,
                         const std::vector<std::size_t>& order, std::size_t part,
                         const target::BoardSpec& board, const CalibrateOptions& options, int& parameters) {
  std::vector<target::BoardDetection> rest;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kParts != part) rest.push_back(detections[order[i]]);
  }
  FURROW_TRY(const Calibration solved, calibrate(rest, board, options));
  parameters = static_cast<int>(camera::intrinsics(solved.camera).size());
  const bool warped = solved.board_warp_x_m.observations > 0;
  const SharedModel model =
      held(solved.camera, solved.board,
           warped ? Eigen::Vector2d(solved.board_warp_x_m.value, solved.board_warp_y_m.value)
                  : Eigen::Vector2d::Zero());
  HeldOut out;
  for (std::size_t i = part; i < order.size(); i += kParts) {
    const View view = located(model, detections[order[i]]);
    if (!view.used) return Error{"model_does_not_reach", view.image, view.reason, "", ""};
    out.squared += view.rms_px * view.rms_px * static_cast<double>(view.observed_px.size());
    out.corners += view.observed_px.size();
  }
  return out;
}

ModelTrial try_model(const std::vector<target::BoardDetection>& detections,
                     const std::vector<std::size_t>& order, const target::BoardSpec& board,
                     CalibrateOptions options, CameraModel model) {
  options.model = model;
  ModelTrial out;
  out.model = model;
  HeldOut sum;
  for (std::size_t part = 0; part < kParts; ++part) {
    const auto one = foretell(detections, order, part, board, options, out.parameters);
    if (!one.ok()) {
      out.held_out_rms_px = kNan;
      out.reason = one.error().message();
      return out;
    }
    sum.squared += one->squared;
    sum.corners += one->corners;
  }
  out.held_out_rms_px = std::sqrt(sum.squared / static_cast<double>(sum.corners));
  return out;
}

std::string in_words(const ModelChoice& choice, const ModelTrial& chosen, const ModelTrial& best) {
  const auto px = [](const ModelTrial& trial) {
    return base::format_fixed(trial.held_out_rms_px, 4) + " px";
  };
  std::string out = "Lens model " + camera::model_name(choice.model) +
                    ": pictures left out of the solve are foretold to " + px(chosen) + " RMS";
  if (chosen.model != best.model) {
    out += ", and the best of all, " + camera::model_name(best.model) + " with " +
           std::to_string(best.parameters) + " parameters instead of " + std::to_string(chosen.parameters) +
           ", gains less than 1 % (" + px(best) + ")";
  }
  std::string others;
  for (const ModelTrial& trial : choice.trials) {
    if (trial.model == chosen.model || trial.model == best.model) continue;
    others += (others.empty() ? "" : ", ") + camera::model_name(trial.model) + " " +
              (std::isfinite(trial.held_out_rms_px) ? px(trial) : "not solved");
  }
  return out + (others.empty() ? "" : "; " + others) + ".";
}

}  // namespace

Result<ModelChoice> choose_model(const std::vector<target::BoardDetection>& detections,
                                 const target::BoardSpec& board, const CalibrateOptions& options) {
  const std::vector<std::size_t> order = found_in_name_order(detections);
  constexpr std::size_t kFewestViews = 6;
  if (order.size() < kFewestViews) {
    return Error{"too_few_boards", "model choice", std::to_string(order.size()) + " boards",
                 "at least 6 to leave a third of them out", "name a model, as --model opencv5"};
  }
  std::size_t corners = 0;
  for (const std::size_t i : order) corners += detections[i].corners_px.size();
  std::vector<CameraModel> models{CameraModel::opencv4, CameraModel::fisheye, CameraModel::opencv5,
                                  CameraModel::opencv8, CameraModel::opencv12};
  constexpr std::size_t kEnoughForSplines = 2000;
  if (corners >= kEnoughForSplines && !options.solve_aspect)
    models.push_back(CameraModel::splined_stereographic);
  ModelChoice out;
  for (const CameraModel model : models)
    out.trials.push_back(try_model(detections, order, board, options, model));
  std::stable_sort(out.trials.begin(), out.trials.end(),
                   [](const ModelTrial& a, const ModelTrial& b) { return a.parameters < b.parameters; });
  const ModelTrial* best = nullptr;
  for (const ModelTrial& trial : out.trials) {
    if (std::isfinite(trial.held_out_rms_px) &&
        (best == nullptr || trial.held_out_rms_px < best->held_out_rms_px))
      best = &trial;
  }
  if (best == nullptr)
    return Error{"solve_failed", "model choice", out.trials.front().reason, "a model that solves", ""};
  constexpr double kAsGood = 1.01;
  const auto chosen = std::find_if(out.trials.begin(), out.trials.end(), [&](const ModelTrial& trial) {
    return trial.held_out_rms_px <= kAsGood * best->held_out_rms_px;
  });
  out.model = chosen->model;
  out.sentence = in_words(out, *chosen, *best);
  return out;
}

std::vector<View> locate_boards(const Camera& camera, const std::vector<target::BoardDetection>& detections,
                                const target::BoardSpec& board) {
  const SharedModel model = held(camera, board, Eigen::Vector2d::Zero());
  std::vector<View> out;
  for (const target::BoardDetection& detection : detections) out.push_back(located(model, detection));
  return out;
}

}  // namespace furrow::calib
