#include "project/hand_widths.h"

#include "furrow/base/csv.h"
#include "furrow/base/text.h"

namespace furrow::project {

Result<std::map<std::string, double>> read_hand_widths(const std::filesystem::path& file) {
  FURROW_TRY(const base::CsvTable table, base::read_csv(file));
  const auto id = table.column("shot_id");
  const auto width = table.column("half_width_px");
  if (!id || !width)
    return Error{"missing_column", table.source, "no shot_id or no half_width_px", "both columns", ""};
  std::map<std::string, double> widths;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const auto cell = base::trim(table.rows[i][*width]);
    if (cell.empty()) continue;
    const auto value = base::parse_double(cell);
    if (!value || !(*value > 0.0)) {
      return Error{"bad_value", table.source + ":" + std::to_string(table.lines[i]),
                   "half_width_px is '" + std::string(cell) + "'", "pixels above 0, or an empty cell", ""};
    }
    widths[std::string(base::trim(table.rows[i][*id]))] = *value;
  }
  return widths;
}

}  // namespace furrow::project
