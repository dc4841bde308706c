#pragma once
#include <string>
#include <vector>

#include "edge_line.h"
#include "furrow/base/result.h"
#include "prism.h"

namespace furrow::altitude {

/// Rows that tell no pencil, and what would.
Error degenerate(const char* code, std::string found, std::string wanted);

/// Lines of the rows that may take part: clear edges where two rows show them. `may_be_one`: a row alone, row
/// 0, will do. Errors: not_finite, ill_conditioned, not_enough_rows.
Result<std::vector<EdgeLine>> usable_lines(const RowsOnUnitPlane& rows, bool may_be_one);

int distinct_rows(const std::vector<EdgeLine>& lines);

/// Slope at which a line lies: the t that puts its middle on l = m + t q.
double slope_at(const RowAxes<double>& axes, const EdgeLine& line);

/// Below the horizon of the rows, by the middle of its samples; its two points may reach beyond them.
bool below_horizon(const RowAxes<double>& axes, const EdgeLine& line);

/// To which side of its row's axis the line lies: 1 left, -1 right, 0 its middle.
double side_of(const EdgeLine& line);

/// The silhouette on the far side is the top edge whatever the shape of the wall (eq. 3.5).
bool is_top_edge(const EdgeLine& line, double slope);

/// EdgeLine::reach of far edges of tops that are `depth` half widths deep; 1 for near edges.
void set_reaches(std::vector<EdgeLine>& lines, const RowAxes<double>& axes, double depth);

/// Lines that the pencil's model holds for: far edges and centres; near edges too when fewer than two rows
/// are left without them.
std::vector<EdgeLine> top_lines(const std::vector<EdgeLine>& lines, const RowAxes<double>& axes);

}  // namespace furrow::altitude
