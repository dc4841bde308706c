#pragma once
#include <string>
#include <vector>

#include "furrow/audit/finding.h"
#include "furrow/base/csv.h"
#include "furrow/figures/figures.h"

namespace furrow::report {

/// Cells as shown; the first row is the header.
struct PageTable {
  std::string caption;
  base::CsvTable cells;
  bool collapsed = false;  ///< long tables open on a click
};

struct Section {
  std::string title;
  std::vector<std::string> paragraphs;  ///< plain text
  std::vector<audit::Finding> findings;
  std::vector<PageTable> tables;
  std::vector<figures::Figure> figures;
};

/// The content of one report, in reading order.
struct Page {
  std::string title;
  std::string subtitle;              ///< what was processed, with counts
  std::vector<std::string> summary;  ///< the answer first: a few sentences
  std::vector<Section> sections;
  std::vector<std::pair<std::string, std::string>>
      provenance;  ///< name, value: version, input hashes, options
};

/// One self-contained HTML file: figures inline, no script needed to read it, no network. Same page, same
/// bytes.
std::string to_html(const Page& page);

}  // namespace furrow::report
