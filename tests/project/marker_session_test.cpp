// From rendered pictures of boards partly out of view to the camera that was rendered.
#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/parallel.h"
#include "furrow/calib/calibrate.h"
#include "furrow/sim/simulate.h"
#include "furrow/sim/world.h"
#include "furrow/target/detect.h"

namespace furrow::project {
namespace {

struct Session {
  std::vector<target::BoardDetection> detections;
  std::vector<Rigid3> truth;
  int partial = 0;
};

Session photograph(const sim::Scene& scene, const target::BoardSpec& board) {
  Session out;
  out.truth = sim::true_boards(scene);
  out.detections.resize(out.truth.size());
  const sim::Renderer renderer(scene);
  base::parallel_for(out.truth.size(), 0, [&](std::size_t i) {
    out.detections[i] = target::detect_board(renderer.board(static_cast<int>(i)), board);
    out.detections[i].image = "board-" + std::to_string(100 + i);
  });
  for (const auto& one : out.detections)
    out.partial +=
        one.found && one.corner_ids.size() < static_cast<std::size_t>(board.corners_x * board.corners_y);
  return out;
}

void expect_the_true_camera(sim::Scene scene, const target::BoardSpec& board) {
  scene.boards.type = board.kind;
  scene.boards.count = 14;
  scene.boards.corners_x = board.corners_x;
  scene.boards.corners_y = board.corners_y;
  scene.boards.square_m = board.square_m;
  scene.boards.marker_m = board.kind == target::BoardKind::charuco ? board.marker_m : 0.02;
  scene.boards.gap_m = board.kind == target::BoardKind::aprilgrid ? board.gap_m : 0.01;
  scene.boards.outside = 0.12;
  ASSERT_TRUE(sim::validate(scene).ok()) << sim::validate(scene).error().message();
  const Session session = photograph(scene, board);
  EXPECT_GT(session.partial, 2);
  const auto found = calib::calibrate(session.detections, board);
  ASSERT_TRUE(found.ok()) << found.error().message();
  int used = 0;
  for (const auto& view : found->views) used += view.used ? 1 : 0;
  EXPECT_GE(used, 13);
  EXPECT_LT(found->rms_px, 0.2);
  const auto sigma = [&](int i) { return std::sqrt(found->camera.covariance(i, i)); };
  EXPECT_NEAR(found->camera.fx, scene.camera.fx, std::max(4.0 * sigma(0), 0.3));
  EXPECT_NEAR(found->camera.fy, scene.camera.fy, std::max(4.0 * sigma(1), 0.3));
  EXPECT_NEAR(found->camera.cx, scene.camera.cx, std::max(4.0 * sigma(2), 0.3));
  EXPECT_NEAR(found->camera.cy, scene.camera.cy, std::max(4.0 * sigma(3), 0.3));
  for (std::size_t i = 0; i < found->views.size(); ++i) {
    if (!found->views[i].used) continue;
    EXPECT_LT((found->views[i].cam_from_board.translation - session.truth[i].translation).norm(),
              0.003 * session.truth[i].translation.norm())
        << i;
  }
  std::printf("fx %.2f +- %.2f (truth %.2f), rms %.3f px, %d of 14 views, %d of them parts\n",
              found->camera.fx, sigma(0), scene.camera.fx, found->rms_px, used, session.partial);
}

TEST(MarkerSession, CharucoGivesTheTrueCamera) {
  target::BoardSpec board{"charuco", 10, 7, 0.03, 1.0, target::BoardKind::charuco};
  board.marker_m = 0.022;
  board.dictionary = "5x5_250";
  expect_the_true_camera(sim::demo_scene(), board);
}

TEST(MarkerSession, AprilGridGivesTheTrueCamera) {
  target::BoardSpec board{"aprilgrid", 12, 8, 0.04, 1.0, target::BoardKind::aprilgrid};
  board.gap_m = 0.012;
  board.dictionary = "apriltag_36h11";
  expect_the_true_camera(sim::demo_scene(), board);
}

}  // namespace
}  // namespace furrow::project
