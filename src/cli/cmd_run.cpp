#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/run_summary.h"
#include "cli/terminal.h"
#include "furrow/audit/truth.h"
#include "furrow/base/text.h"
#include "furrow/project/jobs.h"

namespace furrow::cli {
namespace {

struct Arguments {
  std::string project;
  std::string out;
  std::string truth;
  int threads = 0;
  bool json = false;
};

/// The measured table for a terminal: true heights beside the estimates where there is a truth.
base::CsvTable heights_table(const std::vector<audit::ShotRecord>& records, bool with_truth) {
  const auto number = [](double value) {
    return std::isfinite(value) ? base::format_fixed(value, 2) : std::string("-");
  };
  base::CsvTable table;
  table.columns = {"shot",      "log m",   "thesis m",     "spacing m",
                   "refined m", "sigma m", "shot alone m", "fused m"};
  if (with_truth) table.columns.push_back("true m");
  table.columns.push_back("status");
  for (const auto& r : records) {
    auto& row = table.rows.emplace_back(std::vector<std::string>{
        r.shot_id, number(r.height_takeoff_m), number(r.above_canopy_thesis_m.value),
        number(r.above_canopy_spacing_m.value), number(r.above_canopy_refined_m.value),
        number(r.above_canopy_refined_m.sigma), number(r.above_canopy_shot_m.value),
        number(r.above_canopy_fused_m.value)});
    if (with_truth) row.push_back(number(r.truth_above_canopy_m));
    row.push_back(r.status);
  }
  return table;
}

base::Value comparison_value(const std::vector<audit::TruthComparison>& comparison) {
  base::Array lines;
  for (const auto& line : comparison) {
    base::Value entry;
    entry.set("method", line.method);
    entry.set("shots", line.shots);
    entry.set("mean_error_m", line.mean_error_m);
    entry.set("sd_error_m", line.sd_error_m);
    entry.set("rmse_m", line.rmse_m);
    entry.set("rmse_share", line.rmse_share);
    entry.set("within_1_sigma", line.within_1_sigma);
    entry.set("within_2_sigma", line.within_2_sigma);
    lines.push_back(std::move(entry));
  }
  return lines;
}

base::Value json_of(const project::RunOutcome& outcome) {
  base::Value value;
  value.set("report", outcome.report.string());
  value.set("shots", outcome.records.size());
  value.set("findings", findings_value(outcome.findings));
  value.set("truth", comparison_value(audit::compare_with_truth(outcome.records)));
  value.set("fusion_truth", comparison_value(outcome.fusion_truth));
  if (outcome.rise_told_m.usable()) {
    value.set("outline_rise_m", outcome.rise_told_m.value);
    value.set("outline_rise_sigma_m", outcome.rise_told_m.sigma);
  }
  return value;
}

int run(const Arguments& arguments) {
  const auto project = project::read_project(arguments.project);
  if (!project.ok()) return fail(project.error());
  std::optional<std::filesystem::path> truth;
  if (!arguments.truth.empty()) truth = arguments.truth;
  const auto outcome =
      project::run_job(*project, arguments.out, {arguments.threads, progress_on_stderr()}, truth);
  if (!outcome.ok()) return fail(outcome.error());
  return print_run(*outcome, arguments.json);
}

}  // namespace

int print_run(const project::RunOutcome& outcome, bool json) {
  for (const std::string& warning : outcome.warnings) std::fprintf(stderr, "%s\n", warning.c_str());
  if (json) {
    print_json(json_of(outcome));
    return print_findings(outcome.findings);
  }
  const auto comparison = audit::compare_with_truth(outcome.records);
  std::printf("Heights above the canopy; the log's above take-off\n");
  print_table(heights_table(outcome.records, !comparison.empty()));
  if (!comparison.empty()) {
    std::printf("\n");
    print_table(audit::comparison_table(comparison));
  }
  if (!outcome.fusion_truth.empty()) {
    std::printf("\nFused heights, all sources and each switched off\n");
    print_table(audit::comparison_table(outcome.fusion_truth));
  }
  if (!outcome.rise_words.empty()) std::printf("\n%s\n", outcome.rise_words.c_str());
  const int code = print_findings(outcome.findings);
  std::printf("\nreport: %s\n", outcome.report.c_str());
  return code;
}

void add_run(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "run", "Measure a flight: a project's pictures and log to heights, figures and a report");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("project", arguments->project, "project.yaml, or the folder that holds it")->required();
  command->add_option("--out", arguments->out, "folder for the results")->required();
  command->add_option("--truth", arguments->truth,
                      "truth.csv of a simulated flight, compared with the finished estimates");
  command->add_option("--threads", arguments->threads, "0: one per core")->check(zero_or_more());
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer("Example: furrow run projects/mini-se-corn/project.yaml --out out/corn");
  command->callback([&action, arguments] {
    if (std::filesystem::is_directory(arguments->project)) arguments->project += "/project.yaml";
    action = [arguments] { return run(*arguments); };
  });
}

}  // namespace furrow::cli
