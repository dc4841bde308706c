#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/progress.h"
#include "furrow/base/result.h"
#include "furrow/sim/scene.h"

namespace furrow::sim {

/// Where a simulated session lies and what is in it.
struct Simulated {
  std::filesystem::path folder;
  int boards = 0;
  int shots = 0;
};

struct SimulateOptions {
  /// Threads to render with; 0: one per core. The bytes do not depend on it.
  int threads = 0;
};

/// Renders `scene` into `folder`: boards/*.png with board.yaml, frames/*.jpg, airdata.csv (AirData's columns,
/// feet and mph as it writes them), truth.csv (shot_id and exact camera pose, heights, row geometry),
/// boards_truth.csv (exact place of every corner), rows_truth.csv (where the rows' plane of tops crosses the
/// pictures), camera_true.yaml, scene.yaml (every value used) and project.yaml, ready for `furrow run`. Same
/// scene, same bytes. Errors: file_unwritable, scene_invalid.
Result<Simulated> simulate(const Scene& scene, const std::filesystem::path& folder,
                           const base::Progress& progress = {}, const SimulateOptions& options = {});

/// The scene of `furrow demo`: the thesis's camera over 3 m vineyard rows of 1.7 m, heights 3, 4, 5 m above
/// ground, pitch -12.4 and -13.8 deg, gimbal bias, drifting barometer, VPS that switches between canopy and
/// soil.
Scene demo_scene();

}  // namespace furrow::sim
