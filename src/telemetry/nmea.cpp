#include <cmath>

#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"
#include "reader_tools.h"

namespace furrow::telemetry {
namespace {

using base::kNanosecondsPerSecond;
using base::Nanoseconds;
using Fields = std::vector<std::string_view>;

constexpr Nanoseconds kDay_ns = 86400 * kNanosecondsPerSecond;

/// Fields between '$' and '*' when the checksum holds (or none is there).
std::optional<Fields> sentence(std::string_view line) {
  line = base::trim(line);
  if (!line.starts_with('$')) return std::nullopt;
  const auto star = line.find('*');
  const std::string_view body = line.substr(1, star == std::string_view::npos ? star : star - 1);
  if (star != std::string_view::npos) {
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    constexpr std::string_view kHex = "0123456789ABCDEF";
    const std::string expected{kHex[(sum >> 4) & 15U], kHex[sum & 15U]};
    std::string given(line.substr(star + 1, 2));
    for (char& c : given)
      if (c >= 'a' && c <= 'f') c = static_cast<char>(c - 'a' + 'A');
    if (given != expected) return std::nullopt;
  }
  return base::split(body, ',');
}

/// "235947.00" as nanoseconds of the day.
std::optional<Nanoseconds> time_of_day(std::string_view text) {
  const auto value = base::parse_double(text);
  if (!value || text.size() < 6 || !(*value >= 0.0 && *value < 240000.0)) return std::nullopt;
  const int whole = static_cast<int>(*value);
  const int whole_minutes = whole / 100;
  const double seconds = *value - 100.0 * whole_minutes;
  return (whole / 10000 * 3600 + whole / 100 % 100 * 60) * kNanosecondsPerSecond +
         base::seconds_to_ns(seconds);
}

/// "3509.6521008" and "N" as degrees.
double angle_deg(std::string_view text, std::string_view hemisphere) {
  const auto value = base::parse_double(text);
  if (!value || hemisphere.empty()) return kMissing;
  const double whole = std::floor(*value / 100.0);
  const double angle = whole + (*value - 100.0 * whole) / 60.0;
  return hemisphere == "S" || hemisphere == "W" ? -angle : angle;
}

double number(const Fields& f, std::size_t i) {
  return i < f.size() ? base::parse_double(f[i]).value_or(kMissing) : kMissing;
}

/// What the sentences have said so far.
struct State {
  std::optional<Nanoseconds> day_ns;   ///< of the last RMC or ZDA
  std::optional<Nanoseconds> last_ns;  ///< time of the last GGA, days counted
  double speed_mps = kMissing;
  Nanoseconds speed_tod_ns = -1;
};

void read_rmc(const Fields& f, State& state) {
  if (f.size() < 10) return;
  const std::string d(f[9]);
  if (d.size() == 6)
    if (const auto day = base::parse_date_time("20" + d.substr(4, 2) + "-" + d.substr(2, 2) + "-" +
                                               d.substr(0, 2) + " 00:00:00"))
      state.day_ns = day;
  state.speed_mps = number(f, 7) * reader::kMpsPerKnot;
  state.speed_tod_ns = time_of_day(f[1]).value_or(-1);
}

void read_zda(const Fields& f, State& state) {
  if (f.size() < 5) return;
  if (const auto day = base::parse_date_time(std::string(f[4]) + "-" + std::string(f[3]) + "-" +
                                             std::string(f[2]) + " 00:00:00"))
    state.day_ns = day;
}

std::optional<Sample> read_gga(const Fields& f, State& state) {
  if (f.size() < 12) return std::nullopt;
  const auto tod = time_of_day(f[1]);
  const double quality = number(f, 6);
  if (!tod || !(quality > 0.0)) return std::nullopt;
  Nanoseconds t = state.day_ns.value_or(state.last_ns.value_or(0) / kDay_ns * kDay_ns) + *tod;
  // The date may come a sentence late over midnight.
  if (state.last_ns && t - *state.last_ns > kDay_ns / 2) t -= kDay_ns;
  if (state.last_ns && *state.last_ns - t > kDay_ns / 2) t += kDay_ns;
  state.last_ns = t;
  Sample s;
  s.t_utc_ns = t;
  s.latitude_deg = angle_deg(f[2], f[3]);
  s.longitude_deg = angle_deg(f[4], f[5]);
  s.height_geoid_m = number(f, 9);
  constexpr double kRtkFixed = 4.0, kRtkFloat = 5.0;
  if (quality == kRtkFixed || quality == kRtkFloat) s.height_ellipsoid_m = number(f, 9) + number(f, 11);
  if (state.speed_tod_ns == *tod) s.speed_mps = state.speed_mps;
  return s;
}

}  // namespace

Result<Track> read_nmea(std::string_view text, const std::string& name) {
  Track track;
  track.source = name;
  track.format = "nmea";
  State state;
  std::vector<int> lines;
  std::size_t broken = 0;
  int line_number = 0, first_broken = 0;
  for (const std::string_view line : base::split(text, '\n')) {
    ++line_number;
    if (base::trim(line).empty()) continue;
    const auto fields = sentence(line);
    if (!fields || fields->empty() || fields->front().size() < 5) {
      if (broken++ == 0) first_broken = line_number;
      continue;
    }
    const std::string_view kind = fields->front().substr(2);
    if (kind == "RMC") read_rmc(*fields, state);
    if (kind == "ZDA") read_zda(*fields, state);
    if (kind != "GGA") continue;
    if (auto sample = read_gga(*fields, state)) {
      track.samples.push_back(*sample);
      lines.push_back(line_number);
    }
  }
  if (track.samples.empty())
    return Error{"telemetry_empty", name, "no GGA sentence with a position", "at least one", ""};
  if (broken > 0)
    track.warnings.push_back(reader::rows_text(broken, first_broken) +
                             " no sentence, or with a wrong checksum: left out");
  reader::log_time_from_utc(track);
  if (!state.day_ns) {
    track.warnings.emplace_back("no RMC or ZDA sentence gives the date: the log has no UTC");
    for (Sample& s : track.samples) s.t_utc_ns.reset();
  }
  reader::finish(track, lines);
  return track;
}

}  // namespace furrow::telemetry
