#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "furrow/stats/robust.h"
#include "furrow/telemetry/formats.h"
#include "reader_tools.h"
#include "sonar.h"

namespace furrow::telemetry {
namespace {

constexpr std::size_t kPrefixBytes = 12;
constexpr int kFirstWithDetails = 6;  // from here 100 bytes stand before the records
constexpr int kFirstScrambled = 7;
constexpr int kFirstWithLongHeader = 12;
constexpr int kFirstEncrypted = 13;
constexpr int kLargestVersion = 64;
constexpr unsigned char kRecordEnd = 0xFF;
/// The vision height is one byte in decimetres; 255 is "nothing seen".
constexpr double kVisionCeiling_m = 25.4;

enum RecordType : unsigned char { kOsd = 1, kGimbal = 3, kCustom = 5 };

/// Little-endian number at `at`; the caller has checked the length.
template <class Word>
Word little_endian(std::string_view bytes, std::size_t at) {
  std::uint64_t word = 0;
  for (std::size_t i = sizeof(Word); i-- > 0;) word = (word << 8) | static_cast<unsigned char>(bytes[at + i]);
  return static_cast<Word>(word);
}
double tenths(std::string_view bytes, std::size_t at) {
  return little_endian<std::int16_t>(bytes, at) / 10.0;
}
double angle_deg(std::string_view bytes, std::size_t at) {
  return std::bit_cast<double>(little_endian<std::uint64_t>(bytes, at)) * 180.0 / std::numbers::pi;
}
unsigned char byte_at(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}

/// CRC-64 of Jones (the one Redis uses), reflected, from `start`.
std::uint64_t crc64(std::uint64_t start, std::uint64_t data) {
  constexpr std::uint64_t kReflectedPolynomial = 0x95AC9329AC4BC9B5U;
  std::uint64_t crc = start;
  for (int i = 0; i < 8; ++i) {
    crc ^= (data >> (8 * i)) & 255U;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1) ^ kReflectedPolynomial : crc >> 1;
  }
  return crc;
}

/// Payload of versions 7 to 12 in the clear: its first byte seeds the key.
std::string unscrambled(unsigned char type, std::string_view payload) {
  if (payload.empty()) return {};
  const std::uint64_t seed = byte_at(payload, 0);
  constexpr std::uint64_t kMagic = 0x123456789ABCDEF0U;
  const std::uint64_t key = crc64((seed + type) & 255U, kMagic * seed);
  std::string clear(payload.substr(1));
  for (std::size_t i = 0; i < clear.size(); ++i)
    clear[i] =
        static_cast<char>(byte_at(clear, i) ^ static_cast<unsigned char>((key >> (8 * (i % 8))) & 255U));
  return clear;
}

struct Header {
  int version = 0;
  std::size_t begin = 0, end = 0;  ///< of the records
};

std::optional<Header> read_header(std::string_view bytes) {
  if (bytes.size() < kPrefixBytes) return std::nullopt;
  Header header;
  header.version = byte_at(bytes, 10);
  const auto details = little_endian<std::uint64_t>(bytes, 0);
  if (header.version == 0 || header.version > kLargestVersion ||
      details > bytes.size() + (std::size_t{1} << 20))
    return std::nullopt;
  constexpr std::size_t kDetailsPrefix = 100, kLongHeader = 536;
  header.begin = header.version < kFirstWithDetails      ? kPrefixBytes
                 : header.version < kFirstWithLongHeader ? kDetailsPrefix
                                                         : kLongHeader;
  header.end = header.version < kFirstWithLongHeader ? static_cast<std::size_t>(details) : bytes.size();
  // A file cut short still gives its records.
  header.end = std::min(header.end, bytes.size());
  return header;
}

/// What is gathered from the records.
struct Gathered {
  Track track;
  std::vector<int> records;  ///< number of the OSD record, in place of a line
  std::vector<double> utc_less_log_s;
  base::Nanoseconds first_utc_less_log_ns = 0;
  int osd = 0, senseless = 0;
  base::Nanoseconds turns_ns = 0;  ///< of the fly-time counter
};

/// Offsets inside OSD: TELEMETRY facts in docs/telemetry.md.
void add_osd(std::string_view p, Gathered& g) {
  constexpr std::size_t kLeastBytes = 44;
  if (p.size() < kLeastBytes) return;
  ++g.osd;
  Sample s;
  s.longitude_deg = angle_deg(p, 0);
  s.latitude_deg = angle_deg(p, 8);
  if (!(std::abs(s.longitude_deg) <= 180.0 && std::abs(s.latitude_deg) <= 90.0)) ++g.senseless;
  s.height_takeoff_m = tenths(p, 16);
  s.speed_mps = std::hypot(tenths(p, 18), tenths(p, 20));
  s.pitch_deg = tenths(p, 24);
  s.roll_deg = tenths(p, 26);
  s.yaw_deg = tenths(p, 28);
  constexpr unsigned char kVisionWorks = 0x10;
  if ((byte_at(p, 32) & kVisionWorks) != 0) s.height_vps_m = byte_at(p, 41) / 10.0;
  constexpr base::Nanoseconds kTick_ns = base::kNanosecondsPerSecond / 10, kTurn_ns = 65536 * kTick_ns;
  s.t_log_ns = little_endian<std::uint16_t>(p, 42) * kTick_ns + g.turns_ns;
  if (!g.track.samples.empty() && g.track.samples.back().t_log_ns - s.t_log_ns > kTurn_ns / 2) {
    g.turns_ns += kTurn_ns;
    s.t_log_ns += kTurn_ns;
  }
  g.track.samples.push_back(s);
  g.records.push_back(g.osd);
}

void add_gimbal(std::string_view p, Gathered& g) {
  if (p.size() < 6 || g.track.samples.empty()) return;
  Sample& s = g.track.samples.back();
  s.gimbal_pitch_deg = tenths(p, 0);
  s.gimbal_roll_deg = tenths(p, 2);
  s.gimbal_heading_deg = tenths(p, 4);
}

void add_custom(std::string_view p, Gathered& g) {
  if (p.size() < 18 || g.track.samples.empty()) return;
  Sample& s = g.track.samples.back();
  s.is_photo = byte_at(p, 0) != 0;
  s.is_video = byte_at(p, 1) != 0;
  const auto utc_ms = little_endian<std::int64_t>(p, 10);
  constexpr std::int64_t kYear2000_ms = 946684800000, kYear2200_ms = 7258118400000;
  if (utc_ms < kYear2000_ms || utc_ms > kYear2200_ms) return;
  const base::Nanoseconds difference_ns = utc_ms * 1'000'000 - s.t_log_ns;
  if (g.utc_less_log_s.empty()) g.first_utc_less_log_ns = difference_ns;
  g.utc_less_log_s.push_back(base::ns_to_seconds(difference_ns - g.first_utc_less_log_ns));
}

/// Walks the records; what is no record is stepped over, pictures at once.
std::size_t gather(std::string_view bytes, const Header& header, Gathered& g) {
  std::size_t skipped = 0, at = header.begin;
  while (at + 2 < header.end) {
    const unsigned char type = byte_at(bytes, at), length = byte_at(bytes, at + 1);
    constexpr unsigned char kPictureStart = 0xD8;
    if (type == kRecordEnd && length == kPictureStart) {
      const auto picture_end = bytes.find("\xFF\xD9", at);
      if (picture_end == std::string_view::npos || picture_end + 2 > header.end) break;
      at = picture_end + 2;
      continue;
    }
    const std::size_t end = at + 2 + length;
    if (end >= header.end || byte_at(bytes, end) != kRecordEnd) {
      ++skipped;
      ++at;
      continue;
    }
    const std::string_view raw = bytes.substr(at + 2, length);
    const std::string clear = header.version >= kFirstScrambled ? unscrambled(type, raw) : std::string(raw);
    if (type == kOsd) add_osd(clear, g);
    if (type == kGimbal) add_gimbal(clear, g);
    if (type == kCustom) add_custom(clear, g);
    at = end + 1;
  }
  return skipped;
}

}  // namespace

