#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/terminal.h"
#include "furrow/base/text.h"
#include "furrow/project/jobs.h"

namespace furrow::cli {
namespace {

struct Arguments {
  std::string out;
  std::string method = "field";
  std::string steps;
  std::vector<std::string> images;
  int threads = 0;
  bool no_overlays = false;
  bool json = false;
};

void print_rows(const std::vector<project::RowsOfImage>& results) {
  base::CsvTable table;
  table.columns = {"image", "status", "rows", "half width px", "confidence", "ms"};
  for (const auto& one : results) {
    std::string half_width;
    for (const auto& row : one.lines.rows) {
      if (row.index == 0 && row.half_width_px) half_width = base::format_fixed(row.half_width_px->value, 1);
    }
    table.rows.push_back({one.image, one.lines.status, std::to_string(one.lines.rows.size()), half_width,
                          base::format_fixed(one.lines.confidence, 2),
                          base::format_fixed(one.elapsed_ms, 1)});
  }
  print_table(table);
  for (const auto& one : results) {
    if (!one.lines.ok()) std::fprintf(stderr, "%s: %s\n", one.image.c_str(), one.lines.reason.c_str());
  }
}

int find_rows(const Arguments& arguments) {
  project::RowsJobOptions options;
  options.detect.method = arguments.method == "thesis" ? rows::Method::thesis : rows::Method::field;
  options.overlays = !arguments.no_overlays;
  if (!arguments.steps.empty()) options.steps = arguments.steps;
  project::JobOptions job{arguments.threads, progress_on_stderr()};
  const std::vector<std::filesystem::path> images(arguments.images.begin(), arguments.images.end());
  const auto results = project::rows_job(images, arguments.out, options, job);
  if (!results.ok()) return fail(results.error());
  if (arguments.json) {
    print_json(project::rows_document(*results));
  } else {
    print_rows(*results);
  }
  for (const auto& one : *results) {
    if (one.lines.width > 0) return kDone;
  }
  return fail({"no_picture_read", arguments.out,
               "none of the " + std::to_string(results->size()) + " pictures could be read", "", ""});
}

}  // namespace

void add_rows(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("rows", "Find the crop rows in pictures");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("images", arguments->images, "pictures, or folders of them")->required();
  command->add_option("--out", arguments->out, "folder for rows.json and overlays/")->required();
  command->add_option("--method", arguments->method, "field (default) or thesis")
      ->check(CLI::IsMember({"field", "thesis"}))
      ->capture_default_str();
  command->add_option("--steps", arguments->steps,
                      "folder for the pictures of each step of the thesis method");
  command->add_option("--threads", arguments->threads, "0: one per core")->check(zero_or_more());
  command->add_flag("--no-overlays", arguments->no_overlays, "write rows.json only");
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer("Example: furrow rows --out out/rows flight/*.jpg");
  command->callback([&action, arguments] { action = [arguments] { return find_rows(*arguments); }; });
}

}  // namespace furrow::cli
