#pragma once
#include <string>

namespace furrow::base {

/// "0.1.0", as in CMakeLists.txt.
std::string version();

}  // namespace furrow::base