Result<Track> read_dji_txt(std::string_view bytes, const std::string& name) {
  const auto header = read_header(bytes);
  if (!header)
    return Error{"telemetry_format_unknown", name, "no flight record header", "a DJI flight record", ""};
  const std::string version = "version " + std::to_string(header->version);
  if (header->version >= kFirstEncrypted)
    return Error{"telemetry_encrypted", name,
                 "a DJI flight record of " + version + ", whose records are encrypted",
                 "version 12 or earlier", "Export it as CSV with AirData or PhantomHelp."};
  Gathered g;
  const std::size_t skipped = gather(bytes, *header, g);
  if (g.track.samples.empty())
    return Error{"telemetry_empty", name, "a DJI flight record of " + version + " without a position record",
                 "at least one", ""};
  if (2 * g.senseless > g.osd)
    return Error{"telemetry_encrypted", name,
                 "a DJI flight record of " + version + " whose positions make no sense", "readable records",
                 "Export it as CSV with AirData or PhantomHelp."};
  Track track = std::move(g.track);
  track.source = name;
  track.format = "dji_txt";
  track.variant = version;
  if (skipped > 0)
    track.warnings.push_back(std::to_string(skipped) + " bytes between the records could not be read");
  if (!g.utc_less_log_s.empty()) {
    const base::Nanoseconds offset_ns =
        g.first_utc_less_log_ns + base::seconds_to_ns(stats::median(g.utc_less_log_s));
    for (Sample& s : track.samples) s.t_utc_ns = s.t_log_ns + offset_ns;
    track.utc_sigma_s = stats::mad_sigma(g.utc_less_log_s);
  }
  reader::clear_constant_gimbal(track);
  reader::finish(track, g.records);
  distrust_held_sonar(track, {.ceiling_m = kVisionCeiling_m});
  return track;
}

}  // namespace furrow::telemetry
