#pragma once
#include "furrow/rows/detect.h"

namespace furrow::rows {
RowLines detect_field(const Image& picture, const DetectOptions& options);
}  // namespace furrow::rows
