#pragma once
#include <vector>

#include "furrow/rows/detect.h"

namespace furrow::bench {

/// What a picture's rows said of themselves, and whether they were right.
struct Answer {
  double confidence = 0.0;
  bool is_right = false;
};

/// Prints how detection stands up to noise, blur, row count, pitch, roll, missing plants and bends, on drawn
/// fields with fixed seeds: the part of the pictures whose followed row and spacing are right, and the median
/// score and confidence. Gives every picture's answer.
std::vector<Answer> print_row_sweep(rows::Method method, const char* method_name);

}  // namespace furrow::bench
