#include "furrow/follow/mavlink.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "furrow/base/file.h"
#include "furrow/follow/steering_link.h"

namespace furrow::follow {
namespace {

std::string hex(std::string_view bytes) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const char byte : bytes) {
    text += kDigits[static_cast<unsigned char>(byte) >> 4U];
    text += kDigits[static_cast<unsigned char>(byte) & 15U];
  }
  return text;
}

// Check value of CRC-16/MCRF4XX (reveng.sourceforge.io/crc-catalogue/16.htm).
TEST(Mavlink, CrcCheckValue) {
  EXPECT_EQ(mavlink_crc("123456789"), 0x6F91);
}

// The guide's rule for CRC_EXTRA: the CRC of "NAME type field type field ... " in the order of the wire, its
// two bytes joined by exclusive or (mavlink.io/en/guide/serialization.html, "CRC_EXTRA Calculation").
int crc_extra_of(const std::string& definition) {
  const unsigned crc = mavlink_crc(definition);
  return static_cast<int>((crc & 0xFFU) ^ (crc >> 8U));
}

TEST(Mavlink, CrcExtrasFollowFromTheDefinitions) {
  EXPECT_EQ(crc_extra_of("HEARTBEAT uint32_t custom_mode uint8_t type uint8_t autopilot uint8_t base_mode "
                         "uint8_t system_status uint8_t mavlink_version "),
            50);
  EXPECT_EQ(
      crc_extra_of("SET_POSITION_TARGET_LOCAL_NED uint32_t time_boot_ms float x float y float z float vx "
                   "float vy float vz float afx float afy float afz float yaw float yaw_rate uint16_t "
                   "type_mask uint8_t target_system uint8_t target_component uint8_t coordinate_frame "),
      143);
}

// Golden bytes of an independent encoder: node-mavlink 2 (npm), MavLinkProtocolV2(1, 191).serialize.
TEST(Mavlink, HeartbeatAsAnotherEncoderWritesIt) {
  EXPECT_EQ(hex(heartbeat_frame({}, 7)), "fd0900000701bf000000000000001208000403ed74");
}

TEST(Mavlink, VelocityAsAnotherEncoderWritesIt) {
  EXPECT_EQ(
      hex(velocity_frame({}, 200, 123456, {1.0, -0.25, 0.0, 0.125})),
      "fd350000c801bf54000040e201000000000000000000000000000000803f000080be0000000000000000000000000000000000"
      "0000000000003ec7050101089b40");
}

TEST(Mavlink, TrailingZerosAreLeftOutButOneByteStays) {
  EXPECT_EQ(mavlink_frame({}, 0, 1, 0, std::string(5, '\0')).size(), 10U + 1U + 2U);
}

// Frames of a real aircraft (MAVLink 1): the same CRC over header, payload and CRC_EXTRA.
TEST(Mavlink, CrcOfARealLog) {
  const char* data = std::getenv("FURROW_DATA");
  const std::filesystem::path file =
      std::filesystem::path(data != nullptr ? data : FURROW_SOURCE_DIR "/../shared/data") /
      "telemetry/tlog/dronekit_flight.tlog";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "FURROW_DATA has no " << file.filename();
  const std::string log = base::read_file(file).value();
  int heartbeats = 0;
  for (std::size_t i = 0; i + 17 <= log.size() && heartbeats < 20; ++i) {
    if (log[i] != '\xFE' || log[i + 1] != 9 || log[i + 5] != 0) continue;
    const std::string_view frame(log.data() + i, 17);
    const std::uint16_t crc = mavlink_crc(std::string(1, 50), mavlink_crc(frame.substr(1, 14)));
    const int stated = static_cast<unsigned char>(frame[15]) | static_cast<unsigned char>(frame[16]) << 8;
    heartbeats += crc == stated ? 1 : 0;
  }
  EXPECT_EQ(heartbeats, 20);
}

TEST(SteeringLink, NamesWhatIsNoAddress) {
  for (const char* address : {"", "udp:", "udp:1.2.3.4", "udp:localhost:14550", "udp:127.0.0.1:0",
                              "udp:127.0.0.1:99999", "tcp:127.0.0.1:1", "file:"}) {
    const auto link = SteeringLink::open(address);
    ASSERT_FALSE(link.ok()) << address;
    EXPECT_EQ(link.error().code, "bad_address") << address;
  }
  EXPECT_EQ(SteeringLink::open("file:/nowhere/steer.bin").error().code, "link_unavailable");
}

struct Receiver {
  int descriptor = ::socket(AF_INET, SOCK_DGRAM, 0);
  int port = 0;
  Receiver() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    auto* any = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(::bind(descriptor, any, size), 0);
    EXPECT_EQ(::getsockname(descriptor, any, &size), 0);
    port = ntohs(address.sin_port);
  }
  Receiver(const Receiver&) = delete;
  Receiver& operator=(const Receiver&) = delete;
  ~Receiver() { ::close(descriptor); }
};

TEST(SteeringLink, SendsDatagrams) {
  const Receiver receiver;
  auto link = SteeringLink::open("udp:127.0.0.1:" + std::to_string(receiver.port));
  ASSERT_TRUE(link.ok()) << link.error().message();
  const std::string frame = heartbeat_frame({}, 3);
  link->send(frame);
  std::array<char, 512> bytes{};
  const auto count = ::recv(receiver.descriptor, bytes.data(), bytes.size(), MSG_DONTWAIT);
  ASSERT_EQ(count, static_cast<ssize_t>(frame.size()));
  EXPECT_EQ(std::string(bytes.data(), frame.size()), frame);
  EXPECT_EQ(link->dropped(), 0);
}

TEST(SteeringLink, NobodyListeningNeitherWaitsNorFails) {
  int port = 0;
  {
    const Receiver gone;
    port = gone.port;
  }
  auto link = SteeringLink::open("udp:127.0.0.1:" + std::to_string(port));
  ASSERT_TRUE(link.ok());
  for (int i = 0; i < 100; ++i) link->send("x");
  EXPECT_EQ(link->sent() + link->dropped(), 100);
}

}  // namespace
}  // namespace furrow::follow
