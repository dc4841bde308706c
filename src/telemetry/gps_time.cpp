#include "gps_time.h"

#include <array>

namespace furrow::telemetry::reader {
namespace {

using base::kNanosecondsPerSecond;
using base::Nanoseconds;

constexpr Nanoseconds kDay_ns = 86400 * kNanosecondsPerSecond;
/// 1980-01-06, when GPS time and UTC agreed, is 3657 days after 1970-01-01.
constexpr Nanoseconds kGpsEpoch_ns = 3657 * kDay_ns;

/// From that UTC day on, GPS time is ahead by so many seconds.
struct Leap {
  int days_since_1970;
  int seconds;
};
constexpr std::array kLeaps = {
    Leap{4199, 1},   Leap{4564, 2},   Leap{4929, 3},   Leap{5660, 4},   Leap{6574, 5},   Leap{7305, 6},
    Leap{7670, 7},   Leap{8217, 8},   Leap{8582, 9},   Leap{8947, 10},  Leap{9496, 11},  Leap{10043, 12},
    Leap{10592, 13}, Leap{13149, 14}, Leap{14245, 15}, Leap{15522, 16}, Leap{16617, 17}, Leap{17167, 18},
};

}  // namespace

Nanoseconds utc_from_gps(Nanoseconds t_gps_ns) {
  int ahead_s = 0;
  for (const Leap& leap : kLeaps)
    if (t_gps_ns - leap.seconds * kNanosecondsPerSecond >= leap.days_since_1970 * kDay_ns)
      ahead_s = leap.seconds;
  return t_gps_ns - ahead_s * kNanosecondsPerSecond;
}

Nanoseconds gps_time(int week, double seconds) {
  return kGpsEpoch_ns + Nanoseconds{week} * 7 * kDay_ns + base::seconds_to_ns(seconds);
}

}  // namespace furrow::telemetry::reader
