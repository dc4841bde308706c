#pragma once
#include <string>
#include <vector>

#include "furrow/target/board.h"

namespace furrow::target {

/// A sheet of paper, upright.
struct Paper {
  std::string name;
  double width_m = 0.0, height_m = 0.0;
};

/// "A0" to "A6" (ISO 216), "letter", "legal", "tabloid" (ANSI), or "600x400mm". Errors: paper_unknown.
Result<Paper> find_paper(const std::string& name);

enum class SheetFormat { pdf, svg, png };

/// By the extension of a file's name. Errors: sheet_format.
Result<SheetFormat> sheet_format(const std::filesystem::path& file);

/// A page to print, true to scale.
struct Sheet {
  double width_m = 0.0, height_m = 0.0;      ///< of the page, turned as the board needs it
  Eigen::Vector2d first_corner_m{0.0, 0.0};  ///< from the page's top-left corner, to the right and down
  std::string bytes;                         ///< the file; the same board and paper give the same bytes
};

/// Draws a board with a margin, a bar to measure after printing, the board's name and its description.
/// `dpi` is a PNG's resolution, stated in the file. Errors: board_invalid, sheet_too_small (says which paper
/// or which square would fit), bad_dpi (outside 50 to 1200, or more than 200 megapixels).
Result<Sheet> draw_sheet(const BoardSpec& board, const Paper& paper, SheetFormat format, double dpi = 300.0);

/// "checkerboard, 9 x 6 inner corners, squares 25 mm".
std::string describe(const BoardSpec& board);

}  // namespace furrow::target
