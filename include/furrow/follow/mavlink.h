#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "furrow/follow/guidance.h"

/// The two MAVLink 2 messages that PX4 needs from a companion computer that steers
/// (mavlink.io/en/guide/serialization.html, docs.px4.io, "Offboard Mode"); encoded here because the official
/// library is generated code that no package brings.
namespace furrow::follow {

/// Who speaks to whom. Default: the onboard computer (component 191) of system 1, to that system's autopilot.
struct MavlinkAddress {
  std::uint8_t system = 1, component = 191;
  std::uint8_t target_system = 1, target_component = 1;
};

/// CRC-16/MCRF4XX, which MAVLink calls X.25: polynomial 0x1021 reflected, start 0xFFFF. "123456789" gives
/// 0x6F91.
std::uint16_t mavlink_crc(std::string_view bytes, std::uint16_t start = 0xFFFF);

/// A frame: 0xFD, length, flags, sequence, system, component, message id, payload without trailing zeros, CRC
/// over all but the first byte and over `crc_extra`.
std::string mavlink_frame(const MavlinkAddress& address, std::uint8_t sequence, std::uint32_t message_id,
                          std::uint8_t crc_extra, std::string_view payload);

/// HEARTBEAT (0): an onboard controller that is active. One a second tells the autopilot that the companion
/// lives.
std::string heartbeat_frame(const MavlinkAddress& address, std::uint8_t sequence);

/// SET_POSITION_TARGET_LOCAL_NED (84) in MAV_FRAME_BODY_NED with velocity and yaw rate, all else masked out:
/// what PX4's offboard mode takes for a velocity in the aircraft's own axes. (LANDING_TARGET steers precision
/// landing only, and MAV_FRAME_BODY_FRD, the newer name, is refused by PX4.) PX4 wants more than two of them
/// a second before and while in offboard mode, and leaves that mode when they stop: a source that falls
/// silent stops the aircraft. Turned by yaw alone from PX4 1.14 on; older versions turn by the whole
/// attitude.
std::string velocity_frame(const MavlinkAddress& address, std::uint8_t sequence, std::uint32_t time_boot_ms,
                           const BodyVelocity& velocity);

}  // namespace furrow::follow
