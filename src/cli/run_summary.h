#pragma once
#include "furrow/project/jobs.h"

namespace furrow::cli {

/// Prints a finished run: the comparison with the truth where there is one, findings, and the report's path.
/// Returns the exit code.
int print_run(const project::RunOutcome& outcome, bool json);

}  // namespace furrow::cli
