#include "cli/terminal.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>

#include "cli/commands.h"
#include "furrow/base/text.h"

namespace furrow::cli {
namespace {

using Clock = std::chrono::steady_clock;

struct Bar {
  std::string stage;
  Clock::time_point started;
  Clock::time_point drawn;
  std::size_t tenth = 0;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string counts(const base::ProgressEvent& event) {
  return std::to_string(event.done) + (event.total > 0 ? "/" + std::to_string(event.total) : "");
}

void draw_bar(const Bar& bar, const base::ProgressEvent& event) {
  constexpr std::size_t kWidth = 24;
  const double share =
      event.total > 0 ? static_cast<double>(event.done) / static_cast<double>(event.total) : 0.0;
  const auto filled = static_cast<std::size_t>(share * kWidth);
  const double elapsed = seconds_since(bar.started);
  const double rate = elapsed > 0.0 ? static_cast<double>(event.done) / elapsed : 0.0;
  std::string tail;
  if (rate > 0.0 && event.done < event.total) {
    tail = base::format_fixed(rate, 1) + "/s, " +
           base::format_fixed(static_cast<double>(event.total - event.done) / rate, 0) + " s left";
  } else if (event.done == event.total) {
    tail = base::format_fixed(elapsed, 1) + " s";
  }
  std::fprintf(stderr, "\r\033[K%-18s [%s%s] %s  %s", event.stage.c_str(), std::string(filled, '#').c_str(),
               std::string(kWidth - filled, '.').c_str(), counts(event).c_str(), tail.c_str());
  if (event.total > 0 && event.done >= event.total) std::fputc('\n', stderr);
  std::fflush(stderr);
}

void print_tenth(Bar& bar, const base::ProgressEvent& event) {
  const std::size_t tenth = event.total > 0 ? 10 * event.done / event.total : 0;
  if (event.done != 0 && tenth == bar.tenth) return;
  bar.tenth = tenth;
  if (event.done > 0) std::fprintf(stderr, "%s: %s\n", event.stage.c_str(), counts(event).c_str());
}

std::string verdict_word(audit::Verdict verdict) {
  switch (verdict) {
    case audit::Verdict::pass:
      return "pass";
    case audit::Verdict::fail:
      return "FAIL";
    default:
      return "not assessed";
  }
}

}  // namespace

base::Progress progress_on_stderr() {
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  auto bar = std::make_shared<Bar>();
  return [terminal, bar](const base::ProgressEvent& event) {
    if (event.stage != bar->stage) *bar = {event.stage, Clock::now(), {}, 0};
    if (!terminal) return print_tenth(*bar, event);
    const bool last = event.total > 0 && event.done >= event.total;
    if (!last && seconds_since(bar->drawn) < 0.1) return;
    bar->drawn = Clock::now();
    draw_bar(*bar, event);
  };
}

int fail(const Error& error) {
  std::fprintf(stderr, "furrow: %s\n", error.message().c_str());
  return kBadInput;
}

int print_findings(const std::vector<audit::Finding>& findings) {
  bool failed = false;
  for (const auto& finding : findings) {
    failed = failed || finding.verdict == audit::Verdict::fail;
    std::string line = verdict_word(finding.verdict) + ": " + finding.title;
    if (!finding.value.empty()) line += ": " + finding.value + " (" + finding.limit + ")";
    if (finding.verdict != audit::Verdict::pass && !finding.evidence.empty()) line += "; " + finding.evidence;
    std::fprintf(stderr, "%s\n", line.c_str());
  }
  return failed ? kFindingFailed : kDone;
}

base::Value findings_value(const std::vector<audit::Finding>& findings) {
  base::Array entries;
  for (const auto& finding : findings) {
    base::Value value;
    value.set("id", finding.id);
    value.set("title", finding.title);
    value.set("verdict", verdict_word(finding.verdict) == "FAIL" ? "fail" : verdict_word(finding.verdict));
    value.set("value", finding.value);
    value.set("limit", finding.limit);
    value.set("evidence", finding.evidence);
    entries.push_back(std::move(value));
  }
  return entries;
}

void print_table(const base::CsvTable& table) {
  std::vector<std::size_t> width;
  for (const auto& name : table.columns) width.push_back(name.size());
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  const auto print_row = [&width](const std::vector<std::string>& cells) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const int padding = static_cast<int>(width[i]);
      // Names to the left, numbers to the right.
      std::printf(i == 0 ? "%-*s" : "  %*s", padding, cells[i].c_str());
    }
    std::printf("\n");
  };
  print_row(table.columns);
  for (const auto& row : table.rows) print_row(row);
}

void print_json(const base::Value& value) {
  std::printf("%s\n", base::to_json(value).c_str());
}

}  // namespace furrow::cli
