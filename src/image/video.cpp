#include "furrow/image/video.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
// OpenCV 4.6 adds up constants of different enumerations, which C++20 calls old-fashioned.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-enum-enum-conversion"
#include <opencv2/videoio.hpp>
#pragma GCC diagnostic pop

extern "C" {
#include <libavutil/log.h>
}

#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "image/mat.h"
#include "image/quiet.h"

namespace furrow::image {
namespace {

namespace fs = std::filesystem;
using base::Nanoseconds;

constexpr std::array<const char*, 6> kPictureExtensions = {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".bmp"};

bool is_picture_file(const fs::path& file) {
  const std::string extension = base::to_lower(file.extension().string());
  return std::find(kPictureExtensions.begin(), kPictureExtensions.end(), extension) !=
         kPictureExtensions.end();
}

class PictureFiles final : public PictureSource {
 public:
  PictureFiles(std::vector<fs::path> files, std::string name, double rate_hz) : files_(std::move(files)) {
    info_ = {SourceKind::pictures, std::move(name), rate_hz, static_cast<std::int64_t>(files_.size())};
  }
  const SourceInfo& info() const override { return info_; }

  std::optional<TimedPicture> next() override {
    if (at_ >= info_.count) return std::nullopt;
    const fs::path& file = files_[static_cast<std::size_t>(at_)];
    TimedPicture picture;
    picture.index = at_++;
    picture.name = file.filename().string();
    picture.t_video_ns = base::seconds_to_ns(static_cast<double>(picture.index) / info_.nominal_rate_hz);
    auto read = read_image(file);
    if (read.ok()) {
      picture.picture = std::move(*read);
    } else {
      picture.error = read.error();
      picture.error->where = picture.name;  // outputs hold no absolute path
    }
    return picture;
  }

  std::vector<std::string> trouble() const override {
    if (at_ < 2) return {};
    return {"pictures have no times: " + base::format_double(info_.nominal_rate_hz) + " a second assumed"};
  }
  bool failed() const override { return false; }

 private:
  std::vector<fs::path> files_;
  SourceInfo info_;
  std::int64_t at_ = 0;
};

/// A video file, a camera or a stream through OpenCV.
class Capture final : public PictureSource {
 public:
  /// A copied cv::VideoCapture is the same capture.
  Capture(const cv::VideoCapture& capture, SourceInfo info) : capture_(capture), info_(std::move(info)) {}
  const SourceInfo& info() const override { return info_; }

  std::optional<TimedPicture> next() override {
    cv::Mat bgr;
    bool is_read = false;
    try {
      is_read = capture_.read(bgr) && !bgr.empty();
    } catch (const cv::Exception& problem) {
      note_ = problem.err;
    }
    if (!is_read) {
      has_ended_ = true;
      return std::nullopt;
    }
    TimedPicture picture;
    picture.index = at_++;
    picture.name = "picture " + std::to_string(at_);
    picture.t_video_ns = time_of(picture.index);
    picture.picture = make_image(bgr.cols, bgr.rows, 3);
    cv::Mat rgb = view(picture.picture);
    cv::cvtColor(bgr, rgb, bgr.channels() == 1 ? cv::COLOR_GRAY2RGB : cv::COLOR_BGR2RGB);
    return picture;
  }

  std::vector<std::string> trouble() const override {
    std::vector<std::string> sentences;
    // A decoder hands out the last pictures, which it held back for reordering, without their times (16 at
    // most: H.264, A.3.1); a nominal period apart they are right.
    constexpr std::int64_t kHeldBack = 16;
    if (made_up_ > kHeldBack) {
      sentences.push_back(std::to_string(made_up_) + " of " + std::to_string(at_) +
                          " pictures have no time of their own in the container: " +
                          base::format_double(info_.nominal_rate_hz) + " a second assumed for them");
    }
    if (!has_ended_) return sentences;
    if (info_.kind == SourceKind::live) {
      sentences.push_back("the camera gives no more pictures: unplugged, or taken by another program");
    } else if (is_short()) {
      sentences.push_back("the video ends after picture " + std::to_string(at_) + " of the " +
                          std::to_string(info_.count) + " that its container speaks of: it was cut short");
    }
    if (!note_.empty()) sentences.push_back("the decoder says: " + note_);
    return sentences;
  }
  bool failed() const override { return has_ended_ && info_.kind == SourceKind::live; }

