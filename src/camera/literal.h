#pragma once
#include <string>
#include <string_view>

#include "furrow/base/value.h"

namespace furrow::camera {

/// Reads one Python literal (dict, list, tuple, number, string, bytes, True/False/None, comments), which is
/// what a mrcal
/// `.cameramodel` is. Bytes literals become empty strings: they hold optimisation inputs that nothing here
/// reads. Errors: camera_file_invalid, with the line.
Result<base::Value> parse_literal(std::string_view text, const std::string& name);

}  // namespace furrow::camera
