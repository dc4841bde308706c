#pragma once
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "furrow/image/image.h"

/// A Matroska file of JPEG pictures, each with its own time: the smallest container in which a test can say
/// when a picture was taken (RFC 9559).
namespace furrow::image::matroska {

inline std::string big_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>((value >> (8 * i)) & 0xFFU);
  return text;
}

/// An element: id, length in eight bytes, content.
inline std::string element(std::uint32_t id, const std::string& content) {
  const int id_bytes = id > 0xFFFFFF ? 4 : id > 0xFFFF ? 3 : id > 0xFF ? 2 : 1;
  return big_endian(id, id_bytes) + '\x01' + big_endian(content.size(), 7) + content;
}
inline std::string number(std::uint32_t id, std::uint64_t value) {
  return element(id, big_endian(value, 8));
}

inline std::string video(const std::vector<Image>& pictures, const std::vector<int>& times_ms) {
  std::string blocks = number(0xE7, 0);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    blocks += element(0xA3, '\x81' + big_endian(static_cast<std::uint64_t>(times_ms[i]), 2) + '\x80' +
                                encode_image(pictures[i], ".jpg"));
  }
  const std::string size = number(0xB0, static_cast<std::uint64_t>(pictures[0].width)) +
                           number(0xBA, static_cast<std::uint64_t>(pictures[0].height));
  const std::string track =
      number(0xD7, 1) + number(0x73C5, 1) + number(0x83, 1) + element(0x86, "V_MJPEG") + element(0xE0, size);
  const std::string info =
      number(0x2AD7B1, 1'000'000) + element(0x4D80, "test") + element(0x5741, "test") +
      element(0x4489, big_endian(std::bit_cast<std::uint64_t>(times_ms.back() + 40.0), 8));
  return element(0x1A45DFA3, number(0x4286, 1) + number(0x42F7, 1) + number(0x42F2, 4) + number(0x42F3, 8) +
                                 element(0x4282, "matroska") + number(0x4287, 4) + number(0x4285, 2)) +
         element(0x18538067, element(0x1549A966, info) + element(0x1654AE6B, element(0xAE, track)) +
                                 element(0x1F43B675, blocks));
}

}  // namespace furrow::image::matroska
