#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "cli/commands.h"
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

/// Pictures and figures free and ask for tens of megabytes by turns; handed back to the system, each page
/// would have to be mapped and cleared anew (half of all page faults of a calibration).
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kKept_bytes = 1 << 30, kAtOnce_bytes = 64 << 20;
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, kKept_bytes);
  mallopt(M_TOP_PAD, kAtOnce_bytes);
#endif
}

int run(int argc, char** argv) {
  CLI::App app{"Calibration and photogrammetry for drones that fly over row crops"};
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done; 1 done, but a finding failed; 2 bad usage or bad input; 3 an internal fault.\n"
      "Try: furrow demo out/demo");
  furrow::cli::Action action;
  furrow::cli::add_demo(app, action);
  furrow::cli::add_simulate(app, action);
  furrow::cli::add_calibrate(app, action);
  furrow::cli::add_camera(app, action);
  furrow::cli::add_rows(app, action);
  furrow::cli::add_follow(app, action);
  furrow::cli::add_run(app, action);
  furrow::cli::add_target(app, action);
  furrow::cli::add_altitude(app, action);
  furrow::cli::add_version(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& problem) {
    return app.exit(problem) == 0 ? furrow::cli::kDone : furrow::cli::kBadInput;
  }
  const int code = action();
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    std::fputs("furrow: standard output cannot be written (disk full, or its reader is gone)\n", stderr);
    return furrow::cli::kBadInput;
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  // A file over the size limit then fails like a full disk: with a message, and the half file removed.
  std::signal(SIGXFSZ, SIG_IGN);
  keep_freed_memory();
  try {
    return run(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("furrow: out of memory\n", stderr);
  } catch (const std::exception& problem) {
    std::fprintf(stderr, "furrow: internal fault: %s\n", problem.what());
  }
  return furrow::cli::kInternalFault;
}
