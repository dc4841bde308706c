#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "furrow/base/text.h"
#include "furrow/project/target_jobs.h"

namespace furrow::cli {
namespace {

struct SheetArguments {
  std::string board;
  std::string paper = "A4";
  std::string out;
  double dpi = 300.0;
};

std::string in_mm(double metres) {
  return base::format_fixed(1e3 * metres, 1);
}

int sheet(const SheetArguments& arguments) {
  const auto drawn = project::sheet_job(arguments.board, arguments.paper, arguments.out, arguments.dpi);
  if (!drawn.ok()) return fail(drawn.error());
  std::printf("%s: %s x %s mm\n", arguments.out.c_str(), in_mm(drawn->width_m).c_str(),
              in_mm(drawn->height_m).c_str());
  std::fprintf(stderr,
               "Print it at 100 %% (not fitted to the page), measure the bar and a square, and correct the "
               "board file if "
               "they differ.\n");
  return kDone;
}

void add_sheet(CLI::App& target, Action& action) {
  CLI::App* command = target.add_subcommand("sheet", "Draw a board to print, true to scale");
  auto arguments = std::make_shared<SheetArguments>();
  command->add_option("board", arguments->board, "board.yaml")->required();
  command
      ->add_option("--paper", arguments->paper, "A0 to A6, letter, legal, tabloid, or a size like 600x400mm")
      ->capture_default_str();
  command->add_option("-o,--out", arguments->out, "file to write: .pdf, .svg or .png")->required();
  command->add_option("--dpi", arguments->dpi, "dots per inch of a PNG")->capture_default_str();
  command->footer(
      "Example: furrow target sheet calib_targets/charuco-11x8-22mm.yaml --paper A4 -o board.pdf");
  command->callback([&action, arguments] { action = [arguments] { return sheet(*arguments); }; });
}

}  // namespace

void add_target(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("target", "Calibration boards: draw one to print, check one against pictures");
  command->require_subcommand(1);
  command->footer("Example: furrow target sheet calib_targets/opencv-9x6-25mm.yaml --paper A4 -o board.pdf");
  add_sheet(*command, action);
}

}  // namespace furrow::cli
