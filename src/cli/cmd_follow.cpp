#include <atomic>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "cli/commands.h"
#include "cli/numbers.h"
#include "cli/terminal.h"
#include "furrow/base/text.h"
#include "furrow/camera/model_files.h"
#include "furrow/geom/angles.h"
#include "furrow/project/follow_job.h"
#include "furrow/project/project.h"

namespace furrow::cli {
namespace {

struct Arguments {
  std::vector<std::string> sources;
  double rate_hz = 1.0;
  std::string rule = "filtered", method = "field", hold = "row", half_width = "thesis";
  std::string camera, out, by_hand, mavlink;
  double spacing_m = 0.0, half_width_m = 0.0, height_m = 0.0;
  std::optional<double> spacing_sigma_m, height_sigma_m, pitch_deg;
  double pitch_sigma_deg = 1.0;
  double speed_mps = 0.0;
  bool no_overlay = false, quiet = false;
  int threads = 0;
};

/// Set by Ctrl-C and by a polite kill: the run ends in good order, its files whole.
std::atomic<bool> stop_asked{false};

void ask_to_stop(int) {
  stop_asked = true;
}

Estimate with_default_sigma(double value, const std::optional<double>& sigma, double share) {
  return {value, sigma.value_or(share * value), 1};
}

Status read_field(const Arguments& arguments, project::FollowJobOptions& options) {
  const bool has_length =
      arguments.spacing_m > 0.0 || arguments.height_m > 0.0 || arguments.half_width_m > 0.0;
  if (arguments.camera.empty()) {
    if (has_length || arguments.pitch_deg)
      return Error{"bad_usage", "--spacing, --height", "no camera",
                   "--camera FILE beside it: metres need both", ""};
    return Done{};
  }
  if (!has_length)
    return Error{"bad_usage", "--camera", "no length",
                 "--spacing METRES, --height METRES or --half-width METRES beside it: metres need both", ""};
  FURROW_TRY(options.camera, camera::read_camera(arguments.camera));
  // Gimbals hold their roll level within about a degree.
  options.attitude.roll_rad = {0.0, geom::deg_to_rad(1.0), 1};
  if (arguments.spacing_m > 0.0) {
    options.field.row_spacing_m = with_default_sigma(arguments.spacing_m, arguments.spacing_sigma_m,
                                                     project::kDefaultSpacingSigmaShare);
  }
  if (arguments.height_m > 0.0) {
    options.height_above_canopy_m =
        with_default_sigma(arguments.height_m, arguments.height_sigma_m, project::kDefaultHeightSigmaShare);
  }
  if (arguments.half_width_m > 0.0) {
    options.field.half_width_m =
        with_default_sigma(arguments.half_width_m, {}, project::kDefaultHalfWidthSigmaShare);
  }
  if (arguments.pitch_deg) {
    options.attitude.pitch_rad = {geom::deg_to_rad(*arguments.pitch_deg),
                                  geom::deg_to_rad(arguments.pitch_sigma_deg), 1};
  }
  return Done{};
}

/// "thesis" (15 px of a picture 320 px wide), "auto", or px.
Status read_half_width(const Arguments& arguments, follow::FollowerOptions& options) {
  if (arguments.half_width == "thesis") return Done{};
  options.half_width = follow::HalfWidth::measured;
  if (arguments.half_width == "auto") return Done{};
  options.half_width = follow::HalfWidth::given;
  options.half_width_px = base::parse_double(arguments.half_width).value_or(0.0);
  if (options.half_width_px > 0.0) return Done{};
  return Error{"bad_usage", "--half-width-px", "'" + arguments.half_width + "'",
               "thesis, auto, or px above 0", ""};
}

Result<project::FollowJobOptions> job_options(const Arguments& arguments) {
  project::FollowJobOptions options;
  options.follower.rule = arguments.rule == "thesis" ? follow::Rule::thesis : follow::Rule::filtered;
  options.follower.hold = arguments.hold == "nearest" ? follow::Hold::nearest : follow::Hold::row;
  options.follower.guidance.forward_mps = arguments.speed_mps;
  options.method = arguments.method == "thesis" ? rows::Method::thesis : rows::Method::field;
  FURROW_DO(read_field(arguments, options));
  FURROW_DO(read_half_width(arguments, options.follower));
  if (!arguments.out.empty()) options.out = arguments.out;
  if (!arguments.by_hand.empty()) options.by_hand = arguments.by_hand;
  if (!arguments.mavlink.empty()) options.steer_to = arguments.mavlink;
  if (options.steer_to && !options.camera && options.follower.rule != follow::Rule::thesis) {
    return Error{"bad_usage", "--mavlink", "no way to metres",
                 "--camera with --spacing or --height, or --rule thesis",
                 "The thesis's rule takes a row to be 0.60 m to each side."};
  }
  options.overlay = !arguments.no_overlay;
  options.threads = arguments.threads;
  options.stop = &stop_asked;
  return options;
}

Result<std::unique_ptr<image::PictureSource>> open(const Arguments& arguments) {
  const image::SourceOptions options{arguments.rate_hz, 5.0};
  if (arguments.sources.size() == 1) return image::open_source(arguments.sources.front(), options);
  FURROW_TRY(auto files, image::picture_files({arguments.sources.begin(), arguments.sources.end()}));
  return image::open_pictures(std::move(files), options);
}

void print_outcome(const project::FollowOutcome& outcome, const std::string& out) {
  for (const std::string& note : outcome.notes) std::fprintf(stderr, "%s\n", note.c_str());
  std::fprintf(stderr,
               "%lld pictures, rows in %lld, hold in %lld, followed row changed or counted anew %lld times\n",
               static_cast<long long>(outcome.pictures), static_cast<long long>(outcome.seen),
               static_cast<long long>(outcome.held), static_cast<long long>(outcome.row_changes));
  if (outcome.skipped > 0)
    std::fprintf(stderr, "%lld live pictures came too fast and were skipped\n",
                 static_cast<long long>(outcome.skipped));
  if (!outcome.by_hand.rows.empty()) std::fprintf(stderr, "%s", base::to_csv(outcome.by_hand).c_str());
  for (const std::string& file : outcome.files) std::fprintf(stderr, "%s/%s\n", out.c_str(), file.c_str());
}

int follow_row(const Arguments& arguments) {
  auto options = job_options(arguments);
  if (!options.ok()) return fail(options.error());
  auto source = open(arguments);
  if (!source.ok()) return fail(source.error());
  const bool is_metric = options->follower.is_metric = options->camera.has_value();
  options->on_picture = [&](const project::FollowedPicture& picture) {
    if (arguments.quiet) return true;
    std::printf("%s\n", base::to_json(project::followed_value(picture, is_metric), -1).c_str());
    return std::fflush(stdout) == 0;
  };
  std::signal(SIGINT, ask_to_stop);
  std::signal(SIGTERM, ask_to_stop);
  std::signal(SIGPIPE, SIG_IGN);  // a reader that goes away ends the run in good order
  const auto outcome = project::follow_job(std::move(*source), *options);
  if (!outcome.ok()) return fail(outcome.error());
  print_outcome(*outcome, arguments.out);
  if (outcome->pictures == 0 && !stop_asked)
    return fail({"no_picture_read", arguments.sources.front(), "not one picture could be read", "", ""});
  return outcome->source_failed ? kBadInput : kDone;
}

void add_field_options(CLI::App* command, Arguments& arguments) {
  command->add_option("--camera", arguments.camera,
                      "camera model; with --spacing, --height or --half-width offsets are metres, else px");
  command->add_option("--spacing", arguments.spacing_m, "between rows, m")->check(above_zero());
  command->add_option("--spacing-sigma", arguments.spacing_sigma_m, "one sigma of it, m (default 2 %)")
      ->check(above_zero())
      ->needs("--spacing");
  command
      ->add_option(
          "--height", arguments.height_m,
          "of the camera above the tops of the rows, m, from elsewhere; metres also from a row alone")
      ->check(above_zero());
  command->add_option("--height-sigma", arguments.height_sigma_m, "one sigma of it, m (default 5 %)")
      ->check(above_zero())
      ->needs("--height");
  command->add_option("--half-width", arguments.half_width_m, "of the canopy, m, where known")
      ->check(above_zero());
  command->add_option("--pitch", arguments.pitch_deg, "of the gimbal, deg, negative below the horizon")
      ->check(between(-90.0, 0.0));
  command->add_option("--pitch-sigma", arguments.pitch_sigma_deg, "one sigma of it, deg")
      ->check(above_zero())
      ->needs("--pitch")
      ->capture_default_str();
}

void add_rule_options(CLI::App* command, Arguments& arguments) {
  command->add_option("--rule", arguments.rule, "what steering goes by: filtered (default) or thesis")
      ->check(CLI::IsMember({"filtered", "thesis"}))
      ->capture_default_str();
  command
      ->add_option("--hold", arguments.hold,
                   "row: stay with the first row (default); nearest: the thesis's way")
      ->check(CLI::IsMember({"row", "nearest"}))
      ->capture_default_str();
  command->add_option("--method", arguments.method, "of finding rows: field (default) or thesis")
      ->check(CLI::IsMember({"field", "thesis"}))
      ->capture_default_str();
  command
      ->add_option("--half-width-px", arguments.half_width,
                   "for the thesis's centimetres: thesis (15 px at 320 px of width), auto, or px")
      ->capture_default_str();
}

}  // namespace

void add_follow(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("follow", "Follow a row through a video, pictures or a live camera");
  auto arguments = std::make_shared<Arguments>();
  command
      ->add_option(
          "source", arguments->sources,
          "a video, a folder or pattern of pictures, pictures, a camera (/dev/video0 or 0), or a stream "
          "(rtsp://...)")
      ->required();
  command->add_option("--rate", arguments->rate_hz, "pictures a second of a folder, which has no times")
      ->check(between(0.001, 1000.0))
      ->capture_default_str();
  add_rule_options(command, *arguments);
  add_field_options(command, *arguments);
  command->add_option("--out", arguments->out, "folder for follow.csv, figures/ and overlay.mp4");
  command->add_flag("--no-overlay", arguments->no_overlay, "write no overlay.mp4");
  command->add_option(
      "--by-hand", arguments->by_hand,
      "CSV of deviations read by hand (picture, deviation_m or _cm or _px, flight) to compare with");
  command->add_option("--mavlink", arguments->mavlink,
                      "send PX4 velocity setpoints: udp:127.0.0.1:14540 or file:PATH (off by default)");
  command
      ->add_option("--speed", arguments->speed_mps,
                   "forward speed of the setpoints while a row is followed, m/s")
      ->check(between(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--threads", arguments->threads, "0: one per core")->check(zero_or_more());
  command->add_flag("--quiet", arguments->quiet, "print no lines");
  command->footer(
      "Prints one JSON object a line and picture; Ctrl-C ends a live run in good order.\n"
      "Example: furrow follow flight.mp4 --camera camera.yaml --spacing 3.0 --pitch -20 --out out/follow");
  command->callback([&action, arguments] { action = [arguments] { return follow_row(*arguments); }; });
}

}  // namespace furrow::cli
