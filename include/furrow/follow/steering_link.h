#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "furrow/base/result.h"

namespace furrow::follow {

/// Where steering frames go: "udp:127.0.0.1:14550" (a numeric address, so that no name look-up can wait), or
/// "file:PATH". Sending never waits: what the network does not take at once is dropped and counted.
class SteeringLink {
 public:
  /// Errors: bad_address, link_unavailable (no socket, file cannot be written).
  static Result<SteeringLink> open(const std::string& address);
  SteeringLink(SteeringLink&& other) noexcept;
  SteeringLink& operator=(SteeringLink&& other) noexcept;
  ~SteeringLink();

  void send(std::string_view frame);
  std::int64_t sent() const { return sent_; }
  std::int64_t dropped() const { return dropped_; }

 private:
  SteeringLink(int descriptor, bool is_socket) : descriptor_(descriptor), is_socket_(is_socket) {}
  int descriptor_ = -1;
  bool is_socket_ = false;
  std::int64_t sent_ = 0, dropped_ = 0;
};

}  // namespace furrow::follow
