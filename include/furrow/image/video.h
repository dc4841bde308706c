#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/result.h"
#include "furrow/base/time.h"
#include "furrow/image/image.h"

namespace furrow::image {

/// One picture of a source, or why it could not be read.
struct TimedPicture {
  std::int64_t index = 0;            ///< from 0, pictures that could not be read included
  std::string name;                  ///< file name, or "picture 17" of a video (counted from 1)
  base::Nanoseconds t_video_ns = 0;  ///< since the source's first picture
  Image picture;                     ///< empty when `error` stands
  std::optional<Error> error = {};   ///< picture_unreadable, ...
};

enum class SourceKind { pictures, video, live };

/// What is known of a source before its first picture.
struct SourceInfo {
  SourceKind kind = SourceKind::video;
  std::string name;              ///< as the user named it
  double nominal_rate_hz = 0.0;  ///< what the container, the device or the caller says; above 0
  std::int64_t count = 0;        ///< pictures that it claims to hold; 0 when unknown
};

/// Pictures one after the other. Used by one thread at a time.
class PictureSource {
 public:
  virtual ~PictureSource() = default;
  virtual const SourceInfo& info() const = 0;
  /// The next picture; nothing at the end. A live source that fails gives nothing too: see trouble().
  virtual std::optional<TimedPicture> next() = 0;
  /// What a person should know once next() gave nothing: a video that is shorter than its container claims, a
  /// camera that went away, times that had to be made up. Empty when all went well.
  virtual std::vector<std::string> trouble() const = 0;
  /// True when next() gave nothing although the source should have gone on: a live source that failed.
  virtual bool failed() const = 0;
};

struct SourceOptions {
  /// Pictures a second of a folder, whose pictures have no times; also of a video whose container has none.
  double assumed_rate_hz = 1.0;
  /// How long a network stream may be silent before it counts as gone, seconds.
  double silence_s = 5.0;
};

/// The pictures that a person named: a folder stands for the pictures in it (JPEG, PNG, TIFF, BMP, in natural
/// order; folders in it are not entered), a pattern for the files that match, and anything else for itself,
/// whether it is there or not. Errors: no_match (a folder without a picture, a pattern without a match or in
/// the name of a folder).
Result<std::vector<std::filesystem::path>> picture_files(const std::vector<std::filesystem::path>& named);

/// Opens whatever a person may name: a video file (everything FFmpeg reads), a folder (its pictures in
/// natural order), a pattern, one picture, a camera ("/dev/video0" or "0"), or a stream ("rtsp://...").
/// Turning by metadata is NOT applied: a camera model belongs to the sensor's own pixels. Errors:
/// source_missing, source_unreadable (no video in it, no camera there, a pipe), no_match (a folder or pattern
/// without pictures).
Result<std::unique_ptr<PictureSource>> open_source(const std::string& what,
                                                   const SourceOptions& options = {});

/// The same for pictures listed one by one.
std::unique_ptr<PictureSource> open_pictures(std::vector<std::filesystem::path> files,
                                             const SourceOptions& options = {});

/// Writes a video of one size, each picture at its own time: H.264 (MPEG-4 where FFmpeg lacks x264) in .mp4
/// or .mkv. One thread encodes, so that the same pictures give the same bytes. It gets its name at finish()
/// only.
class VideoWriter {
 public:
  /// `rate_hz` says how long the last picture stays, and where a player may jump to. Errors: file_unwritable,
  /// no_encoder (FFmpeg has none for that extension).
  static Result<VideoWriter> create(const std::filesystem::path& file, int width, int height, double rate_hz);
  VideoWriter(VideoWriter&&) noexcept;
  VideoWriter& operator=(VideoWriter&&) noexcept;
  ~VideoWriter();

  /// A picture that shows from `t_ns` on, later than the one before. One of another size is fitted into the
  /// video's with black borders. Errors: file_unwritable (the disk is full).
  Status add(const Image& picture, base::Nanoseconds t_ns);
  /// Errors: file_unwritable.
  Status finish();

 private:
  struct Parts;
  explicit VideoWriter(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

}  // namespace furrow::image
