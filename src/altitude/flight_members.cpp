#include "flight_members.h"

#include <cmath>
#include <limits>
#include <optional>

#include "denial.h"
#include "furrow/base/parallel.h"
#include "furrow/stats/robust.h"

namespace furrow::altitude {
namespace {

/// The gimbal's reading without what is common to the flight.
Result<FlightMember> member_of(const ShotInput& input, const Camera& camera, const FieldKnowledge& field,
                               const Farm& farm, const FlightOptions& options) {
  FlightMember member;
  FURROW_TRY(member.shot, prepare_shot(input.lines, camera, field, farm, input.attitude, options.shot));
  // A shot that fails on its own must not bend the flight. The gimbal's bias may look like a contradiction to
  // one shot.
  RefineOptions alone = options.shot;
  alone.prior_conflict_sigmas = std::numeric_limits<double>::infinity();
  FURROW_TRY(member.alone, settle_shot(member.shot, camera, field, alone));
  check(member.alone.usable, "a settled shot is usable");
  FURROW_TRY(const GimbalPrior gimbal, gimbal_prior(input.attitude));
  const double sigma = options.angle_noise_rad;
  if (gimbal.theta.usable()) member.log_theta = {gimbal.theta.value, sigma, 1};
  // Without a stated roll the camera is level as loosely as for one shot, and no bias can be told.
  const double loose = input.attitude.roll_rad.usable() ? sigma : std::hypot(sigma, gimbal.lambda.sigma);
  member.log_lambda = {gimbal.lambda.value, loose, 1};
  member.direction = input.direction < 0.0 ? -1.0 : 1.0;
  return member;
}

/// Prepares all shots, in parallel; the bad ones leave their reason in `result`.
std::vector<FlightMember> prepare(const std::vector<ShotInput>& shots, const Camera& camera,
                                  const FieldKnowledge& field, const Farm& farm, const FlightOptions& options,
                                  RefinedFlight& result) {
  std::vector<std::optional<FlightMember>> prepared(shots.size());
  base::parallel_for(shots.size(), options.threads, [&](std::size_t i) {
    auto member = member_of(shots[i], camera, field, farm, options);
    if (!member.ok()) {
      result.status[i] = member.error().code;
      result.reason[i] = member.error().message();
      return;
    }
    member->input = i;
    prepared[i] = std::move(*member);
  });
  std::vector<FlightMember> members;
  for (auto& member : prepared) {
    if (member) members.push_back(std::move(*member));
  }
  return members;
}

/// Takes out members that are denied, with their reasons; false when there are none.
bool leave_out(const std::vector<std::optional<Error>>& denied, std::vector<FlightMember>& members,
               RefinedFlight& result) {
  std::vector<FlightMember> kept;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (!denied[i]) {
      kept.push_back(std::move(members[i]));
      continue;
    }
    const std::size_t input = members[i].input;
    result.shots[input] = {};
    result.status[input] = denied[i]->code;
    result.reason[input] = denied[i]->message();
  }
  const bool any = kept.size() < members.size();
  members = std::move(kept);
  return any;
}

/// One canopy, one raggedness: the median of what the shots show.
void share_roughness(std::vector<FlightMember>& members) {
  std::vector<double> all;
  for (const FlightMember& member : members)
    if (std::isfinite(member.shot.system.roughness_m)) all.push_back(member.shot.system.roughness_m);
  if (all.empty()) return;
  const double typical = stats::median(all);
  for (FlightMember& member : members) member.shot.system.roughness_m = typical;
}

}  // namespace

std::vector<FlightMember> members_of(const std::vector<ShotInput>& shots, const Camera& camera,
                                     const FieldKnowledge& field, const Farm& farm,
                                     const FlightOptions& options, RefinedFlight& result) {
  std::vector<FlightMember> members = prepare(shots, camera, field, farm, options, result);
  std::vector<JudgedShot> alone;
  for (const FlightMember& member : members) {
    const ShotInput& input = shots[member.input];
    alone.push_back(
        {input.shot_id, member.alone.height_above_canopy_m, input.log_height_m, member.alone.residual_rms});
  }
  leave_out(denied_shots(alone, options), members, result);
  share_roughness(members);
  return members;
}

bool leave_out_misfits(const std::vector<ShotInput>& shots, const std::vector<double>& member_rms,
                       const FlightOptions& options, std::vector<FlightMember>& members,
                       RefinedFlight& result) {
  std::vector<JudgedShot> in_flight;
  for (std::size_t i = 0; i < members.size(); ++i) {
    JudgedShot& shot = in_flight.emplace_back();
    shot.shot_id = shots[members[i].input].shot_id;
    shot.residual_rms = member_rms[i];
  }
  return leave_out(denied_by_fit(in_flight, JudgedIn::flight, options), members, result);
}

}  // namespace furrow::altitude
