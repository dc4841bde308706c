#pragma once
#include <cstdint>

#include "furrow/geom/rigid3.h"
#include "sim/lens.h"

namespace furrow::sim {

/// The scene's board. ChArUco markers are of OpenCV's 5x5_250, an AprilGrid's tags of 36h11.
target::BoardSpec printed_board(const Boards& boards);

/// The light of one board picture: the printed sheet on a grey wall.
LightImage light_board(const Scene& scene, const RayTable& rays, const Rigid3& cam_from_board,
                       std::uint64_t key);

}  // namespace furrow::sim
