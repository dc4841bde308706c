#include <cstdint>

#include "furrow/image/image.h"

namespace furrow::image {
namespace {

/// Numbers at places of a string, in the order of bytes that it uses; 0 beyond its end.
struct Numbers {
  const std::string& bytes;
  bool big_endian;

  std::size_t of(std::size_t at, std::size_t size) const {
    if (at > bytes.size() || size > bytes.size() - at) return 0;
    std::size_t out = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const auto byte = static_cast<unsigned char>(bytes[at + (big_endian ? i : size - 1 - i)]);
      out = (out << 8U) | byte;
    }
    return out;
  }
};

/// Orientation in the first directory of a TIFF header that starts at `start` (TIFF 6.0, section 2).
int orientation_in_tiff(const std::string& bytes, std::size_t start) {
  const Numbers read{bytes, bytes.compare(start, 2, "MM") == 0};
  const std::size_t directory = start + read.of(start + 4, 4), entries = read.of(directory, 2);
  constexpr std::size_t kEntryBytes = 12, kOrientation = 0x0112, kTurns = 8;
  for (std::size_t i = 0; i < entries; ++i) {
    const std::size_t entry = directory + 2 + i * kEntryBytes;
    if (read.of(entry, 2) != kOrientation) continue;
    const std::size_t value = read.of(entry + 8, 2);
    return value >= 1 && value <= kTurns ? static_cast<int>(value) : 1;
  }
  return 1;
}

}  // namespace

int exif_orientation(const std::string& bytes) {
  if (!bytes.starts_with("\xFF\xD8")) return 1;
  const Numbers read{bytes, true};
  const std::string mark("Exif\0\0", 6);
  // Segments: a marker, then a length that counts itself; the picture's data begin with FFDA.
  constexpr std::size_t kApp1 = 0xFFE1, kStartOfScan = 0xFFDA, kFewest = 2;
  for (std::size_t at = 2; at + 4 <= bytes.size();) {
    const std::size_t marker = read.of(at, 2), length = read.of(at + 2, 2);
    if (marker == kStartOfScan || length < kFewest || (marker >> 8U) != 0xFF) return 1;
    if (marker == kApp1 && bytes.compare(at + 4, mark.size(), mark) == 0)
      return orientation_in_tiff(bytes, at + 4 + mark.size());
    at += 2 + length;
  }
  return 1;
}

}  // namespace furrow::image
