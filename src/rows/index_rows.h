#pragma once
#include <vector>

#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"

namespace furrow::rows {

/// An answer for a picture, still without rows; says so where there is no picture.
RowLines begun(const Image& picture, const char* method);

/// Picture rows from the first to the last, both included, evenly spaced at most `step_px` apart.
std::vector<double> sample_rows(int height, double step_px);

/// Orders rows from left to right on the picture's middle row and gives index 0 to the one nearest the middle
/// column there. Rows that do not reach the middle row are placed by their nearest sample.
void index_rows(RowLines& lines);

/// Shifts the indices of rows that a common model has numbered already so that the followed row is 0. Rows
/// that leave the picture above its middle row keep their numbers, which their places would not tell.
void count_from_followed(RowLines& lines);

}  // namespace furrow::rows
