#include "project/fusion.h"

#include <algorithm>
#include <cmath>

#include "furrow/stats/robust.h"

namespace furrow::project {
namespace {

using altitude::HeightSample;
using altitude::HeightSource;

/// Moment of a shot on the log's clock, or on the pictures' own; nothing where neither is known.
std::optional<double> time_of(const sync::ShotPose& pose) {
  const bool in_log = std::isfinite(pose.t_sigma_s);
  if (in_log) return base::ns_to_seconds(pose.state.t_log_ns);
  if (pose.state.t_utc_ns) return base::ns_to_seconds(*pose.state.t_utc_ns);
  return std::nullopt;
}

/// A receiver's height, by one reference for the whole flight: the ellipsoid where any shot has it.
std::vector<double> gnss_heights(const sync::Located& located) {
  const bool ellipsoid =
      std::any_of(located.poses.begin(), located.poses.end(),
                  [](const sync::ShotPose& pose) { return std::isfinite(pose.state.height_ellipsoid_m); });
  std::vector<double> heights;
  for (const sync::ShotPose& pose : located.poses)
    heights.push_back(ellipsoid ? pose.state.height_ellipsoid_m : pose.state.height_geoid_m);
  return heights;
}

/// Samples in order of time. Shots of one clock step are set apart by a millisecond.
void add_samples(const sync::Located& located, const std::vector<VisionHeight>& vision,
                 const std::vector<VisionHeight>& depth, audit::FlightFusion& fusion) {
  constexpr double kApart_s = 1e-3;
  std::vector<std::pair<double, std::size_t>> order;
  for (std::size_t i = 0; i < located.poses.size(); ++i) {
    if (const auto t = time_of(located.poses[i])) order.push_back({*t, i});
  }
  std::sort(order.begin(), order.end());
  const std::vector<double> gnss = gnss_heights(located);
  for (const auto& [t, i] : order) {
    HeightSample sample;
    sample.t_s = t - order.front().first;
    if (!fusion.samples.empty()) sample.t_s = std::max(sample.t_s, fusion.samples.back().t_s + kApart_s);
    sample.vision_above_canopy_m = vision[i].above_canopy_m;
    sample.vision_shared = vision[i].shared;
    sample.vision_reach_m = vision[i].reach_m;
    if (i < depth.size()) {
      sample.depth_above_canopy_m = depth[i].above_canopy_m;
      sample.depth_shared = depth[i].shared;
    }
    sample.baro_height_m = located.poses[i].state.height_takeoff_m;
    sample.vps_height_m = located.poses[i].state.height_vps_m;
    sample.gnss_height_m = gnss[i];
    fusion.samples.push_back(sample);
    fusion.shots.push_back(i);
  }
}

/// The median over the pictures' heights: they share one canopy.
Estimate typical_rise(const std::vector<VisionHeight>& vision) {
  std::vector<double> values, sigmas;
  for (const VisionHeight& height : vision) {
    if (!height.outline_rise_m.usable()) continue;
    values.push_back(height.outline_rise_m.value);
    sigmas.push_back(height.outline_rise_m.sigma);
  }
  if (values.empty()) return {};
  return {stats::median(values), stats::median(sigmas), static_cast<int>(values.size())};
}

/// Whether the downward sensor saw leaves and soil, and no error of words could swap them.
bool tells_levels_apart(const altitude::FusedFlight& fused, const Estimate& rise_m,
                        const Estimate& row_height_m) {
  constexpr std::ptrdiff_t kLeast = 2;  // readings of each
  constexpr double kSigmas = 4.0;
  const auto seen = [&](altitude::Seen surface) {
    return std::count_if(fused.heights.begin(), fused.heights.end(),
                         [surface](const altitude::FusedHeight& h) { return h.vps_seen == surface; });
  };
  if (seen(altitude::Seen::canopy) < kLeast || seen(altitude::Seen::soil) < kLeast) return false;
  return row_height_m.value > kSigmas * std::hypot(rise_m.sigma, row_height_m.sigma);
}

/// The rise that is left when the outline's error is taken off: where pictures say too much, it is less.
/// Nothing where the farm told it, or no downward sensor tells the levels of leaves and soil apart.
Estimate told_rise(const Estimate& taken_m, const altitude::FusedFlight& fused,
                   const altitude::FieldKnowledge& field) {
  if (field.outline_rise_m.usable() || !tells_levels_apart(fused, taken_m, field.row_height_m)) return {};
  for (const altitude::SharedCause& shared : fused.causes) {
    if (shared.cause != "outline" || !taken_m.usable()) continue;
    return {taken_m.value - shared.error_sigmas.value * taken_m.sigma,
            shared.error_sigmas.sigma * taken_m.sigma, taken_m.observations};
  }
  return {};
}

/// How far leaves may lie from the top that the farm names: as far, by the same words, as the pictures leave
/// the outline open; where the farm tells the outline, it says nothing of the leaves below the aircraft.
double top_sigma_m(const std::vector<VisionHeight>& vision, const altitude::FieldKnowledge& field) {
  std::vector<double> sigmas;
  for (const VisionHeight& height : vision) {
    for (const altitude::SigmaShare& share : height.shared)
      if (share.cause == "outline") sigmas.push_back(share.sigma_m);
  }
  if (!sigmas.empty() && !field.outline_rise_m.usable()) return stats::median(sigmas);
  if (!field.half_width_m.usable()) return altitude::typical_rise_sigma_m();
  return altitude::typical_rise_sigma_m(field.half_width_m.value);
}

}  // namespace

double reach_of(const altitude::RefinedShot& shot) {
  constexpr double kMostCotangent = 6.0;
  const double cotangent = 1.0 / std::tan(-shot.pitch_rad.value);
  return shot.height_above_canopy_m.value * std::clamp(cotangent, 0.0, kMostCotangent);
}

VisionHeight vision_of_shot(const altitude::RefinedShot& shot) {
  VisionHeight height{shot.height_above_canopy_m, {}, reach_of(shot), shot.outline_rise_m};
  for (const altitude::SigmaShare& share : shot.height_budget) {
    if (share.cause != "picture" && share.cause != "plants") height.shared.push_back(share);
  }
  return height;
}

VisionHeight vision_in_flight(const altitude::RefinedShot& shot) {
  return {shot.height_above_canopy_m, shot.height_shared, reach_of(shot), shot.outline_rise_m};
}

Result<audit::FlightFusion> fuse_flight(const sync::Located& located, const std::vector<VisionHeight>& vision,
                                        const altitude::FieldKnowledge& field,
                                        const std::vector<VisionHeight>& depth) {
  audit::FlightFusion fusion;
  add_samples(located, vision, depth, fusion);
  if (fusion.samples.empty()) {
    return Error{"no_times", "fusion", "no shot has a time", "a log, or pictures that state their time", ""};
  }
  altitude::FuseOptions options;
  options.row_height_m = field.row_height_m;
  options.vps_canopy_sigma_m = top_sigma_m(vision, field);
  FURROW_TRY(fusion.fused, altitude::fuse(fusion.samples, options));
  fusion.rise_taken_m = typical_rise(vision);
  fusion.rise_told_m = told_rise(fusion.rise_taken_m, fusion.fused, field);
  for (const HeightSource source : audit::speaking_sources(fusion)) {
    altitude::FuseOptions without = options;
    without.use[static_cast<std::size_t>(source)] = false;
    fusion.without.push_back({source, altitude::fuse(fusion.samples, without)});
  }
  return fusion;
}

}  // namespace furrow::project
