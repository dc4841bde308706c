#include "furrow/report/page.h"

#include <kainjow/mustache.hpp>

#include <algorithm>
#include <array>

#include "figures/utf8.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "report/template.h"

namespace furrow::report {
namespace {

using kainjow::mustache::data;
using List = data;

/// Numbers that run through the whole page.
struct Counters {
  int section = 0, finding = 0, figure = 0, table = 0;
};

List empty_list() {
  return data(data::type::list);
}

/// Text as the template takes it. Names come from files: whatever is no UTF-8 must not reach the browser.
data text(const std::string& raw) {
  return data(figures::printable(raw));
}

/// A text that switches its part of the template off when empty.
void set_optional(data& object, const std::string& key, const std::string& raw) {
  object.set(key, raw.empty() ? data(data::type::bool_false) : text(raw));
}

data flag(bool on) {
  return data(on ? data::type::bool_true : data::type::bool_false);
}

struct VerdictLook {
  const char* kind;
  const char* mark;
  const char* word;
};

VerdictLook look_of(audit::Verdict verdict) {
  switch (verdict) {
    case audit::Verdict::pass:
      return {"pass", kPassMark, "Pass"};
    case audit::Verdict::fail:
      return {"fail", kFailMark, "Fail"};
    case audit::Verdict::not_assessed:
      break;
  }
  return {"open", kOpenMark, "Not assessed"};
}

data finding_data(const audit::Finding& finding, int number) {
  const VerdictLook look = look_of(finding.verdict);
  data out;
  out.set("number", std::to_string(number));
  out.set("kind", look.kind);
  out.set("mark", look.mark);
  out.set("word", look.word);
  out.set("title", text(finding.title.empty() ? finding.id : finding.title));
  set_optional(out, "value", finding.value);
  set_optional(out, "limit", finding.limit);
  set_optional(out, "evidence", finding.evidence);
  out.set("has_detail", flag(!finding.value.empty() || !finding.limit.empty()));
  return out;
}

/// The vector form where there is one: sharp at any size, and a photograph in it is a JPEG. As an image of
/// its own, names and styles inside one figure cannot meet those of another.
std::string image_uri(const figures::Figure& figure) {
  if (!figure.svg.empty()) return "data:image/svg+xml;base64," + base::base64(figure.svg);
  return "data:image/png;base64," + base::base64(figure.png);
}

std::string rows_text(std::size_t rows) {
  return std::to_string(rows) + (rows == 1 ? " row" : " rows");
}

data figure_data(const figures::Figure& figure, int number) {
  constexpr int kOneColumnPx =
      800;  // wider ones scroll sideways on a phone instead of shrinking beyond reading
  data out;
  out.set("number", std::to_string(number));
  out.set("name", text(figure.name));
  out.set("caption", text(figure.caption));
  out.set("uri", image_uri(figure));
  out.set("width", std::to_string(figure.width_px));
  out.set("height", std::to_string(figure.height_px));
  out.set("narrow", flag(figure.width_px < kOneColumnPx));
  const bool has_data = !figure.data.rows.empty();
  out.set("data_uri",
          has_data ? data("data:text/csv;charset=utf-8;base64," + base::base64(base::to_csv(figure.data)))
                   : data(data::type::bool_false));
  out.set("data_rows", rows_text(figure.data.rows.size()));
  return out;
}

/// A number as tables write it: "3.02", "−0.4", "3.02 ± 0.05", "68 %".
bool looks_like_number(std::string_view cell) {
  constexpr std::string_view kMinus = "\u2212", kPlusMinus = "\u00b1";
  bool digit = false;
  while (!cell.empty()) {
    const char c = cell.front();
    std::size_t length = 1;
    if (cell.starts_with(kMinus)) {
      length = kMinus.size();
    } else if (cell.starts_with(kPlusMinus)) {
      length = kPlusMinus.size();
    } else if (c >= '0' && c <= '9') {
      digit = true;
    } else if (std::string_view(" .-+%").find(c) == std::string_view::npos) {
      return false;
    }
    cell.remove_prefix(length);
  }
  return digit;
}

/// Nothing to say there: "" or "-".
bool is_blank(const std::string& cell) {
  const auto trimmed = base::trim(cell);
  return trimmed.empty() || trimmed == "-";
}

/// Columns of numbers stand right-aligned: every cell a number, or blank, and at least one number.
std::vector<bool> number_columns(const base::CsvTable& cells) {
  std::vector<bool> numeric(cells.columns.size(), false);
  for (std::size_t c = 0; c < numeric.size(); ++c) {
    bool any = false, all = true;
    for (const auto& row : cells.rows) {
      if (c >= row.size() || is_blank(row[c])) continue;
      const bool number = looks_like_number(row[c]);
      any = any || number;
      all = all && number;
    }
    numeric[c] = any && all;
  }
  return numeric;
}

/// Cells so short stay on one line.
constexpr std::size_t kShortCell = 14;

data cells_data(const std::vector<std::string>& cells, const std::vector<bool>& numeric) {
  data out = empty_list();
  for (std::size_t c = 0; c < cells.size(); ++c) {
    data cell;
    cell.set("text", text(cells[c]));
    const bool number = c < numeric.size() && numeric[c];
    cell.set("num", flag(number));
    cell.set("short", flag(!number && cells[c].size() <= kShortCell));
    out << cell;
  }
  return out;
}

data table_data(const PageTable& table, int number) {
  const std::vector<bool> numeric = number_columns(table.cells);
  data rows = empty_list();
  for (const auto& row : table.cells.rows) {
    data one;
    one.set("cells", cells_data(row, numeric));
    rows << one;
  }
  data out;
  out.set("number", std::to_string(number));
  out.set("caption", text(table.caption));
  out.set("columns", cells_data(table.cells.columns, numeric));
  out.set("rows", rows);
  out.set("rows_text", rows_text(table.cells.rows.size()));
  out.set("collapsed", flag(table.collapsed));
  return out;
}

data paragraphs_data(const std::vector<std::string>& paragraphs) {
  data out = empty_list();
  for (const std::string& paragraph : paragraphs) {
    data one;
    one.set("text", text(paragraph));
    out << one;
  }
  return out;
}

data section_data(const Section& section, Counters& counters) {
  data out, findings = empty_list(), figures = empty_list(), tables = empty_list();
  for (const audit::Finding& finding : section.findings)
    findings << finding_data(finding, ++counters.finding);
  for (const figures::Figure& figure : section.figures) figures << figure_data(figure, ++counters.figure);
  for (const PageTable& table : section.tables) tables << table_data(table, ++counters.table);
  out.set("number", std::to_string(++counters.section));
  out.set("title", text(section.title));
  out.set("paragraphs", paragraphs_data(section.paragraphs));
  out.set("has_findings", flag(!section.findings.empty()));
  out.set("findings", findings);
  out.set("figures", figures);
  out.set("tables", tables);
  return out;
}

void set_tally(data& page_data, const Page& page) {
  std::array<int, 3> counts{};
  data failed = empty_list();
  int number = 0;
  for (const Section& section : page.sections) {
    for (const audit::Finding& finding : section.findings) {
      ++number;
      ++counts.at(static_cast<std::size_t>(finding.verdict));
      if (finding.verdict == audit::Verdict::fail) failed << finding_data(finding, number);
    }
  }
  data tally = empty_list();
  const std::array<const char*, 3> words{"passed", "failed", "not assessed"};
  for (const auto verdict : {audit::Verdict::fail, audit::Verdict::pass, audit::Verdict::not_assessed}) {
    const auto i = static_cast<std::size_t>(verdict);
    if (counts.at(i) == 0) continue;
    data one;
    one.set("kind", look_of(verdict).kind);
    one.set("mark", look_of(verdict).mark);
    one.set("count", std::to_string(counts.at(i)));
    one.set("words", words.at(i));
    tally << one;
  }
  page_data.set("tally", tally);
  page_data.set("has_tally", flag(number > 0));
  page_data.set("failed", failed);
  page_data.set("has_failed", flag(counts[static_cast<std::size_t>(audit::Verdict::fail)] > 0));
}

}  // namespace

std::string to_html(const Page& page) {
  Counters counters;
  data out, sections = empty_list(), provenance = empty_list();
  for (const Section& section : page.sections) sections << section_data(section, counters);
  for (const auto& [name, value] : page.provenance) {
    data one;
    one.set("name", text(name));
    one.set("value", text(value));
    provenance << one;
  }
  out.set("title", text(page.title));
  set_optional(out, "subtitle", page.subtitle);
  out.set("style", kStyle);
  out.set("summary", paragraphs_data(page.summary));
  set_tally(out, page);
  out.set("sections", sections);
  out.set("provenance", provenance);
  out.set("has_provenance", flag(!page.provenance.empty()));
  kainjow::mustache::mustache form{kPage};
  check(form.is_valid(), "the report's template is well-formed");
  return form.render(out);
}

}  // namespace furrow::report
