#pragma once
#include <string>
#include <vector>

#include "furrow/audit/finding.h"
#include "furrow/base/csv.h"
#include "furrow/base/progress.h"
#include "furrow/base/result.h"
#include "furrow/base/value.h"

namespace furrow::cli {

/// A bar with rate and time left on a terminal's standard error, a line at each tenth elsewhere.
base::Progress progress_on_stderr();

/// "furrow: message" on standard error; returns kBadInput.
int fail(const Error& error);

/// Findings as lines on standard error; returns kFindingFailed when one failed, else kDone.
int print_findings(const std::vector<audit::Finding>& findings);

/// Findings for --json.
base::Value findings_value(const std::vector<audit::Finding>& findings);

/// A table with aligned columns on standard output.
void print_table(const base::CsvTable& table);

/// JSON on standard output.
void print_json(const base::Value& value);

}  // namespace furrow::cli
