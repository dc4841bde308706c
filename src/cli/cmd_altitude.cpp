#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/terminal.h"
#include "furrow/base/text.h"
#include "furrow/camera/model_files.h"
#include "furrow/geom/angles.h"
#include "furrow/project/plan_job.h"

namespace furrow::cli {
namespace {

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// A length with its sigma as the command line gives it.
struct Length {
  double value = kNotGiven, sigma = kNotGiven;

  /// Over what a project says; a sigma left out is the given share of the value.
  void over(Estimate& known, double default_share) const {
    if (std::isnan(value) && !std::isnan(sigma)) known.sigma = sigma;
    if (!std::isnan(value)) known = {value, std::isnan(sigma) ? default_share * value : sigma, 1};
  }
};

struct Arguments {
  std::string camera, project, out;
  project::PlanLens lens;
  std::vector<int> size;
  Length spacing, half_width, row_height, foliage_depth;
  double above_canopy_m = kNotGiven, above_ground_m = kNotGiven;
  double pitch_deg = kNotGiven, pitch_sigma_deg = kNotGiven;
  double edge_sigma_px = altitude::PlanOptions{}.edge_sigma_px;
  bool json = false;
};

Result<project::PlanRequest> request_of(Arguments arguments) {
  project::PlanRequest request;
  request.options.edge_sigma_px = arguments.edge_sigma_px;
  if (!arguments.project.empty()) {
    FURROW_TRY(const project::PlanSource source,
               project::plan_source(arguments.project, {0, progress_on_stderr()}));
    request.camera = source.camera;
    request.field = source.field;
    request.options.pitch_sigma_rad = source.pitch_sigma_rad;
  }
  if (!std::isnan(arguments.pitch_sigma_deg))
    request.options.pitch_sigma_rad = geom::deg_to_rad(arguments.pitch_sigma_deg);
  const bool states_lens = arguments.lens.focal_px > 0.0 || arguments.lens.focal_mm > 0.0;
  if (!arguments.camera.empty()) {
    FURROW_TRY(request.camera, camera::read_camera(arguments.camera));
  } else if (arguments.project.empty() || states_lens) {
    if (arguments.size.size() == 2) {
      arguments.lens.width_px = arguments.size[0];
      arguments.lens.height_px = arguments.size[1];
    }
    FURROW_TRY(request.camera, project::plan_camera(arguments.lens));
  }
  arguments.spacing.over(request.field.row_spacing_m, project::kDefaultSpacingSigmaShare);
  arguments.half_width.over(request.field.half_width_m, project::kDefaultHalfWidthSigmaShare);
  arguments.row_height.over(request.field.row_height_m, project::kDefaultRowHeightSigmaShare);
  arguments.foliage_depth.over(request.field.foliage_depth_m, project::kDefaultFoliageDepthSigmaShare);
  request.pose.pitch_rad = geom::deg_to_rad(arguments.pitch_deg);
  request.pose.height_above_canopy_m = arguments.above_canopy_m;
  if (!std::isnan(arguments.above_ground_m)) {
    if (!request.field.row_height_m.usable()) {
      return Error{"no_row_height", "--height-above-ground", "the height of the rows is not known",
                   "--row-height, or --height-above-canopy", ""};
    }
    request.pose.height_above_canopy_m = arguments.above_ground_m - request.field.row_height_m.value;
  }
  return request;
}

base::Value shot_value(const altitude::PlannedShot& shot) {
  base::Value value;
  value.set("above_canopy_m", shot.pose.height_above_canopy_m);
  value.set("pitch_deg", geom::rad_to_deg(shot.pose.pitch_rad));
  value.set("sigma_m", shot.height_above_canopy_m.sigma);
  value.set("cross_track_sigma_m", shot.cross_track_sigma_m);
  value.set("pitch_sigma_deg", geom::rad_to_deg(shot.pitch_sigma_rad));
  value.set("rows_used", shot.rows_used);
  base::Value budget;
  for (const altitude::SigmaShare& share : shot.height_budget) budget.set(share.cause, share.sigma_m);
  value.set("sigma_by_cause_m", std::move(budget));
  return value;
}

base::Value optional_value(const std::optional<altitude::PlannedShot>& shot) {
  return shot ? shot_value(*shot) : base::Value();
}

base::Value json_of(const project::PlanOutcome& outcome) {
  base::Value value;
  value.set("planned", outcome.shot.ok() ? shot_value(*outcome.shot) : base::Value());
  value.set("reason", outcome.shot.ok() ? std::string() : outcome.shot.error().message());
  value.set("best_pitch", optional_value(outcome.advice.best_pitch));
  value.set("best_height", optional_value(outcome.advice.best_height));
  const auto list = [](const std::vector<altitude::PlannedShot>& shots) {
    base::Array entries;
    for (const auto& shot : shots) entries.push_back(shot_value(shot));
    return entries;
  };
  value.set("by_pitch", list(outcome.advice.by_pitch));
  value.set("by_height", list(outcome.advice.by_height));
  return value;
}

int plan(const Arguments& arguments) {
  const auto request = request_of(arguments);
  if (!request.ok()) return fail(request.error());
  std::optional<std::filesystem::path> out;
  if (!arguments.out.empty()) out = arguments.out;
  const auto outcome = project::plan_job(*request, out);
  if (!outcome.ok()) return fail(outcome.error());
  if (arguments.json) {
    print_json(json_of(*outcome));
  } else {
    if (outcome->shot.ok()) print_table(project::plan_budget_table(*outcome->shot));
    std::printf("\n");
    print_table(project::plan_table(*outcome));
  }
  for (const std::string& words : outcome->words) std::fprintf(stderr, "%s\n", words.c_str());
  return kDone;
}

void add_length(CLI::App& command, const std::string& name, const std::string& what, Length& length) {
  command.add_option("--" + name, length.value, what + ", m")->check(above_zero());
  command.add_option("--" + name + "-sigma", length.sigma, "its one-sigma, m")->check(zero_or_more());
}

void add_plan(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("plan", "The sigma of the height to expect of a shot, by cause, and a better pose");
  auto a = std::make_shared<Arguments>();
  command->add_option("--camera", a->camera, "camera file (.cameramodel, OpenCV YAML, calibration.json)");
  command->add_option("--project", a->project, "project.yaml to take camera and rows from");
  command->add_option("--focal-px", a->lens.focal_px, "focal length, px")->check(above_zero());
  command->add_option("--focal-mm", a->lens.focal_mm, "focal length, mm")->check(above_zero());
  command->add_option("--sensor-mm", a->lens.sensor_mm, "width of the sensor, mm")->check(above_zero());
  command->add_option("--size", a->size, "width and height of the picture, px")
      ->expected(2)
      ->check(above_zero());
  auto* above = command->add_option_group("height");
  above->add_option("--height-above-canopy", a->above_canopy_m, "m");
  above->add_option("--height-above-ground", a->above_ground_m, "m; needs the height of the rows");
  above->require_option(1);
  command->add_option("--pitch-deg", a->pitch_deg, "camera pitch, negative below the horizon")->required();
  command->add_option("--pitch-sigma-deg", a->pitch_sigma_deg, "how far the gimbal may be off (default 1)")
      ->check(above_zero());
  add_length(*command, "spacing", "distance of neighbouring rows", a->spacing);
  add_length(*command, "half-width", "half the width of a row", a->half_width);
  add_length(*command, "row-height", "height of the rows", a->row_height);
  add_length(*command, "foliage-depth", "from the top of the rows to their lowest leaves", a->foliage_depth);
  command->add_option("--edge-sigma-px", a->edge_sigma_px, "scatter of a row's edge in the picture, px")
      ->check(above_zero())
      ->capture_default_str();
  command->add_option("--out", a->out, "folder for plan.csv, plan_budget.csv and the figures");
  command->add_flag("--json", a->json, "print JSON");
  command->footer(
      "Example: furrow altitude plan --focal-mm 8.8 --sensor-mm 13.2 --size 1280 720 --height-above-ground 4 "
      "--pitch-deg -13.8 --spacing 3 --half-width 0.6 --row-height 1.7");
  command->callback([&action, a] {
    if (std::filesystem::is_directory(a->project)) a->project += "/project.yaml";
    action = [a] { return plan(*a); };
  });
}

}  // namespace

void add_altitude(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("altitude", "What a height from rows can be worth");
  command->require_subcommand(1);
  command->footer("Example: furrow altitude plan --help");
  add_plan(*command, action);
}

}  // namespace furrow::cli
