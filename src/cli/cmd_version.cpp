#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "furrow/base/version.h"

namespace furrow::cli {

void add_version(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("version", "Print the version");
  command->footer("Example: furrow version");
  command->callback([&action] {
    action = [] {
      std::printf("furrow %s\n", base::version().c_str());
      return kDone;
    };
  });
}

}  // namespace furrow::cli
