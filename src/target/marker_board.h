#pragma once
#include "furrow/target/detect.h"

namespace furrow::target {

/// detect_board() for boards with markers, of which a part is enough. `grey` has one channel.
BoardDetection detect_marker_board(const Image& grey, const BoardSpec& board, const DetectOptions& options);

}  // namespace furrow::target
