#pragma once
#include <array>

#include "furrow/telemetry/track.h"

namespace furrow::telemetry {

/// The numbers of a Sample by how they may be averaged or interpolated: along a line, ...
inline constexpr std::array kLinearFields = {
    &Sample::latitude_deg,       &Sample::height_takeoff_m,
    &Sample::height_vps_m,       &Sample::height_terrain_msl_m,
    &Sample::height_ellipsoid_m, &Sample::height_geoid_m,
    &Sample::speed_mps,
};
/// ... or the short way round a circle. Headings are reported in [0, 360), ...
inline constexpr std::array kHeadingFields = {&Sample::yaw_deg, &Sample::gimbal_heading_deg};
/// ... these in [-180, 180).
inline constexpr std::array kSignedAngleFields = {&Sample::longitude_deg, &Sample::pitch_deg,
                                                  &Sample::roll_deg, &Sample::gimbal_pitch_deg,
                                                  &Sample::gimbal_roll_deg};

}  // namespace furrow::telemetry
