#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::image {

/// 8-bit picture, rows from top to bottom, channels interleaved: 1 = grey, 3 = R G B. Pixel (0, 0) is the
/// centre of the top-left one.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<std::uint8_t> data;  ///< width * height * channels

  bool empty() const { return data.empty(); }
  std::size_t offset(int u, int v) const {
    return (static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u)) *
           static_cast<std::size_t>(channels);
  }
  const std::uint8_t* at(int u, int v) const { return data.data() + offset(u, v); }
  std::uint8_t* at(int u, int v) { return data.data() + offset(u, v); }
};

/// Black picture of that size. Sizes must be positive, channels 1 or 3.
Image make_image(int width, int height, int channels);

/// Reads a picture as RGB (grey becomes three equal channels, alpha is dropped; 16 bit is scaled to 8, by
/// the 10, 12, 14 or 16 bits that its values fill). The EXIF orientation is NOT applied: a camera model
/// belongs to the sensor's own pixels. Errors: file_missing, picture_unreadable (not a picture, or cut
/// short), picture_too_large (over 200 megapixels).
Result<Image> read_image(const std::filesystem::path& file);

/// The same from a file's bytes; `name` stands in messages.
Result<Image> decode_image(const std::string& bytes, const std::string& name);

/// How a JPEG asks to be turned when shown: EXIF orientation, 1 (not at all) to 8; 1 where it says nothing.
int exif_orientation(const std::string& bytes);

/// Encodes and writes atomically; the extension (.png, .jpg) chooses the format. `jpeg_quality` 1 to 100.
Status write_image(const std::filesystem::path& file, const Image& picture, int jpeg_quality = 95);

/// Encoded bytes; `extension` ".png" or ".jpg". Same pixels, same bytes.
std::string encode_image(const Image& picture, const std::string& extension, int jpeg_quality = 95);

/// Rec. 601 luma; a grey picture is returned as it is.
Image to_grey(const Image& picture);

/// Area-averaged (smaller) or bilinear (larger) copy of that size.
Image resize(const Image& picture, int width, int height);

/// The part of that size whose top-left pixel is (left, top); it must lie within the picture.
Image crop(const Image& picture, int left, int top, int width, int height);

}  // namespace furrow::image

namespace furrow {
using image::Image;
}
