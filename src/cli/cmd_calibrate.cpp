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
  std::string target;
  double square_mm = 0.0;
  std::string out;
  std::string model = "opencv5";
  std::vector<std::string> images;
  double flight_height_m = project::CalibrateJobOptions{}.flight_height_m;
  std::string squares = "square";
  double corner_outliers = 0.0, view_outliers = 0.0;
  bool weigh_corners = false;
  bool square_pixels = false;
  bool warp = false;
  int threads = 0;
  bool json = false;
};

void print_camera(const project::CalibrateOutcome& outcome, const std::string& out) {
  const Camera& camera = outcome.calibration.camera;
  base::CsvTable table;
  table.columns = {"parameter", "value", "sigma"};
  const char* names[] = {"fx_px", "fy_px", "cx_px", "cy_px"};
  const double values[] = {camera.fx, camera.fy, camera.cx, camera.cy};
  for (int i = 0; i < 4; ++i) {
    const bool known = camera.covariance.rows() > i;
    table.rows.push_back({names[i], base::format_fixed(values[i], 3),
                          known ? base::format_fixed(std::sqrt(camera.covariance(i, i)), 3) : ""});
  }
  table.rows.push_back({"rms_px", base::format_fixed(outcome.calibration.rms_px, 4), ""});
  print_table(table);
  if (!outcome.calibration.model_choice.empty())
    std::printf("%s\n", outcome.calibration.model_choice.c_str());
  std::printf("report: %s/report.html\n", out.c_str());
}

base::Value json_of(const project::CalibrateOutcome& outcome, const std::string& out) {
  const Camera& camera = outcome.calibration.camera;
  base::Value value;
  value.set("out", out);
  value.set("model", camera::model_name(camera.model));
  value.set("fx", camera.fx);
  value.set("fy", camera.fy);
  value.set("cx", camera.cx);
  value.set("cy", camera.cy);
  value.set("rms_px", outcome.calibration.rms_px);
  if (!outcome.calibration.model_choice.empty()) value.set("model_choice", outcome.calibration.model_choice);
  value.set("findings", findings_value(outcome.findings));
  return value;
}

Result<project::CalibrateJobOptions> job_options(const Arguments& arguments) {
  project::CalibrateJobOptions options;
  options.choose_model = arguments.model == "auto";
  options.flight_height_m = arguments.flight_height_m;
  options.solve.square_pixels = arguments.square_pixels;
  options.solve.solve_aspect = arguments.squares == "unknown_aspect";
  options.solve.solve_warp = arguments.warp;
  options.solve.corner_outlier_sigmas = arguments.corner_outliers;
  options.solve.view_outlier_ratio = arguments.view_outliers;
  options.solve.use_corner_sigma = arguments.weigh_corners;
  if (options.choose_model) return options;
  const auto model = camera::model_from_name(arguments.model);
  if (!model)
    return Error{"bad_option", "--model", "'" + arguments.model + "'", "auto, " + camera::model_names(), ""};
  options.solve.model = *model;
  return options;
}

int calibrate(const Arguments& arguments) {
  const auto options = job_options(arguments);
  if (!options.ok()) return fail(options.error());
  project::JobOptions job{arguments.threads, progress_on_stderr()};
  const std::vector<std::filesystem::path> images(arguments.images.begin(), arguments.images.end());
  const auto outcome = project::calibrate_job(images, {arguments.target, 1e-3 * arguments.square_mm},
                                              *options, arguments.out, job);
  if (!outcome.ok()) return fail(outcome.error());
  if (arguments.json) {
    print_json(json_of(*outcome, arguments.out));
  } else {
    print_camera(*outcome, arguments.out);
  }
  return print_findings(outcome->findings);
}

/// What is solved beside the lens, and which corners count.
void add_solve_options(CLI::App* command, Arguments& arguments) {
  command->add_flag("--square-pixels", arguments.square_pixels, "one focal length: fx = fy");
  command->add_flag("--warp", arguments.warp, "solve how far the board bends, as mrcal does");
  command
      ->add_option(
          "--squares", arguments.squares,
          "square, or unknown_aspect: solve height / width of the board's squares, with fx = fy (boards "
          "on monitors, stretched prints)")
      ->check(CLI::IsMember({"square", "unknown_aspect"}))
      ->capture_default_str();
  command
      ->add_option(
          "--corner-outliers", arguments.corner_outliers,
          "leave out corners farther from their projection than this many times the noise; 5 is usual, "
          "0 keeps all")
      ->check(zero_or_more())
      ->capture_default_str();
  command
      ->add_option("--view-outliers", arguments.view_outliers,
                   "leave out pictures whose RMS is over this many times the median picture's; 3 is usual, 0 "
                   "keeps all")
      ->check(zero_or_more())
      ->capture_default_str();
  command->add_flag("--weigh-corners", arguments.weigh_corners,
                    "weigh every corner by the sigma that its picture allows, instead of all alike");
}

}  // namespace

void add_calibrate(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("calibrate", "Calibrate a camera from pictures of a checkerboard");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("images", arguments->images, "pictures of the board, or folders of them")->required();
  command->add_option("--target", arguments->target,
                      "board.yaml; without it the corners of a checkerboard are counted");
  command
      ->add_option("--square-mm", arguments->square_mm,
                   "side of a square of a board without a file, millimetres")
      ->check(between(1.0, 999.0))
      ->excludes("--target");
  command->add_option("--out", arguments->out, "folder for the results")->required();
  command->add_option("--model", arguments->model, "auto (by cross-validation), " + camera::model_names())
      ->capture_default_str();
  add_solve_options(command, *arguments);
  command
      ->add_option("--flight-height", arguments->flight_height_m,
                   "above the crop, m: for the map of the height error")
      ->check(above_zero())
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "0: one per core")->check(zero_or_more());
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer(
      "Example: furrow calibrate --target calib_targets/opencv-9x6-25mm.yaml --out out/cam boards");
  command->callback([&action, arguments] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace furrow::cli
