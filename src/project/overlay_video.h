#pragma once
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>

#include "furrow/follow/follower.h"
#include "furrow/image/video.h"
#include "furrow/rows/row_lines.h"

namespace furrow::project {

/// A picture of the overlay video before it is drawn.
struct OverlayPicture {
  Image picture;
  rows::RowLines lines;
  follow::Following following;
};

/// Draws and encodes the overlay video in a thread of its own, beside the search for the next pictures' rows.
class OverlayVideo {
 public:
  /// `options` must outlive it.
  OverlayVideo(image::VideoWriter writer, const follow::FollowerOptions& options);
  OverlayVideo(const OverlayVideo&) = delete;
  OverlayVideo& operator=(const OverlayVideo&) = delete;
  /// Without finish() the video is given up.
  ~OverlayVideo();

  /// Waits while some pictures are still to be drawn. Errors: those of writing, from any picture before. What
  /// drawing threw (out of memory) is thrown on.
  Status add(OverlayPicture picture);
  /// Draws what is left. Errors: those of writing. Throws as add() does.
  Status finish();

 private:
  void draw_all();
  void draw_until_closed();
  void close();

  image::VideoWriter writer_;
  const follow::FollowerOptions* options_;
  std::mutex mutex_;
  std::condition_variable has_picture_, has_room_;
  std::deque<OverlayPicture> waiting_;
  Status status_ = Done{};
  std::exception_ptr failure_;
  bool is_closed_ = false;
  std::thread drawer_;
};

}  // namespace furrow::project
