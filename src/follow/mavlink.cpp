#include "furrow/follow/mavlink.h"

#include <bit>

#include "furrow/base/result.h"

namespace furrow::follow {
namespace {

/// Little-endian bytes, one field after the other in the order of the wire: by falling size.
class Payload {
 public:
  template <class T>
  Payload& add(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
      bytes_ += static_cast<char>((static_cast<std::uint64_t>(value) >> (8 * i)) & 0xFFU);
    return *this;
  }
  Payload& add_float(double value) { return add(std::bit_cast<std::uint32_t>(static_cast<float>(value))); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace

std::uint16_t mavlink_crc(std::string_view bytes, std::uint16_t start) {
  constexpr unsigned kPolynomial = 0x8408;  // 0x1021 reflected
  unsigned crc = start;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1U) ^ kPolynomial : crc >> 1U;
  }
  return static_cast<std::uint16_t>(crc);
}

std::string mavlink_frame(const MavlinkAddress& address, std::uint8_t sequence, std::uint32_t message_id,
                          std::uint8_t crc_extra, std::string_view payload) {
  check(payload.size() <= 255, "mavlink_frame: a payload has at most 255 bytes");
  while (payload.size() > 1 && payload.back() == '\0') payload.remove_suffix(1);
  Payload frame;
  frame.add(std::uint8_t{0xFD}).add(static_cast<std::uint8_t>(payload.size()));
  frame.add(std::uint8_t{0}).add(std::uint8_t{0});  // no signature, no optional features
  frame.add(sequence).add(address.system).add(address.component);
  frame.add(static_cast<std::uint16_t>(message_id)).add(static_cast<std::uint8_t>(message_id >> 16U));
  const std::string bytes = frame.bytes() + std::string(payload);
  const std::uint16_t crc = mavlink_crc(std::string(1, static_cast<char>(crc_extra)),
                                        mavlink_crc(std::string_view(bytes).substr(1)));
  return bytes + Payload().add(crc).bytes();
}

// Message ids, CRC extras and values of enumerations: common.xml and minimal.xml of MAVLink.

std::string heartbeat_frame(const MavlinkAddress& address, std::uint8_t sequence) {
  constexpr std::uint8_t kOnboardController = 18, kNoAutopilot = 8, kActive = 4, kMavlinkVersion = 3;
  Payload payload;
  payload.add(std::uint32_t{0});  // custom mode
  payload.add(kOnboardController).add(kNoAutopilot).add(std::uint8_t{0}).add(kActive).add(kMavlinkVersion);
  return mavlink_frame(address, sequence, 0, 50, payload.bytes());
}

std::string velocity_frame(const MavlinkAddress& address, std::uint8_t sequence, std::uint32_t time_boot_ms,
                           const BodyVelocity& velocity) {
  constexpr std::uint8_t kBodyNed = 8;
  // Ignored: position (bits 0 to 2), acceleration (6 to 8), yaw (10).
  constexpr std::uint16_t kVelocityAndYawRate = 0x5C7;
  Payload payload;
  payload.add(time_boot_ms);
  for (int i = 0; i < 3; ++i) payload.add_float(0.0);
  payload.add_float(velocity.forward_mps).add_float(velocity.right_mps).add_float(velocity.down_mps);
  for (int i = 0; i < 4; ++i) payload.add_float(0.0);  // acceleration, yaw
  payload.add_float(velocity.yaw_rate_rad_s);
  payload.add(kVelocityAndYawRate).add(address.target_system).add(address.target_component).add(kBodyNed);
  return mavlink_frame(address, sequence, 84, 143, payload.bytes());
}

}  // namespace furrow::follow
