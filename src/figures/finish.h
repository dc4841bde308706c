#pragma once
#include <string>
#include <vector>

#include "figures/drawing.h"
#include "furrow/figures/figures.h"

namespace furrow::figures {

/// Blank paper of the width that the options ask for. Errors: figure_size (narrower than a figure can be
/// read, or not a number).
Result<Drawing> paper(const FigureOptions& options, double height_mm);

/// Paints the drawing and puts the figure together.
Result<Figure> finish(const std::string& name, const std::string& caption, const Drawing& drawing,
                      base::CsvTable data, const FigureOptions& options);

Error nothing_to_draw(const std::string& figure, const std::string& found, const std::string& wanted);

/// Fixed decimals, or an empty cell for what is not there.
std::string cell(double value, int decimals);

/// A shot id as part of a file name: ids may hold anything, file names may not.
std::string file_stem(const std::string& shot_id);

/// "1 shot", "3 shots".
std::string count_of(std::size_t count, const std::string& thing);

/// What a caption says of values beyond the axis; empty for none.
std::string beyond_text(int beyond);

}  // namespace furrow::figures
