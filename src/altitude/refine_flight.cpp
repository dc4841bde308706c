#include "flight_members.h"
#include "flight_normal.h"
#include "flight_results.h"
#include "furrow/altitude/flight.h"

namespace furrow::altitude {
namespace {

constexpr int kMostRounds = 3;  // of refining, each without the shots that fitted badly in the one before

/// Refines the members, leaves out those that then fit badly, and describes what is left in `result`.
Status refine(FlightSystem& flight, const std::vector<ShotInput>& shots, const Camera& camera,
              const FieldKnowledge& field, const FlightOptions& options, RefinedFlight& result) {
  for (int round = 1;; ++round) {
    if (flight.members.empty()) {
      return Error{"no_usable_shot", shots.front().shot_id, result.reason.front(),
                   "a shot with two or more rows that the others bear out", ""};
    }
    flight.ties = ties_of(flight.members, shots, options);
    const SolveReport report = solve(flight, options);
    result.iterations = report.iterations;
    result.termination = report.termination;
    const FlightNormal normal = normal_of(flight, options.shots_per_stretch);
    const auto inverse = invert(normal.matrix);
    if (!report.usable || !inverse) {
      return Error{"solve_failed", "flight", "no convergence (" + report.termination + ")",
                   "shots over one field", ""};
    }
    result.residual_rms = normal.residual_rms;
    describe(flight, *inverse, normal.noise_scale2, camera, field, result);
    if (round == kMostRounds || !leave_out_misfits(shots, normal.member_rms, options, flight.members, result))
      return Done{};
  }
}

}  // namespace

Result<RefinedFlight> refine_flight(const std::vector<ShotInput>& shots, const Camera& camera,
                                    const FieldKnowledge& field, const FlightOptions& options) {
  if (shots.empty()) return Error{"no_shots", "flight", "no shots", "one shot or more", ""};
  FURROW_TRY(const Farm farm, complete_farm(field));
  RefinedFlight result;
  result.shots.resize(shots.size());
  result.status.assign(shots.size(), "not run");
  result.reason.resize(shots.size());
  FlightSystem flight;
  flight.members = members_of(shots, camera, field, farm, options, result);
  flight.shared_priors = shared_priors(farm, shots, options);
  for (const ParameterPrior& prior : flight.shared_priors)
    flight.shared[prior.parameter] = prior.wanted.value;
  const Status refined = refine(flight, shots, camera, field, options, result);
  if (refined.ok()) {
    result.failure.reset();
  } else {
    result.failure = refined.error();
    result.shots.assign(shots.size(), {});
    for (const FlightMember& member : flight.members) result.status[member.input] = refined.error().code;
  }
  return result;
}

std::optional<Error> failure_of(const Result<RefinedFlight>& flight) {
  return flight.ok() ? flight->failure : flight.error();
}

bool RefinedFlight::denies(std::size_t shot) const {
  return status[shot] == "denied_by_neighbours" || status[shot] == "rows_do_not_fit";
}

}  // namespace furrow::altitude
