#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace furrow::base {

/// Integer nanoseconds; the variable's name says of which clock (t_utc_ns, t_log_ns, t_video_ns).
using Nanoseconds = std::int64_t;
inline constexpr Nanoseconds kNanosecondsPerSecond = 1'000'000'000;

/// "YYYY-MM-DD hh:mm:ss[.fraction]" (also with 'T', ':' or '.' between date parts, and a trailing 'Z') as
/// nanoseconds since 1970-01-01 of that clock; no zone is applied. Nothing for an impossible date.
std::optional<Nanoseconds> parse_date_time(std::string_view text);

/// "2026-05-31T16:21:39.500Z": ISO 8601 UTC with milliseconds.
std::string format_utc(Nanoseconds t_utc_ns);

inline Nanoseconds seconds_to_ns(double seconds) {
  return static_cast<Nanoseconds>(seconds * 1e9 + (seconds < 0 ? -0.5 : 0.5));
}
inline double ns_to_seconds(Nanoseconds ns) {
  return static_cast<double>(ns) * 1e-9;
}

}  // namespace furrow::base
