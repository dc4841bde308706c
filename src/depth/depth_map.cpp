#include "furrow/depth/depth_map.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>

#include "furrow/base/file.h"
#include "furrow/base/text.h"

namespace furrow::depth {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
/// Larger than any camera's picture; guards against a header that lies.
constexpr std::int64_t kMostPixels = 200'000'000;

Error unreadable(const std::string& name, const std::string& found, const std::string& wanted) {
  return Error{"depth_map_unreadable", name, found, wanted, ""};
}

float known_or_nan(double value) {
  return std::isfinite(value) && value > 0.0 ? static_cast<float>(value) : kUnknown;
}

/// One number of type T from bytes that may be of the other endianness.
template <class T>
double number_at(const char* bytes, bool swapped) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swapped) std::reverse(raw.begin(), raw.end());
  T value;
  std::memcpy(&value, raw.data(), sizeof(T));
  return static_cast<double>(value);
}

/// What a .npy header says of its numbers.
struct NpyHeader {
  char kind = 'f';  ///< f float, u unsigned, i signed
  std::size_t bytes = 4;
  bool swapped = false;
  std::vector<std::int64_t> shape;
};

/// The text between `key` and the next of `ends`.
std::string after(const std::string& header, const std::string& key, const std::string& ends) {
  const auto at = header.find(key);
  if (at == std::string::npos) return "";
  const auto start = at + key.size();
  return header.substr(start, header.find_first_of(ends, start) - start);
}

std::optional<NpyHeader> parse_header(const std::string& header) {
  const std::string type = after(header, "'descr': '", "'");
  if (type.size() != 3 || header.find("'fortran_order': False") == std::string::npos) return std::nullopt;
  NpyHeader npy;
  npy.kind = type[1];
  npy.bytes = static_cast<std::size_t>(type[2] - '0');
  const bool little = std::endian::native == std::endian::little;
  npy.swapped = npy.bytes > 1 && (type[0] == '>') == little;
  const std::string sizes = after(header, "'shape': (", ")");
  for (const std::string_view size : base::split(sizes, ',')) {
    if (base::trim(size).empty()) continue;  // "(480,)" ends with a comma
    const auto length = base::parse_int(size);
    if (!length) return std::nullopt;
    npy.shape.push_back(*length);
  }
  while (npy.shape.size() > 2 && npy.shape.front() == 1) npy.shape.erase(npy.shape.begin());
  const bool known = (npy.kind == 'f' && (npy.bytes == 4 || npy.bytes == 8)) ||
                     (npy.kind == 'u' && (npy.bytes == 1 || npy.bytes == 2));
  if (!known || npy.shape.size() != 2) return std::nullopt;
  return npy;
}

double npy_number(const char* at, const NpyHeader& npy) {
  if (npy.kind == 'f')
    return npy.bytes == 4 ? number_at<float>(at, npy.swapped) : number_at<double>(at, npy.swapped);
  return npy.bytes == 1 ? number_at<std::uint8_t>(at, false) : number_at<std::uint16_t>(at, npy.swapped);
}

Result<DepthMap> decode_npy(const std::string& bytes, const std::string& name, double unit_per_count) {
  static const std::string kWanted = "a .npy of two axes, floats or unsigned integers, rows first";
  constexpr std::size_t kPrefix = 10;  // magic, version, length of the header (version 1)
  if (bytes.size() < kPrefix || bytes.compare(0, 6, "\x93NUMPY") != 0)
    return unreadable(name, "no NumPy header", kWanted);
  const auto byte = [&](std::size_t i) {
    return static_cast<std::size_t>(static_cast<unsigned char>(bytes[i]));
  };
  const bool long_header = byte(6) >= 2;
  const std::size_t start = long_header ? kPrefix + 2 : kPrefix;
  if (bytes.size() < start) return unreadable(name, "the header is cut short", kWanted);
  const std::size_t length =
      byte(8) + (byte(9) << 8U) + (long_header ? (byte(10) << 16U) + (byte(11) << 24U) : 0);
  if (bytes.size() - start < length) return unreadable(name, "the header is cut short", kWanted);
  const auto npy = parse_header(bytes.substr(start, length));
  if (!npy) return unreadable(name, bytes.substr(start, std::min<std::size_t>(length, 120)), kWanted);
  const std::int64_t rows = npy->shape[0], columns = npy->shape[1];
  const bool sane = rows > 0 && columns > 0 && rows <= kMostPixels && columns <= kMostPixels / rows;
  if (!sane || bytes.size() - start - length < static_cast<std::size_t>(rows * columns) * npy->bytes)
    return unreadable(name, std::to_string(rows) + " x " + std::to_string(columns) + " numbers announced",
                      "as many numbers as its header says");
  DepthMap map{static_cast<int>(columns), static_cast<int>(rows), {}};
  const double unit = npy->kind == 'f' ? 1.0 : unit_per_count;
  const char* at = bytes.data() + start + length;
  for (std::int64_t i = 0; i < rows * columns; ++i, at += npy->bytes)
    map.values.push_back(known_or_nan(unit * npy_number(at, *npy)));
  return map;
}