 private:
  /// Containers often miss their count by one or two, and estimate it where they hold none.
  bool is_short() const {
    const auto missing = static_cast<double>(info_.count - at_);
    return info_.count > 0 && missing > std::max(2.0, 0.02 * static_cast<double>(info_.count));
  }

  /// The container's time. Where it stands still: for a camera what the clock says, else a nominal period
  /// after the picture before.
  Nanoseconds time_of(std::int64_t index) {
    const double ms = capture_.get(cv::CAP_PROP_POS_MSEC);
    const auto stated = std::isfinite(ms) ? base::seconds_to_ns(ms * 1e-3) : 0;
    if (index == 0) {
      first_stated_ = stated;
      started_ = std::chrono::steady_clock::now();
      return 0;
    }
    Nanoseconds t = stated - first_stated_;
    if (t <= last_ && info_.kind == SourceKind::live) {
      const auto since_start = std::chrono::steady_clock::now() - started_;
      t = std::max(last_ + 1, Nanoseconds{std::chrono::nanoseconds(since_start).count()});
    } else if (t <= last_) {
      ++made_up_;
      t = last_ + base::seconds_to_ns(1.0 / info_.nominal_rate_hz);
    }
    last_ = t;
    return t;
  }

  cv::VideoCapture capture_;
  SourceInfo info_;
  std::int64_t at_ = 0, made_up_ = 0;
  Nanoseconds first_stated_ = 0, last_ = 0;
  std::chrono::steady_clock::time_point started_;
  bool has_ended_ = false;
  std::string note_;
};

double rate_of(const cv::VideoCapture& capture, double assumed_hz) {
  constexpr double kFastest = 1000.0;  // containers without a rate state absurd ones, such as their time base
  const double stated = capture.get(cv::CAP_PROP_FPS);
  return std::isfinite(stated) && stated > 0.0 && stated <= kFastest ? stated : assumed_hz;
}

SourceInfo info_of(const cv::VideoCapture& capture, SourceKind kind, const std::string& what,
                   const SourceOptions& options) {
  SourceInfo info{kind, what, rate_of(capture, options.assumed_rate_hz), 0};
  const double count = capture.get(cv::CAP_PROP_FRAME_COUNT);
  if (kind == SourceKind::video && std::isfinite(count) && count > 0.0 && count < 1e9)
    info.count = static_cast<std::int64_t>(count);
  return info;
}

/// Cameras keep their own picture rate and buffer; one picture of buffer keeps what is steered by fresh.
Result<std::unique_ptr<PictureSource>> open_camera(const std::string& what, int number,
                                                   const SourceOptions& options) {
  cv::VideoCapture capture;
  try {
    capture.open(number, cv::CAP_V4L2);
  } catch (const cv::Exception&) {  // reported as a camera that is not there
  }
  if (!capture.isOpened())
    return Error{"source_unreadable", what, "no camera answers there", "a plugged-in camera that is free",
                 "'ls /dev/video*' lists cameras."};
  capture.set(cv::CAP_PROP_BUFFERSIZE, 1);
  SourceInfo info = info_of(capture, SourceKind::live, what, options);
  return std::unique_ptr<PictureSource>(new Capture(capture, std::move(info)));
}

Result<std::unique_ptr<PictureSource>> open_stream(const std::string& what, SourceKind kind,
                                                   const SourceOptions& options) {
  const int silence_ms = static_cast<int>(1e3 * options.silence_s);
  cv::VideoCapture capture;
  try {
    capture.open(what, cv::CAP_FFMPEG,
                 {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, silence_ms, cv::CAP_PROP_READ_TIMEOUT_MSEC, silence_ms});
  } catch (const cv::Exception&) {  // reported as unreadable
  }
  if (!capture.isOpened())
    return Error{"source_unreadable", what,
                 "FFmpeg finds no video in it, or its beginning or index is missing",
                 "a video file, a folder of pictures, a camera or a stream", ""};
  capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  SourceInfo info = info_of(capture, kind, what, options);
  return std::unique_ptr<PictureSource>(new Capture(capture, std::move(info)));
}

Result<std::vector<fs::path>> pictures_in(const fs::path& folder) {
  const auto all = base::expand_pattern("*", folder);
  std::vector<fs::path> files;
  if (all.ok()) files = *all;
  std::erase_if(files, [](const fs::path& file) { return !is_picture_file(file); });
  if (files.empty())
    return Error{"no_match", folder.string(), "the folder holds no picture",
                 "JPEG, PNG, TIFF or BMP files; folders inside are not entered", ""};
  return files;
}

bool has_wildcard(const fs::path& name) {
  return name.string().find_first_of("*?") != std::string::npos;
}

/// Whether a name can only be a pattern: there is no file of that very name.
bool is_pattern(const fs::path& name) {
  std::error_code unknown;
  return has_wildcard(name) && !fs::exists(name, unknown);
}

std::optional<int> camera_number(const std::string& what) {
  constexpr std::string_view kDevice = "/dev/video";
  const std::string_view digits =
      what.starts_with(kDevice) ? std::string_view(what).substr(kDevice.size()) : std::string_view(what);
  if (digits.empty() || digits.size() > 3 || digits.find_first_not_of("0123456789") != std::string_view::npos)
    return std::nullopt;
  return static_cast<int>(*base::parse_int(digits));
}

}  // namespace

void silence_libraries() {
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  av_log_set_callback([](void*, int, const char*, va_list) {});
}

Result<std::vector<fs::path>> picture_files(const std::vector<fs::path>& named) {
  std::vector<fs::path> files;
  for (const fs::path& one : named) {
    std::vector<fs::path> found{one};
    std::error_code unknown;  // what the file system refuses is named by its reader
    if (fs::is_directory(one, unknown)) {
      FURROW_TRY(found, pictures_in(one));
    } else if (is_pattern(one)) {
      if (has_wildcard(one.parent_path()))
        return Error{"no_match", one.string(), "a pattern in the name of a folder",
                     "* and ? in the last part of a name only",
                     "Without quotes the shell finds the folders."};
      FURROW_TRY(found, base::expand_pattern(one.string(), "."));
    }
    files.insert(files.end(), found.begin(), found.end());
  }
  return files;
}

std::unique_ptr<PictureSource> open_pictures(std::vector<fs::path> files, const SourceOptions& options) {
  check(options.assumed_rate_hz > 0.0, "open_pictures: the rate must be positive");
  const std::string name = files.empty() ? "" : files.front().parent_path().string();
  return std::make_unique<PictureFiles>(std::move(files), name, options.assumed_rate_hz);
}

Result<std::unique_ptr<PictureSource>> open_source(const std::string& what, const SourceOptions& options) {
  check(options.assumed_rate_hz > 0.0, "open_source: the rate must be positive");
  silence_libraries();
  std::error_code code;
  const auto status = fs::status(what, code);
  if (fs::is_directory(status)) {
    FURROW_TRY(std::vector<fs::path> files, picture_files({what}));
    return std::unique_ptr<PictureSource>(new PictureFiles(std::move(files), what, options.assumed_rate_hz));
  }
  if (fs::is_regular_file(status)) {
    if (is_picture_file(what)) return open_pictures({what}, options);
    return open_stream(what, SourceKind::video, options);
  }
  if (what.find("://") != std::string::npos) return open_stream(what, SourceKind::live, options);
  if (const auto number = camera_number(what)) return open_camera(what, *number, options);
  if (is_pattern(what)) {
    FURROW_TRY(std::vector<fs::path> files, picture_files({what}));
    return open_pictures(std::move(files), options);
  }
  if (fs::exists(status))  // a pipe could make the reader wait for ever
    return Error{"source_unreadable", what, "this is neither a file nor a folder nor a camera",
                 "one of these", ""};
  return Error{
      "source_missing", what, "there is no such file, folder or camera",
      "a video, a folder or pattern of pictures, a camera (/dev/video0 or 0) or a stream (rtsp://...)", ""};
}

}  // namespace furrow::image
