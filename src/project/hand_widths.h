#pragma once
#include <filesystem>
#include <map>
#include <string>

#include "furrow/base/result.h"

namespace furrow::project {

/// Half widths of the followed row at the picture's middle row, px, by shot_id, as a person measured them:
/// columns shot_id and half_width_px, empty where nothing could be measured. Errors: file_*, csv_*,
/// missing_column, bad_value (with the line).
Result<std::map<std::string, double>> read_hand_widths(const std::filesystem::path& file);

}  // namespace furrow::project