/// Portable float map: rows from bottom to top, a negative scale says little-endian.
Result<DepthMap> decode_pfm(const std::string& bytes, const std::string& name) {
  std::istringstream text(bytes.substr(0, 128));
  std::string magic;
  std::int64_t width = 0, height = 0;
  double scale = 0.0;
  text >> magic >> width >> height >> scale;
  const bool sane = text.good() && magic == "Pf" && width > 0 && height > 0 && width <= kMostPixels &&
                    height <= kMostPixels / width && scale != 0.0;
  if (!sane) return unreadable(name, "its first line is '" + magic + "'", "a .pfm of one channel (Pf)");
  const std::size_t start = static_cast<std::size_t>(text.tellg()) + 1;
  const std::size_t count = static_cast<std::size_t>(width * height);
  if (bytes.size() < start || bytes.size() - start < count * sizeof(float))
    return unreadable(name, "cut short", "as many numbers as its header says");
  DepthMap map{static_cast<int>(width), static_cast<int>(height), std::vector<float>(count)};
  const bool swapped = (scale < 0.0) != (std::endian::native == std::endian::little);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t columns = static_cast<std::size_t>(width), row = count / columns - 1 - i / columns;
    map.values[row * columns + i % columns] =
        known_or_nan(number_at<float>(bytes.data() + start + i * sizeof(float), swapped));
  }
  return map;
}

Result<DepthMap> decode_png(const std::string& bytes, const std::string& name, double unit_per_count) {
  static const std::string kWanted = "a grey PNG of 16 or 8 bits";
  const std::vector<unsigned char> raw(bytes.begin(), bytes.end());
  cv::Mat picture;
  try {
    if (!raw.empty()) picture = cv::imdecode(raw, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& problem) {  // a header that lies about the size, say
    return unreadable(name, "the picture cannot be decoded: " + problem.err, kWanted);
  }
  if (picture.empty() || picture.channels() != 1 || (picture.depth() != CV_16U && picture.depth() != CV_8U)) {
    return unreadable(name, picture.empty() ? "no picture" : std::to_string(picture.channels()) + " channels",
                      kWanted);
  }
  picture.convertTo(picture, CV_32F, unit_per_count);
  DepthMap map{picture.cols, picture.rows, {}};
  for (int v = 0; v < picture.rows; ++v) {
    for (int u = 0; u < picture.cols; ++u)
      map.values.push_back(known_or_nan(static_cast<double>(picture.at<float>(v, u))));
  }
  return map;
}

}  // namespace

Result<DepthMap> decode_depth_map(const std::string& bytes, const std::string& name, double unit_per_count) {
  if (name.ends_with(".npy")) return decode_npy(bytes, name, unit_per_count);
  if (name.ends_with(".pfm")) return decode_pfm(bytes, name);
  if (name.ends_with(".png")) return decode_png(bytes, name, unit_per_count);
  return unreadable(name, "another extension", ".npy, .pfm or .png");
}

Result<DepthMap> read_depth_map(const std::filesystem::path& file, double unit_per_count) {
  FURROW_TRY(const std::string bytes, base::read_file(file));
  return decode_depth_map(bytes, file.filename().string(), unit_per_count);
}

}  // namespace furrow::depth
