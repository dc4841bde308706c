#include "furrow/base/csv.h"

#include <algorithm>

#include "furrow/base/file.h"
#include "furrow/base/text.h"

namespace furrow::base {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

/// One record and where it started.
struct Record {
  std::vector<std::string> cells;
  int line = 0;
  bool at_end_of_text = false;  ///< no line end followed it
};

/// Cuts text into records; quotes may hold separators and line ends.
class Reader {
 public:
  Reader(std::string_view text, char separator, int first_line)
      : text_(text), separator_(separator), line_(first_line) {}

  bool done() const { return at_ >= text_.size(); }

  /// Nothing when a quote is not closed before the end of the text.
  std::optional<Record> next() {
    Record record;
    record.line = line_;
    while (true) {
      auto cell = next_cell();
      if (!cell) return std::nullopt;
      record.cells.push_back(std::move(*cell));
      if (done()) {
        record.at_end_of_text = true;
        return record;
      }
      const char end = text_[at_++];
      if (end == separator_) continue;
      if (end == '\r' && !done() && text_[at_] == '\n') ++at_;
      ++line_;
      return record;
    }
  }

 private:
  std::optional<std::string> next_cell() {
    std::string cell;
    const std::size_t start = at_;
    while (!done() && (text_[at_] == ' ')) ++at_;
    if (done() || text_[at_] != '"') {
      at_ = start;
      while (!done() && text_[at_] != separator_ && text_[at_] != '\n' && text_[at_] != '\r') ++at_;
      return std::string(trim(text_.substr(start, at_ - start)));
    }
    for (++at_; !done(); ++at_) {
      const char c = text_[at_];
      if (c == '"') {
        if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
          ++at_;
        } else {
          break;
        }
      }
      if (c == '\n') ++line_;
      cell += c;
    }
    if (done()) return std::nullopt;
    ++at_;
    while (!done() && text_[at_] != separator_ && text_[at_] != '\n' && text_[at_] != '\r')
      cell += text_[at_++];
    return cell;
  }

  std::string_view text_;
  char separator_;
  std::size_t at_ = 0;
  int line_;
};

/// The separator that occurs most in the header line; ',' when none does.
char find_separator(std::string_view text) {
  const std::string_view header = text.substr(0, text.find('\n'));
  char best = ',';
  auto most = std::count(header.begin(), header.end(), ',');
  for (const char candidate : {';', '\t'}) {
    const auto count = std::count(header.begin(), header.end(), candidate);
    if (count > most) {
      most = count;
      best = candidate;
    }
  }
  return best;
}

bool is_blank(const Record& record) {
  return record.cells.size() == 1 && trim(record.cells[0]).empty();
}

std::string quoted(const std::string& cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos && trim(cell).size() == cell.size()) return cell;
  std::string text = "\"";
  for (const char c : cell) {
    if (c == '"') text += '"';
    text += c;
  }
  return text + '"';
}

}  // namespace

std::optional<std::size_t> CsvTable::column(std::string_view name) const {
  const auto found = std::find(columns.begin(), columns.end(), name);
  if (found == columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - columns.begin());
}

Result<CsvTable> read_csv(const std::filesystem::path& file) {
  FURROW_TRY(const std::string text, read_file(file));
  return parse_csv(text, file.filename().string());
}

Result<CsvTable> parse_csv(std::string_view text, const std::string& name) {
  CsvTable table;
  table.source = name;
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  int first_line = 1;
  if (text.starts_with("sep=")) {
    const auto end = text.find('\n');
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    first_line = 2;
  }
  Reader reader(text, find_separator(text), first_line);
  while (!reader.done()) {
    auto record = reader.next();
    if (!record) {
      return Error{"csv_quote", name, "a quoted cell is not closed before the end of the file",
                   "a closing \"", "The file may be cut short; export it again."};
    }
    if (is_blank(*record)) continue;
    if (table.columns.empty()) {
      table.columns = std::move(record->cells);
      for (auto& column : table.columns) column = std::string(trim(column));
      continue;
    }
    if (record->cells.size() != table.columns.size()) {
      const std::string where = name + ":" + std::to_string(record->line);
      if (record->at_end_of_text && record->cells.size() < table.columns.size()) {
        table.warnings.push_back(where + ": the last row is cut short (" +
                                 std::to_string(record->cells.size()) + " of " +
                                 std::to_string(table.columns.size()) + " cells) and was left out");
        continue;
      }
      return Error{"csv_row_length", where, std::to_string(record->cells.size()) + " cells",
                   std::to_string(table.columns.size()) + ", as in the header", ""};
    }
    table.lines.push_back(record->line);
    table.rows.push_back(std::move(record->cells));
  }
  if (table.columns.empty())
    return Error{"csv_empty", name, "the file is empty", "a header line and rows", ""};
  return table;
}

std::string to_csv(const CsvTable& table) {
  std::string text;
  const auto add_row = [&text](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i > 0) text += ',';
      text += quoted(cells[i]);
    }
    text += '\n';
  };
  add_row(table.columns);
  for (const auto& row : table.rows) add_row(row);
  return text;
}

}  // namespace furrow::base
