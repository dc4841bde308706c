#include "furrow/calib/mrcal_inputs.h"

#include "calib/model.h"
#include "calib/npz.h"
#include "furrow/camera/model_files.h"

namespace furrow::calib {
namespace {

/// Pixel and weight of every corner of the board; a weight below 0 is mrcal's word for "not used".
void append_observations(const View& view, std::size_t corners, std::vector<double>& out) {
  constexpr double kUnused = -1.0;
  std::vector<double> all;
  for (std::size_t c = 0; c < corners; ++c) all.insert(all.end(), {0.0, 0.0, kUnused});
  for (std::size_t c = 0; c < view.observed_px.size(); ++c) {
    const std::size_t at = 3 * static_cast<std::size_t>(corner_id(view.corner_ids, c));
    const bool used = view.left_out.empty() || !view.left_out[c];
    all[at] = view.observed_px[c].x();
    all[at + 1] = view.observed_px[c].y();
    all[at + 2] = used ? (view.weight.empty() ? 1.0 : view.weight[c]) : kUnused;
  }
  out.insert(out.end(), all.begin(), all.end());
}

bool has_mrcals_board(const target::BoardSpec& board) {
  return board.kind != target::BoardKind::aprilgrid && board.aspect == 1.0;
}

}  // namespace

std::string mrcal_optimization_inputs(const Calibration& calibration) {
  const Camera& camera = calibration.camera;
  const target::BoardSpec& board = calibration.board;
  if (camera.model == camera::CameraModel::fisheye || !has_mrcals_board(board)) return "";
  const bool splined = camera.model == camera::CameraModel::splined_stereographic;
  const bool warped = calibration.board_warp_x_m.observations > 0;
  const auto corners = static_cast<std::size_t>(board.corners_x) * static_cast<std::size_t>(board.corners_y);
  std::vector<double> poses, observations;
  std::vector<std::int32_t> indices;
  std::int32_t views = 0;
  for (const View& view : calibration.views) {
    if (!view.used) continue;
    const PoseVector pose = pose_vector(view.cam_from_board);
    poses.insert(poses.end(), pose.data(), pose.data() + pose.size());
    indices.insert(indices.end(), {views++, 0, -1});
    append_observations(view, corners, observations);
  }
  const Eigen::VectorXd lens = camera::intrinsics(camera);
  Npz out;
  out.add("intrinsics", {1, static_cast<int>(lens.size())},
          std::vector<double>(lens.data(), lens.data() + lens.size()));
  out.add("extrinsics_rt_fromref", {0, 6}, std::vector<double>{});
  out.add("frames_rt_toref", {views, 6}, poses);
  out.add("observations_board", {views, board.corners_y, board.corners_x, 3}, observations);
  out.add("indices_frame_camintrinsics_camextrinsics", {views, 3}, indices);
  for (const char* none : {"points", "observations_point", "indices_point_camintrinsics_camextrinsics"})
    out.add_text(none, "");
  out.add_text("lensmodel", camera::mrcal_lensmodel(camera));
  out.add("imagersizes", {1, 2}, std::vector<std::int32_t>{camera.width, camera.height});
  out.add("calobject_warp", {2},
          warped ? std::vector<double>{calibration.board_warp_x_m.value, calibration.board_warp_y_m.value}
                 : std::vector<double>{0.0, 0.0});
  out.add_number("calibration_object_spacing", board.square_m);
  out.add_flag("do_optimize_intrinsics_core", !splined);
  out.add_flag("do_optimize_intrinsics_distortions", true);
  out.add_flag("do_optimize_extrinsics", true);
  out.add_flag("do_optimize_frames", true);
  out.add_flag("do_optimize_calobject_warp", warped);
  out.add_flag("do_apply_outlier_rejection", false);
  out.add_flag("do_apply_regularization", splined);
  out.add_flag("verbose", false);
  return base85(out.bytes());
}

}  // namespace furrow::calib
