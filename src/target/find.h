#pragma once
#include <optional>

#include "target/grid.h"

namespace furrow::target {

/// A grid of columns x rows corners, good to a pixel or two, in no particular orientation; nothing when none
/// is seen.
std::optional<Grid> find_grid(const Image& grey, int columns, int rows);

}  // namespace furrow::target
