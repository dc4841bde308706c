#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/terminal.h"
#include "furrow/base/text.h"
#include "furrow/geom/angles.h"
#include "furrow/project/camera_job.h"

namespace furrow::cli {
namespace {

using base::format_fixed;

struct Arguments {
  std::string camera, other, out, format, target;
  std::vector<double> sensor_mm;
  std::vector<std::string> images;
  project::ValidateLimits limits;
  int threads = 0;
  bool json = false;
};

std::vector<std::filesystem::path> paths(const std::vector<std::string>& names) {
  return {names.begin(), names.end()};
}

std::string degrees(const std::optional<double>& angle_rad) {
  return angle_rad ? format_fixed(geom::rad_to_deg(*angle_rad), 2) : "no ray at the border";
}

void print_shown(const project::CameraShown& shown) {
  const Camera& camera = shown.camera;
  const camera::Description& d = shown.description;
  base::CsvTable table;
  table.columns = {"quantity", "value"};
  const auto row = [&](const std::string& name, const std::string& value) {
    table.rows.push_back({name, value});
  };
  row("model", camera::model_name(camera.model));
  row("pictures / px", std::to_string(camera.width) + " x " + std::to_string(camera.height));
  const std::vector<std::string> names = camera::intrinsic_names(camera);
  const Eigen::VectorXd p = camera::intrinsics(camera);
  const bool splined = camera.model == camera::CameraModel::splined_stereographic;
  for (std::size_t i = 0; i < (splined ? 4 : names.size()); ++i)
    row(names[i] + (i < 4 ? " / px" : ""), i < 4 ? format_fixed(p[static_cast<Eigen::Index>(i)], 3)
                                                 : base::format_double(p[static_cast<Eigen::Index>(i)]));
  if (splined)
    row("knots", std::to_string(camera.spline.columns) + " x " + std::to_string(camera.spline.rows) +
                     " over " + std::to_string(camera.spline.fov_x_deg) + " deg");
  row("focal length on the axis / px",
      format_fixed(d.focal_px.x(), 3) + ", " + format_fixed(d.focal_px.y(), 3));
  if (shown.focal_mm) row("focal length / mm", format_fixed(*shown.focal_mm, 3));
  if (shown.ideal_fov) {
    row("FOV of an ideal lens, h, v, diagonal / deg", degrees(shown.ideal_fov->horizontal_rad) + ", " +
                                                          degrees(shown.ideal_fov->vertical_rad) + ", " +
                                                          degrees(shown.ideal_fov->diagonal_rad));
  }
  row("FOV with distortion, h, v, diagonal / deg",
      degrees(d.horizontal_rad) + ", " + degrees(d.vertical_rad) + ", " + degrees(d.diagonal_rad));
  row("distortion at the farthest corner / px", d.corner_distortion_px
                                                    ? format_fixed(*d.corner_distortion_px, 2)
                                                    : "none given: no ray, or one at 60 deg and more");
  row("part of the picture without an inverse",
      d.inverse_reach_px ? format_fixed(100.0 * d.without_inverse, 1) + " %, from " +
                               format_fixed(*d.inverse_reach_px, 0) + " px from the principal point on"
                         : "none");
  if (!camera.provenance.empty()) row("made", camera.provenance);
  print_table(table);
}

int show(const Arguments& arguments) {
  std::optional<project::SensorSize> sensor;
  if (!arguments.sensor_mm.empty()) sensor = {arguments.sensor_mm[0], arguments.sensor_mm[1]};
  const auto shown = project::show_camera(arguments.camera, sensor);
  if (!shown.ok()) return fail(shown.error());
  if (arguments.json) {
    print_json(project::to_value(*shown));
  } else {
    print_shown(*shown);
  }
  return kDone;
}

/// The format that was named, or the one of the file's ending.
Result<camera::CameraFormat> wanted_format(const Arguments& arguments) {
  const std::string end = base::to_lower(std::filesystem::path(arguments.out).extension().string());
  const std::string name = !arguments.format.empty() ? arguments.format
                           : end == ".cameramodel"   ? "mrcal"
                           : end == ".cam"           ? "pix4d"
                           : end == ".xml"           ? "metashape"
                                                     : "";
  if (const auto format = camera::format_from_name(name)) return *format;
  return Error{"bad_option", "--format",
               name.empty() ? "none given, and '" + end + "' does not say it" : "'" + name + "'",
               camera::format_names(), ""};
}

int convert(const Arguments& arguments) {
  const auto format = wanted_format(arguments);
  if (!format.ok()) return fail(format.error());
  camera::ExportOptions options;
  if (!arguments.sensor_mm.empty()) options.sensor_width_mm = arguments.sensor_mm[0];
  const Status status = project::convert_camera(arguments.camera, arguments.out, *format, options);
  if (!status.ok()) return fail(status.error());
  if (arguments.json) {
    base::Value value;
    value.set("out", arguments.out);
    print_json(value);
  } else {
    std::printf("written and read back to the same pixels: %s\n", arguments.out.c_str());
  }
  return kDone;
}

int undistort(const Arguments& arguments) {
  const auto outcome = project::undistort_pictures(arguments.camera, paths(arguments.images), arguments.out,
                                                   {arguments.threads, progress_on_stderr()});
  if (!outcome.ok()) return fail(outcome.error());
  for (const std::string& sentence : outcome->failed) std::fprintf(stderr, "furrow: %s\n", sentence.c_str());
  if (arguments.json) {
    print_json(project::to_value(*outcome));
  } else {
    std::printf(
        "%zu pictures, mask.png and camera.yaml (a pinhole, fx %.2f fy %.2f px) in %s; %.1f %% of each is "
        "masked\n",
        outcome->written.size(), outcome->pinhole.fx, outcome->pinhole.fy, arguments.out.c_str(),
        100.0 * outcome->masked_share);
  }
  return outcome->failed.empty() ? kDone : kFindingFailed;
}

void print_difference(const project::DiffOutcome& outcome) {
  const camera::CameraDifference& d = outcome.difference;
  base::CsvTable table;
  table.columns = {"quantity", "value"};
  const auto row = [&](const std::string& name, const std::string& value) {
    table.rows.push_back({name, value});
  };
  row("RMS difference / px", format_fixed(d.rms_px, 4));
  row("largest difference / px", format_fixed(d.largest_px, 4));
  row("RMS that the covariances predict / px", std::isfinite(d.expected_rms_px)
                                                   ? format_fixed(d.expected_rms_px, 4)
                                                   : "not known: a file holds no covariance");
  row("turn taken out / deg", format_fixed(geom::rad_to_deg(d.b_from_a_rad.norm()), 4));
  row("focal length, B over A / %", format_fixed(outcome.focal_percent, 3));
  row("part of the picture compared / %", format_fixed(100.0 * d.compared_share, 1));
  print_table(table);
}

int diff(const Arguments& arguments) {
  const auto out =
      arguments.out.empty() ? std::optional<std::filesystem::path>() : std::filesystem::path(arguments.out);
  const auto outcome = project::diff_cameras(arguments.camera, arguments.other, out);
  if (!outcome.ok()) return fail(outcome.error());
  if (arguments.json) {
    print_json(project::to_value(*outcome));
  } else {
    print_difference(*outcome);
  }
  return kDone;
}

int validate(const Arguments& arguments) {
  const auto outcome = project::validate_camera(arguments.camera, paths(arguments.images), arguments.target,
                                                arguments.limits, {arguments.threads, progress_on_stderr()});
  if (!outcome.ok()) return fail(outcome.error());
  if (arguments.json) {
    print_json(project::to_value(*outcome));
  } else {
    base::CsvTable table;
    table.columns = {"picture", "RMS / px", "why not"};
    for (const calib::View& view : outcome->views) {
      table.rows.push_back({std::filesystem::path(view.image).filename().string(),
                            view.used ? format_fixed(view.rms_px, 3) : "", view.reason});
    }
    print_table(table);
    std::printf("%s\n", outcome->sentence.c_str());
  }
  return outcome->still_good ? kDone : kFindingFailed;
}

using Job = int (*)(const Arguments&);

/// A subcommand with what all have.
CLI::App* add_job(CLI::App* parent, Action& action, const std::shared_ptr<Arguments>& arguments,
                  const std::string& name, const std::string& words, const std::string& example, Job job) {
  CLI::App* command = parent->add_subcommand(name, words);
  command
      ->add_option("camera", arguments->camera,
                   "camera file of any format, or a DJI picture that states its own")
      ->required();
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer("Example: furrow camera " + name + " " + example);
  command->callback([&action, arguments, job] { action = [arguments, job] { return job(*arguments); }; });
  return command;
}

void add_pictures(CLI::App* command, Arguments& arguments) {
  command->add_option("images", arguments.images, "pictures, or folders of them")->required();
  command->add_option("--threads", arguments.threads, "0: one per core")->check(zero_or_more());
}

void add_sensor(CLI::App* command, Arguments& arguments, const std::string& words) {
  command->add_option("--sensor-mm", arguments.sensor_mm, words)->expected(2)->check(above_zero());
}

}  // namespace

void add_camera(CLI::App& app, Action& action) {
  CLI::App* command =
      app.add_subcommand("camera", "Show, convert, compare and check camera files, and undistort pictures");
  command->require_subcommand(1);
  command->footer("Example: furrow camera show out/cam/camera.cameramodel --sensor-mm 13.2 8.8");
  auto arguments = std::make_shared<Arguments>();
  CLI::App* shown = add_job(command, action, arguments, "show",
                            "Focal length, field of view, distortion, where no inverse is",
                            "camera.yaml --sensor-mm 13.2 8.8", show);
  add_sensor(shown, *arguments, "width and height of the sensor, mm: for the focal length in mm");

  CLI::App* converted = add_job(command, action, arguments, "convert",
                                "Write a camera for another program, read back and checked",
                                "camera.cameramodel -o cameras.txt --format colmap", convert);
  converted->add_option("-o,--out", arguments->out, "file to write")->required();
  converted->add_option("--format", arguments->format,
                        camera::format_names() + " (default: by the ending of the file)");
  add_sensor(converted, *arguments,
             "width and height of the sensor, mm, for formats in mm (default 36 wide)");

  CLI::App* undistorted = add_job(command, action, arguments, "undistort",
                                  "Pictures as a pinhole of the same focal length sees them",
                                  "camera.yaml frames/*.jpg --out out/pinhole", undistort);
  add_pictures(undistorted, *arguments);
  undistorted->add_option("--out", arguments->out, "folder for pictures, mask.png and camera.yaml")
      ->required();

  CLI::App* compared =
      add_job(command, action, arguments, "diff", "How far two cameras put the same direction apart",
              "before.cameramodel after.cameramodel --out out/diff", diff);
  compared->add_option("other", arguments->other, "the camera to compare with")->required();
  compared->add_option("--out", arguments->out, "folder for a map of the difference");

  CLI::App* validated = add_job(command, action, arguments, "validate",
                                "Whether an old calibration still fits new pictures of a board",
                                "camera.yaml boards/*.jpg --target board.yaml", validate);
  add_pictures(validated, *arguments);
  validated->add_option("--target", arguments->target, "board.yaml")->required();
  validated
      ->add_option("--limit-px", arguments->limits.added_px_per_1280,
                   "misfit that the old lens may add, px per 1280 px of width")
      ->check(above_zero())
      ->capture_default_str();
  validated
      ->add_option("--limit-focal-percent", arguments->limits.focal_percent,
                   "change of the focal length that is allowed, %")
      ->check(above_zero())
      ->capture_default_str();
}

}  // namespace furrow::cli
