#pragma once
#include "furrow/target/detect.h"
#include "target/search_work.h"

namespace furrow::target {

/// detect_board() for boards with markers, of which a part is enough. `grey` has one channel.
BoardDetection detect_marker_board(const Image& grey, const BoardSpec& board, const DetectOptions& options,
                                   SearchWork& work);

/// What pictures of markers show instead of a description: "squares: [11, 8] fits 34 markers of 40 seen",
/// another dictionary, or that there are none.
std::string explain_marker_board(const std::vector<Image>& greys, const BoardSpec& described);

}  // namespace furrow::target
