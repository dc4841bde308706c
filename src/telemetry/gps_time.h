#pragma once
#include "furrow/base/time.h"

namespace furrow::telemetry::reader {

/// UTC of a reading of GPS time (both as nanoseconds since 1970-01-01), by the leap seconds announced so far
/// (IERS Bulletin C; the last one was at the end of 2016).
base::Nanoseconds utc_from_gps(base::Nanoseconds t_gps_ns);

/// GPS week (not cut to 10 bits) and seconds of it as nanoseconds since 1970-01-01 in GPS time.
base::Nanoseconds gps_time(int week, double seconds);

}  // namespace furrow::telemetry::reader
