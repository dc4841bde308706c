#include "furrow/project/jobs.h"
#include "furrow/sim/simulate.h"

namespace furrow::project {

Result<RunOutcome> demo_job(const std::filesystem::path& out, const JobOptions& job) {
  const std::filesystem::path input = out / "input";
  FURROW_TRY(const sim::Simulated simulated, sim::simulate(sim::demo_scene(), input, job.progress));
  (void)simulated;
  FURROW_TRY(const Project project, read_project(input / "project.yaml"));
  return run_job(project, out, job, input / "truth.csv");
}

}  // namespace furrow::project
