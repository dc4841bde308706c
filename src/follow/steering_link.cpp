#include "furrow/follow/steering_link.h"

#include <fcntl.h>
#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

#include "furrow/base/text.h"

namespace furrow::follow {
namespace {

Error bad_address(const std::string& address) {
  return {"bad_address", address, "this is no address to steer to",
          "udp:HOST:PORT with a numeric HOST, or file:PATH",
          "PX4 listens on udp:127.0.0.1:14580 in its simulator."};
}

Error unavailable(const std::string& address, int reason) {
  return {"link_unavailable", address, std::string("cannot be opened: ") + std::strerror(reason), "", ""};
}

struct FreeAddress {
  void operator()(addrinfo* info) const { ::freeaddrinfo(info); }
};

/// A connected datagram socket, or -1 with errno.
int connected_socket(const addrinfo& to) {
  const int descriptor = ::socket(to.ai_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (descriptor < 0 || ::connect(descriptor, to.ai_addr, to.ai_addrlen) == 0) return descriptor;
  const int reason = errno;
  ::close(descriptor);
  errno = reason;
  return -1;
}

}  // namespace

Result<SteeringLink> SteeringLink::open(const std::string& address) {
  if (address.starts_with("file:") && address.size() > 5) {
    const int descriptor =
        ::open(address.c_str() + 5, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NONBLOCK, 0644);
    if (descriptor < 0) return unavailable(address, errno);
    return SteeringLink(descriptor, false);
  }
  const auto colon = address.rfind(':');
  if (!address.starts_with("udp:") || colon <= 4) return bad_address(address);
  std::string host = address.substr(4, colon - 4);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  const auto port = base::parse_int(address.substr(colon + 1));
  if (!port || *port < 1 || *port > 65535) return bad_address(address);
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), std::to_string(*port).c_str(), &hints, &found) != 0)
    return bad_address(address);
  const std::unique_ptr<addrinfo, FreeAddress> owned(found);
  const int descriptor = connected_socket(*owned);
  if (descriptor < 0) return unavailable(address, errno);
  return SteeringLink(descriptor, true);
}

SteeringLink::SteeringLink(SteeringLink&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      is_socket_(other.is_socket_),
      sent_(other.sent_),
      dropped_(other.dropped_) {}

SteeringLink& SteeringLink::operator=(SteeringLink&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(is_socket_, other.is_socket_);
  std::swap(sent_, other.sent_);
  std::swap(dropped_, other.dropped_);
  return *this;
}

SteeringLink::~SteeringLink() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void SteeringLink::send(std::string_view frame) {
  // A datagram to a port where nobody listens comes back as an error of the next one; that one is sent again.
  for (int attempt = 0; attempt < 2; ++attempt) {
    const ssize_t written = is_socket_
                                ? ::send(descriptor_, frame.data(), frame.size(), MSG_DONTWAIT | MSG_NOSIGNAL)
                                : ::write(descriptor_, frame.data(), frame.size());
    if (written == static_cast<ssize_t>(frame.size())) {
      ++sent_;
      return;
    }
    if (errno != ECONNREFUSED && errno != EINTR) break;
  }
  ++dropped_;
}

}  // namespace furrow::follow
