#include <cmath>

#include "furrow/base/value.h"
#include "furrow/calib/calibrate.h"

namespace furrow::calib {
namespace {

using base::Array;
using base::Value;

Value numbers(const std::vector<double>& values) {
  Array out;
  for (const double v : values) out.emplace_back(v);
  return out;
}

Value numbers(const Eigen::VectorXd& values) {
  return numbers(std::vector<double>(values.data(), values.data() + values.size()));
}

Value points(const std::vector<Eigen::Vector2d>& values) {
  Array out;
  for (const Eigen::Vector2d& v : values) out.push_back(numbers(std::vector<double>{v.x(), v.y()}));
  return out;
}

Value matrix(const Eigen::MatrixXd& values) {
  if (values.size() == 0) return {};
  Array out;
  for (Eigen::Index i = 0; i < values.rows(); ++i) out.push_back(numbers(Eigen::VectorXd(values.row(i))));
  return out;
}

Value estimate(const Estimate& e) {
  if (e.observations == 0) return {};
  Value out;
  out.set("value", e.value);
  out.set("sigma", e.sigma);
  return out;
}

Value view_entry(const View& view) {
  Value out;
  out.set("image", view.image);
  out.set("used", view.used);
  out.set("rms_px", view.rms_px);
  out.set("mean_error_px", view.mean_error_px);
  out.set("reason", view.reason);
  out.set("search_steps", view.search_steps);
  out.set("search_cut", view.search_cut);
  if (!view.used) return out;
  const Eigen::Vector3d rotation = geom::rotation_vector(view.cam_from_board.rotation);
  const Eigen::Vector3d& translation = view.cam_from_board.translation;
  Value pose;
  pose.set("rotation_vector_rad", numbers(Eigen::VectorXd(rotation)));
  pose.set("translation_m", numbers(Eigen::VectorXd(translation)));
  out.set("cam_from_board", pose);
  if (!view.corner_ids.empty()) out.set("corner_ids", Array(view.corner_ids.begin(), view.corner_ids.end()));
  out.set("observed_px", points(view.observed_px));
  out.set("residual_px", points(view.residual_px));
  Array left_out;
  for (std::size_t c = 0; c < view.left_out.size(); ++c) {
    if (view.left_out[c]) left_out.emplace_back(c);
  }
  out.set("left_out", left_out);
  return out;
}

Value board_entry(const target::BoardSpec& board) {
  Value out;
  out.set("name", board.name);
  out.set("corners", Array{board.corners_x, board.corners_y});
  out.set("square_m", board.square_m);
  out.set("aspect", board.aspect);
  return out;
}

}  // namespace

std::string to_json(const Calibration& calibration) {
  const Camera& camera = calibration.camera;
  Value out;
  out.set("image_size", Array{camera.width, camera.height});
  out.set("model", camera::model_name(camera.model));
  out.set("fx", camera.fx);
  out.set("fy", camera.fy);
  out.set("cx", camera.cx);
  out.set("cy", camera.cy);
  out.set("distortion", numbers(camera.distortion));
  if (camera.model == camera::CameraModel::splined_stereographic) {
    const camera::SplineGrid& grid = camera.spline;
    out.set("spline", Array{grid.order, grid.columns, grid.rows, grid.fov_x_deg});
  }
  const bool known = camera.covariance.size() > 0;
  out.set("sigma",
          known ? numbers(Eigen::VectorXd(camera.covariance.diagonal().cwiseMax(0.0).cwiseSqrt())) : Value());
  out.set("covariance", matrix(camera.covariance));
  out.set("provenance", camera.provenance);
  if (!calibration.model_choice.empty()) out.set("model_choice", calibration.model_choice);
  out.set("rms_px", calibration.rms_px);
  out.set("mean_error_px", calibration.mean_error_px);
  out.set("sigma0_px", calibration.sigma0_px);
  out.set("degrees_of_freedom", calibration.degrees_of_freedom);
  out.set("corners", calibration.corners);
  out.set("corners_left_out", calibration.corners_left_out);
  out.set("iterations", calibration.iterations);
  out.set("termination", calibration.termination);
  out.set("usable", calibration.usable);
  out.set("board", board_entry(calibration.board));
  out.set("board_aspect", estimate(calibration.board_aspect));
  out.set("board_warp_x_m", estimate(calibration.board_warp_x_m));
  out.set("board_warp_y_m", estimate(calibration.board_warp_y_m));
  Array warnings;
  for (const std::string& text : calibration.warnings) warnings.emplace_back(text);
  out.set("warnings", warnings);
  out.set("search_steps_bound", target::kMostSearchSteps);
  Array views;
  for (const View& view : calibration.views) views.push_back(view_entry(view));
  out.set("views", views);
  return base::to_json(out) + "\n";
}

}  // namespace furrow::calib
