#pragma once
#include <functional>
#include <memory>

namespace CLI {
class App;
}

namespace furrow::cli {

/// Exit codes of every command.
enum ExitCode {
  kDone = 0,
  kFindingFailed = 1,  ///< done, but a finding failed
  kBadInput = 2,       ///< bad usage or bad input
  kInternalFault = 3,
};

/// What a parsed command line asks for; returns the exit code.
using Action = std::function<int()>;

/// Each adds one subcommand; parsing it sets `action`.
void add_altitude(CLI::App& app, Action& action);
void add_calibrate(CLI::App& app, Action& action);
void add_camera(CLI::App& app, Action& action);
void add_demo(CLI::App& app, Action& action);
void add_follow(CLI::App& app, Action& action);
void add_rows(CLI::App& app, Action& action);
void add_run(CLI::App& app, Action& action);
void add_simulate(CLI::App& app, Action& action);
void add_target(CLI::App& app, Action& action);
void add_version(CLI::App& app, Action& action);

}  // namespace furrow::cli
