#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/run_summary.h"
#include "cli/terminal.h"
#include "furrow/project/jobs.h"

namespace furrow::cli {

void add_demo(CLI::App& app, Action& action) {
  struct Arguments {
    std::string out;
    int threads = 0;
    bool json = false;
  };
  CLI::App* command =
      app.add_subcommand("demo", "Render a board session and a vineyard flight, then measure them");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("out,--out", arguments->out, "folder for the results")->required();
  command->add_option("--threads", arguments->threads, "0: one per core")->check(zero_or_more());
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer("Example: furrow demo out/demo");
  command->callback([&action, arguments] {
    action = [arguments] {
      const auto outcome = project::demo_job(arguments->out, {arguments->threads, progress_on_stderr()});
      if (!outcome.ok()) return fail(outcome.error());
      return print_run(*outcome, arguments->json);
    };
  });
}

}  // namespace furrow::cli
