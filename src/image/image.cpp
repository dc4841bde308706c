#include "furrow/image/image.h"

#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "furrow/base/file.h"
#include "image/mat.h"

namespace furrow::image {
namespace {

constexpr std::int64_t kMaxPixels = 200'000'000;

Error unreadable(const std::string& name, const std::string& found) {
  return {"picture_unreadable", name, found, "a whole JPEG, PNG or TIFF picture", ""};
}

/// JPEG decoders fill what is missing with grey and go on; a picture that lacks its end marker was cut short.
bool is_cut_short(const std::string& bytes) {
  if (!bytes.starts_with("\xFF\xD8")) return false;
  // Some cameras append data after the end marker, so it is looked for from behind, anywhere in the last
  // half.
  const auto end = bytes.rfind("\xFF\xD9");
  return end == std::string::npos || end < bytes.size() / 2;
}

cv::Mat to_8_bit(const cv::Mat& mat) {
  if (mat.depth() == CV_8U) return mat;
  cv::Mat result;
  if (mat.depth() == CV_16U) {
    // Sensors of 10 to 14 bits are stored as they are; by 16 bits they would be nearly black.
    double most = 0.0;
    cv::minMaxLoc(mat.reshape(1), nullptr, &most);
    int bits = 10;
    while (bits < 16 && most > (1 << bits) - 1) bits += 2;
    mat.convertTo(result, CV_8U, 255.0 / ((1 << bits) - 1));
  } else {
    cv::normalize(mat, result, 0, 255, cv::NORM_MINMAX, CV_8U);
  }
  return result;
}

}  // namespace

Image make_image(int width, int height, int channels) {
  check(width > 0 && height > 0 && (channels == 1 || channels == 3),
        "a picture's size must be positive, its channels 1 or 3");
  Image picture{width, height, channels, {}};
  picture.data.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                      static_cast<std::size_t>(channels));
  return picture;
}

Result<Image> decode_image(const std::string& bytes, const std::string& name) {
  if (bytes.empty()) return unreadable(name, "the file is empty");
  if (is_cut_short(bytes))
    return unreadable(name, "the JPEG ends before its end marker: the file is cut short");
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  cv::Mat mat;
  try {
    mat = cv::imdecode(cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())),
                       cv::IMREAD_COLOR | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& problem) {
    return unreadable(name, "the picture cannot be decoded: " + problem.err);
  }
  if (mat.empty()) return unreadable(name, "the content is no picture that can be decoded");
  if (is_cut_short(bytes))
    return unreadable(name, "the JPEG ends before its end marker: the file is cut short");
  if (std::int64_t{mat.cols} * mat.rows > kMaxPixels) {
    return Error{"picture_too_large", name,
                 std::to_string(mat.cols) + "x" + std::to_string(mat.rows) + " pixels",
                 "at most 200 megapixels", ""};
  }
  cv::Mat rgb;
  cv::cvtColor(to_8_bit(mat), rgb, cv::COLOR_BGR2RGB);
  return from_mat(rgb);
}

Result<Image> read_image(const std::filesystem::path& file) {
  FURROW_TRY(const std::string bytes, base::read_file(file));
  return decode_image(bytes, file.string());
}

std::string encode_image(const Image& picture, const std::string& extension, int jpeg_quality) {
  check(!picture.empty(), "encode_image of an empty picture");
  cv::Mat bgr;  // not a view of the picture, or the conversion would write into it
  if (picture.channels == 3) {
    cv::cvtColor(view(picture), bgr, cv::COLOR_RGB2BGR);
  } else {
    bgr = view(picture);
  }
  std::vector<std::uint8_t> bytes;
  const std::vector<int> options = extension == ".png"
                                       ? std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 6}
                                       : std::vector<int>{cv::IMWRITE_JPEG_QUALITY, jpeg_quality};
  check(cv::imencode(extension, bgr, bytes, options), "encode_image: the extension must be .png or .jpg");
  return {bytes.begin(), bytes.end()};
}

Status write_image(const std::filesystem::path& file, const Image& picture, int jpeg_quality) {
  return base::write_file(file, encode_image(picture, file.extension().string(), jpeg_quality));
}

Image to_grey(const Image& picture) {
  if (picture.channels == 1) return picture;
  cv::Mat grey;
  cv::cvtColor(view(picture), grey, cv::COLOR_RGB2GRAY);
  return from_mat(grey);
}

Image resize(const Image& picture, int width, int height) {
  check(width > 0 && height > 0 && !picture.empty(), "resize: sizes must be positive");
  const bool shrinks = width <= picture.width && height <= picture.height;
  cv::Mat result;
  cv::resize(view(picture), result, {width, height}, 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  return from_mat(result);
}

Image crop(const Image& picture, int left, int top, int width, int height) {
  check(left >= 0 && top >= 0 && width > 0 && height > 0 && left <= picture.width - width && top <= picture.height - height,
        "crop: a part beyond the picture");
  Image out = make_image(width, height, picture.channels);
  const auto row_bytes = static_cast<std::ptrdiff_t>(width) * picture.channels;
  for (int v = 0; v < height; ++v) std::copy_n(picture.at(left, top + v), row_bytes, out.at(0, v));
  return out;
}

}  // namespace furrow::image
