#pragma once
#include "furrow/rows/detect.h"

namespace furrow::bench {

/// Prints how detection stands up to noise, blur, row count, pitch, roll, missing plants and bends, on drawn
/// fields with fixed seeds: the part of the pictures whose followed row and spacing are right, and the median
/// score and confidence.
void print_row_sweep(rows::Method method, const char* method_name);

}  // namespace furrow::bench
