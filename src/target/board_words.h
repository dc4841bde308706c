#pragma once
#include <string>

namespace furrow::target {

/// "9x6", for sentences: of counts, or of a picture's size.
inline std::string size_name(int columns, int rows) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

}  // namespace furrow::target
