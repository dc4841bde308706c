#include <CLI/CLI.hpp>
#include <cstdio>

#include "cli/commands.h"
#include "cli/terminal.h"
#include "furrow/sim/simulate.h"

namespace furrow::cli {
namespace {

struct Arguments {
  std::string scene;
  std::string out;
  bool json = false;
};

int simulate(const Arguments& arguments) {
  const auto scene = sim::read_scene(arguments.scene);
  if (!scene.ok()) return fail(scene.error());
  const auto simulated = sim::simulate(*scene, arguments.out, progress_on_stderr());
  if (!simulated.ok()) return fail(simulated.error());
  if (arguments.json) {
    base::Value value;
    value.set("folder", arguments.out);
    value.set("boards", simulated->boards);
    value.set("shots", simulated->shots);
    print_json(value);
  } else {
    std::printf("%s: %d board pictures, %d shots\n", arguments.out.c_str(), simulated->boards,
                simulated->shots);
  }
  return kDone;
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand(
      "simulate", "Render a scene: board pictures, a flight, its log, and the exact truth");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("scene", arguments->scene, "scene.yaml")->required();
  command->add_option("--out", arguments->out, "folder for the results")->required();
  command->add_flag("--json", arguments->json, "print JSON");
  command->footer("Example: furrow simulate projects/vineyard-demo/scene.yaml --out out/vineyard");
  command->callback([&action, arguments] { action = [arguments] { return simulate(*arguments); }; });
}

}  // namespace furrow::cli
