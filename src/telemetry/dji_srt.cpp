#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "furrow/base/text.h"
#include "furrow/telemetry/formats.h"
#include "reader_tools.h"

namespace furrow::telemetry {
namespace {

/// One subtitle: its line in the file, when it starts in the video, and its text.
struct Cue {
  int line = 0;
  base::Nanoseconds start_ns = 0;
  std::string_view text;
};

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_word(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

std::string_view skip_blanks(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  return text;
}

/// The number at the front of `text`, which then starts behind it.
std::optional<double> take_number(std::string_view& text) {
  std::string_view rest = skip_blanks(text);
  if (rest.starts_with('+')) rest.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(rest.data(), rest.data() + rest.size(), value, std::chars_format::fixed);
  if (error != std::errc{} || !std::isfinite(value)) return std::nullopt;
  text = rest.substr(static_cast<std::size_t>(end - rest.data()));
  return value;
}

/// Text behind the whole word `word`, from `from` on; nothing when it does not occur.
std::optional<std::string_view> behind_word(std::string_view text, std::string_view word,
                                            std::size_t from = 0) {
  for (std::size_t at = text.find(word, from); at != std::string_view::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    const bool starts = at == 0 || (!is_word(text[at - 1]) && text[at - 1] != '.');
    if (starts && (end == text.size() || !is_word(text[end]))) return text.substr(end);
  }
  return std::nullopt;
}

/// The number of "key: 1.5" or "key : 1.5"; NaN when there is none.
double keyed(std::string_view text, std::string_view key) {
  const auto rest = behind_word(text, key);
  if (!rest) return kMissing;
  std::string_view value = skip_blanks(*rest);
  if (!value.starts_with(':')) return kMissing;
  value.remove_prefix(1);
  return take_number(value).value_or(kMissing);
}

/// The number of "H 45.60m" (a blank between, no colon); NaN when there is none.
double spaced(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1)) {
    std::string_view rest = text.substr(at + word.size());
    if ((at > 0 && (is_word(text[at - 1]) || text[at - 1] == '.')) || !rest.starts_with(' ')) continue;
    if (const auto value = take_number(rest)) return *value;
  }
  return kMissing;
}

/// A member of "GPS (8.2090, 47.4692, 0.0M)".
struct Item {
  double value = kMissing;
  bool metres = false;  ///< an m or M follows
};

/// The members of "word (a, b, c)"; empty when it does not occur or does not close.
std::vector<Item> members(std::string_view text, std::string_view word) {
  auto rest = behind_word(text, word);
  if (!rest) return {};
  std::string_view body = skip_blanks(*rest);
  const auto close = body.find(')');
  constexpr std::size_t kLongest = 200;
  if (!body.starts_with('(') || close == std::string_view::npos || close > kLongest) return {};
  std::vector<Item> items;
  for (std::string_view part : base::split(body.substr(1, close - 1), ',')) {
    Item item;
    if (const auto value = take_number(part)) item.value = *value;
    item.metres = part.starts_with('m') || part.starts_with('M');
    items.push_back(item);
  }
  return items;
}

/// "00:01:02,345" as nanoseconds.
std::optional<base::Nanoseconds> parse_time_code(std::string_view text) {
  text = base::trim(text);
  std::array<std::int64_t, 4> part{};
  constexpr std::array<std::string_view, 4> kBefore = {"", ":", ":", ",."};
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (i > 0) {
      if (text.empty() || kBefore[i].find(text.front()) == std::string_view::npos) return std::nullopt;
      text.remove_prefix(1);
    }
    if (text.empty() || !is_digit(text.front())) return std::nullopt;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), part[i]);
    constexpr std::int64_t kLargest = 9999;
    if (error != std::errc{} || part[i] > kLargest) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return ((part[0] * 60 + part[1]) * 60 + part[2]) * base::kNanosecondsPerSecond + part[3] * 1'000'000;
}

bool is_number_line(std::string_view line) {
  line = base::trim(line);
  return !line.empty() && std::all_of(line.begin(), line.end(), is_digit);
}

/// Cuts at "number + time code" lines, never at blank lines: dialect G' has those inside a cue.
std::vector<Cue> cut_cues(std::string_view text) {
  std::vector<Cue> cues;
  std::size_t at = 0, previous_at = 0, body_at = 0;
  int line = 0;
  std::string_view previous;
  const auto close = [&](std::size_t end) {
    if (!cues.empty()) cues.back().text = text.substr(body_at, end > body_at ? end - body_at : 0);
  };
  while (at < text.size()) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view current = text.substr(at, end - at);
    ++line;
    if (const auto arrow = current.find("-->"); arrow != std::string_view::npos) {
      const auto start = parse_time_code(current.substr(0, arrow));
      if (start && parse_time_code(current.substr(arrow + 3))) {
        close(is_number_line(previous) ? previous_at : at);
        body_at = std::min(end + 1, text.size());
        cues.push_back({line, *start, {}});
      }
    }
    previous = current;
    previous_at = at;
    at = end + 1;
  }
  close(text.size());
  return cues;
}

