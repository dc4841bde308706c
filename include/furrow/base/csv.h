#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::base {

/// Rows of text under named columns. Cells keep the file's text; the reader trims blanks around them.
struct CsvTable {
  std::string source;                          ///< file name, for messages
  std::vector<std::string> columns;            ///< trimmed header names
  std::vector<std::vector<std::string>> rows;  ///< each as long as `columns`
  std::vector<int> lines;                      ///< 1-based line where each row starts
  std::vector<std::string> warnings;           ///< e.g. a truncated last row, which was dropped

  /// Place of the column, or nothing.
  std::optional<std::size_t> column(std::string_view name) const;
};

/// Reads CSV with quotes, a BOM, CRLF, a leading `sep=` line, and ',' ';' or tab as separator (found from the
/// header). Blank lines are skipped; a short last row is dropped with a warning; any other row of another
/// length is an error. Errors: csv_empty, csv_row_length, csv_quote (unfinished), file_*.
Result<CsvTable> read_csv(const std::filesystem::path& file);
Result<CsvTable> parse_csv(std::string_view text, const std::string& name);

/// CSV text: header, then rows; '\n' line ends; cells quoted only where needed.
std::string to_csv(const CsvTable& table);

}  // namespace furrow::base
