#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::depth {

/// One number a pixel, rows from top to bottom; NaN where nothing is known. What the numbers mean is said
/// beside the map: a sigmoid disparity between 0 and 1, or metres along the optical axis.
struct DepthMap {
  int width = 0;   ///< px
  int height = 0;  ///< px
  std::vector<float> values;

  float at(int u, int v) const {
    return values[static_cast<std::size_t>(v) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(u)];
  }
};

/// Reads a depth map: .npy (float or unsigned integers; leading axes of length 1 are dropped), .pfm (one
/// channel), or .png (16 or 8 bit, one channel; a count of 0 is "not known", as KITTI has it). Counts of
/// integers are multiplied by `unit_per_count`; floats are taken as they are. Values that are not above 0
/// become NaN. Errors: file_*, depth_map_unreadable (what was found).
Result<DepthMap> read_depth_map(const std::filesystem::path& file, double unit_per_count);

/// The same from a file's bytes; `name` stands in messages and its extension chooses the format.
Result<DepthMap> decode_depth_map(const std::string& bytes, const std::string& name, double unit_per_count);

}  // namespace furrow::depth