/// The first date and time in a cue. "51,265,847" is milliseconds and microseconds.
std::optional<base::Nanoseconds> wall_clock(std::string_view text) {
  for (std::size_t i = 0; i + 10 < text.size(); ++i) {
    const bool year =
        is_digit(text[i]) && is_digit(text[i + 1]) && is_digit(text[i + 2]) && is_digit(text[i + 3]);
    if (!year || (i > 0 && (is_word(text[i - 1]) || text[i - 1] == '.')) ||
        (text[i + 4] != '-' && text[i + 4] != '.'))
      continue;
    constexpr std::size_t kLongest = 40;
    const std::size_t limit = std::min(text.size(), i + kLongest);
    std::size_t end = i;
    while (end < limit &&
           (is_digit(text[end]) || std::string_view("-.:, ").find(text[end]) != std::string_view::npos))
      ++end;
    std::string stamp(base::trim(text.substr(i, end - i)));
    const auto first = stamp.find(','),
               second = first == std::string::npos ? first : stamp.find(',', first + 1);
    if (second != std::string::npos) stamp.erase(second, 1);
    if (const auto t = base::parse_date_time(stamp)) return t;
  }
  return std::nullopt;
}

/// What one cue says, and in which dialect.
struct Reading {
  Sample sample;
  std::string dialect;
  bool undefined_altitude = false;  ///< "[altitude: x]"
};

void set_attitude(Sample& s, std::string_view text, std::string_view key, bool gimbal) {
  const auto items = members(text, key);
  if (items.size() != 3) return;
  (gimbal ? s.gimbal_pitch_deg : s.pitch_deg) = items[0].value;
  (gimbal ? s.gimbal_roll_deg : s.roll_deg) = items[1].value;
  (gimbal ? s.gimbal_heading_deg : s.yaw_deg) = items[2].value;
}

/// Dialects D' to H: "[latitude: 41.4] [longitude: 2.2] [rel_alt: 20.160 abs_alt: 169.523] [gb_yaw: ..]".
std::optional<Reading> read_bracketed(std::string_view text) {
  Reading r;
  r.sample.latitude_deg = keyed(text, "latitude");
  r.sample.longitude_deg = keyed(text, "longitude");
  const bool misspelt = std::isnan(r.sample.longitude_deg);
  if (misspelt) r.sample.longitude_deg = keyed(text, "longtitude");
  r.sample.height_takeoff_m = keyed(text, "rel_alt");
  r.undefined_altitude = !std::isnan(keyed(text, "altitude"));
  r.sample.yaw_deg = keyed(text, "drone_yaw");
  r.sample.pitch_deg = keyed(text, "drone_pitch");
  r.sample.roll_deg = keyed(text, "drone_roll");
  r.sample.gimbal_heading_deg = keyed(text, "gb_yaw");
  r.sample.gimbal_pitch_deg = keyed(text, "gb_pitch");
  r.sample.gimbal_roll_deg = keyed(text, "gb_roll");
  if (std::isnan(r.sample.latitude_deg) && std::isnan(r.sample.height_takeoff_m)) return std::nullopt;
  if (!std::isnan(r.sample.yaw_deg))
    r.dialect = "G'";
  else if (!std::isnan(r.sample.gimbal_pitch_deg))
    r.dialect = text.find("FrameId") != std::string_view::npos ? "H" : "G";
  else if (!std::isnan(r.sample.height_takeoff_m))
    r.dialect = "F";
  else
    r.dialect = misspelt ? "D'" : "E";
  return r;
}

/// Dialect B and its kin: "F/3.2, SS 160, ISO 100, EV 0, GPS (8.2090, 47.4692, 18), D 49.21m, H 45.60m, H.S
/// 0.00m/s, V.S 0.00m/s".
std::optional<Reading> read_f_line(std::string_view text) {
  auto place = members(text, "GPS");
  if (place.empty()) place = members(text, "RTK");
  Reading r;
  r.sample.height_takeoff_m = spaced(text, "H");
  if (place.size() < 2 || std::isnan(r.sample.height_takeoff_m)) return std::nullopt;
  r.sample.longitude_deg = place[0].value;
  r.sample.latitude_deg = place[1].value;
  r.sample.speed_mps = spaced(text, "H.S");
  set_attitude(r.sample, text, "F.PRY", false);
  set_attitude(r.sample, text, "G.PRY", true);
  if (text.find("LeCurve") != std::string_view::npos)
    r.dialect = "J";
  else if (text.find("G.PRY") != std::string_view::npos)
    r.dialect = "B\"";
  else if (text.find("DZOOM") != std::string_view::npos || std::isnan(r.sample.speed_mps))
    r.dialect = "B'";
  else
    r.dialect = "B";
  return r;
}

