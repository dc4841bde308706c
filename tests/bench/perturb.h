#pragma once
#include <string>
#include <vector>

#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"

namespace furrow::bench {

/// A copy of a picture that shows the same rows: u_original = (is_mirrored ? width - 1 - u : u) / scale +
/// first_u about pixel borders.
struct Perturbed {
  std::string name;
  Image picture;
  bool is_mirrored = false;
  double scale = 1.0;
  int first_u = 0;  ///< columns of the original that were cut off at its left
};

/// Mirrored, cropped at the sides, made smaller and larger, darker and redder, compressed, with noise.
std::vector<Perturbed> perturbed_copies(const Image& original);

/// Rows of the copy as rows of the original: places in its px, numbers from its left to its right.
rows::RowLines in_original(const rows::RowLines& lines, const Perturbed& copy, const Image& original);

}  // namespace furrow::bench
