#pragma once
#include <filesystem>

#include "furrow/base/result.h"

namespace furrow::base {

/// Whether results can be written into `folder`, which need not be there yet: asked before work that takes
/// minutes. Makes nothing. Error: file_unwritable, naming the part of the path that is no folder or may not
/// be written.
Status can_hold_results(const std::filesystem::path& folder);

}  // namespace furrow::base