/// Dialects A (lon, lat, satellites) and C (lat, lon, metres): "GPS(149.0251,-20.2533,16) BAROMETER:1.9".
std::optional<Reading> read_barometer(std::string_view text) {
  const auto place = members(text, "GPS");
  if (place.size() < 2) return std::nullopt;
  Reading r;
  r.sample.height_takeoff_m = keyed(text, "BAROMETER");
  const auto bracketed = members(text, "BAROMETER");
  const double hb_m = keyed(text, "Hb");
  bool latitude_first = false;
  if (!std::isnan(hb_m)) {
    r.sample.height_takeoff_m = hb_m;
    r.dialect = "A'";
  } else if (bracketed.size() == 1) {
    r.sample.height_takeoff_m = bracketed[0].value;
    r.dialect = "C'";
    latitude_first = true;
  } else if (!std::isnan(r.sample.height_takeoff_m)) {
    latitude_first = place.size() > 2 && place[2].metres;
    r.dialect = latitude_first ? "C" : "A";
  } else {
    return std::nullopt;
  }
  r.sample.longitude_deg = place[latitude_first ? 1 : 0].value;
  r.sample.latitude_deg = place[latitude_first ? 0 : 1].value;
  return r;
}

std::optional<Reading> read_cue(std::string_view text) {
  if (auto reading = read_bracketed(text)) return reading;
  if (auto reading = read_f_line(text)) return reading;
  return read_barometer(text);
}

/// A newer value than this ago is taken as held, not as still: the slowest field seen is renewed at 1.4 Hz.
constexpr base::Nanoseconds kLongestHold_ns = base::kNanosecondsPerSecond;

/// Cues come faster than the values in them (60 against 7 a second): between two changes less than
/// kLongestHold_ns apart the value goes straight instead of standing and jumping.
void bridge_holds(std::vector<Sample>& samples, double Sample::*field) {
  for (std::size_t begin = 0; begin < samples.size();) {
    const double held = samples[begin].*field;
    std::size_t end = begin + 1;
    while (end < samples.size() && samples[end].*field == held) ++end;
    if (end < samples.size() && end - begin > 1) {
      const base::Nanoseconds start_ns = samples[begin].t_log_ns, span_ns = samples[end].t_log_ns - start_ns;
      const double step = samples[end].*field - held;
      const bool bridges = std::isfinite(step) && span_ns > 0 && span_ns <= kLongestHold_ns;
      for (std::size_t i = begin + 1; bridges && i < end; ++i)
        samples[i].*field =
            held + step * static_cast<double>(samples[i].t_log_ns - start_ns) / static_cast<double>(span_ns);
    }
    begin = end;
  }
}

/// Why a file of cues holds no position, as far as its text tells.
Error no_position(const std::string& name, const std::vector<Cue>& cues) {
  std::string reason = "none with a position or a height";
  const std::string_view first = cues.front().text;
  if (first.find("uavBat") != std::string_view::npos)
    reason += " (the recording of DJI goggles holds none)";
  else if (first.find("DiffTime") != std::string_view::npos)
    reason += " (the first Mavic Air writes camera settings only)";
  return {"telemetry_empty", name, std::to_string(cues.size()) + " subtitles, " + reason,
          "a DJI video subtitle file with GPS", "Use the flight record of the same flight."};
}

}  // namespace

Result<Track> read_dji_srt(std::string_view text, const std::string& name) {
  const auto cues = cut_cues(text);
  if (cues.empty())
    return Error{"telemetry_format_unknown", name, "no subtitle with a time code",
                 "\"00:00:00,000 --> 00:00:00,033\" lines", ""};
  Track track;
  track.source = name;
  track.format = "dji_srt";
  std::vector<int> lines;
  std::size_t unread = 0, undefined_altitudes = 0;
  int first_unread = 0;
  for (const Cue& cue : cues) {
    auto reading = read_cue(cue.text);
    if (!reading) {
      if (unread++ == 0) first_unread = cue.line;
      continue;
    }
    if (track.variant.empty()) track.variant = reading->dialect;
    if (reading->undefined_altitude) ++undefined_altitudes;
    reading->sample.t_log_ns = cue.start_ns;
    reading->sample.t_local_ns = wall_clock(cue.text);
    reading->sample.is_video = true;
    track.samples.push_back(reading->sample);
    lines.push_back(cue.line);
  }
  if (track.samples.empty()) return no_position(name, cues);
  if (unread > 0)
    track.warnings.push_back("no position and no height in " + reader::rows_text(unread, first_unread) +
                             ": dropped");
  if (undefined_altitudes > 0)
    track.warnings.push_back("'altitude' has no defined zero in this dialect (" + track.variant +
                             "): not used as a height");
  if (track.variant == "C'")
    track.warnings.push_back("dialect C' is known from a hand-made sample only; check the first position");
  reader::finish(track, lines);
  for (const auto field :
       {&Sample::latitude_deg, &Sample::longitude_deg, &Sample::height_takeoff_m, &Sample::speed_mps})
    bridge_holds(track.samples, field);
  return track;
}

}  // namespace furrow::telemetry
