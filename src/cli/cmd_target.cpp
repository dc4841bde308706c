#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/terminal.h"
#include "furrow/base/text.h"
#include "furrow/project/target_jobs.h"
#include "furrow/stats/robust.h"

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

struct CheckArguments {
  std::string board;
  std::vector<std::string> images;
  int threads = 0;
  bool json = false;
};

/// Median of the corners' sigmas, in px; empty when not found.
std::string sigma_word(const target::BoardDetection& one) {
  return one.found ? base::format_fixed(stats::median(one.sigma_px), 3) : "";
}

base::Value check_value(const target::BoardCheck& check) {
  base::Array pictures;
  for (const target::BoardDetection& one : check.detections) {
    base::Value entry;
    entry.set("image", one.image);
    entry.set("found", one.found);
    entry.set("corners", one.corners_px.size());
    entry.set("sigma_px", one.found ? base::Value(stats::median(one.sigma_px)) : base::Value());
    entry.set("reason", one.reason);
    pictures.push_back(std::move(entry));
  }
  base::Value out;
  out.set("fits", check.fits);
  out.set("found", check.found);
  out.set("verdict", check.verdict);
  out.set("pictures", std::move(pictures));
  return out;
}

int check(const CheckArguments& arguments) {
  const std::vector<std::filesystem::path> images(arguments.images.begin(), arguments.images.end());
  const auto checked =
      project::check_board_job(arguments.board, images, {arguments.threads, progress_on_stderr()});
  if (!checked.ok()) return fail(checked.error());
  if (arguments.json) {
    print_json(check_value(*checked));
  } else {
    base::CsvTable table;
    table.columns = {"picture", "corners", "sigma_px", "why not"};
    for (const target::BoardDetection& one : checked->detections)
      table.rows.push_back({one.image, std::to_string(one.corners_px.size()), sigma_word(one), one.reason});
    print_table(table);
  }
  std::fflush(stdout);  // the sentence comes last
  std::fprintf(stderr, "%s: %s\n", arguments.board.c_str(), checked->verdict.c_str());
  return checked->fits ? kDone : kFindingFailed;
}

void add_check(CLI::App& target, Action& action) {
  CLI::App* command = target.add_subcommand("check", "Whether a board file describes the board in pictures");
  auto arguments = std::make_shared<CheckArguments>();
  command->add_option("board", arguments->board, "board.yaml")->required();
  command->add_option("images", arguments->images, "pictures of the board, or folders of them")->required();
  command->add_option("--threads", arguments->threads, "0: one per core")->check(zero_or_more());
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer("Example: furrow target check calib_targets/opencv-9x6-25mm.yaml boards/*.jpg");
  command->callback([&action, arguments] { action = [arguments] { return check(*arguments); }; });
}

}  // namespace

void add_target(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("target", "Calibration boards: draw one to print, check one against pictures");
  command->require_subcommand(1);
  command->footer("Example: furrow target sheet calib_targets/opencv-9x6-25mm.yaml --paper A4 -o board.pdf");
  add_sheet(*command, action);
  add_check(*command, action);
}

}  // namespace furrow::cli
