#include "project/overlay_video.h"

#include "furrow/figures/following.h"

namespace furrow::project {

OverlayVideo::OverlayVideo(image::VideoWriter writer, const follow::FollowerOptions& options)
    : writer_(std::move(writer)), options_(&options), drawer_([this] { draw_all(); }) {}

OverlayVideo::~OverlayVideo() {
  {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
  }
  close();
}

void OverlayVideo::close() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
    has_picture_.notify_one();
  }
  if (drawer_.joinable()) drawer_.join();
}

Status OverlayVideo::add(OverlayPicture picture) {
  constexpr std::size_t kMost = 4, kLarge = std::size_t{64} << 20U;  // large pictures wait one at a time
  const std::size_t most = picture.picture.data.size() > kLarge ? 1 : kMost;
  std::unique_lock lock(mutex_);
  has_room_.wait(lock, [&] { return waiting_.size() < most || !status_.ok() || failure_; });
  if (failure_) std::rethrow_exception(failure_);
  if (!status_.ok()) return status_;
  waiting_.push_back(std::move(picture));
  has_picture_.notify_one();
  return Done{};
}

Status OverlayVideo::finish() {
  close();
  if (failure_) std::rethrow_exception(failure_);
  FURROW_DO(status_);
  return writer_.finish();
}

/// An exception that left a thread would end the program without a word, its temporary files left behind.
void OverlayVideo::draw_all() {
  try {
    draw_until_closed();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
    has_room_.notify_one();
  }
}

void OverlayVideo::draw_until_closed() {
  std::unique_lock lock(mutex_);
  while (true) {
    has_picture_.wait(lock, [this] { return !waiting_.empty() || is_closed_; });
    if (waiting_.empty()) return;
    OverlayPicture next = std::move(waiting_.front());
    waiting_.pop_front();
    has_room_.notify_one();
    lock.unlock();
    const base::Nanoseconds t = next.following.sighting.t_video_ns;
    const Image drawn =
        figures::following_picture(std::move(next.picture), next.lines, next.following, *options_);
    const Status written = writer_.add(drawn, t);
    lock.lock();
    if (written.ok()) continue;
    status_ = written;
    has_room_.notify_one();
    return;
  }
}

}  // namespace furrow::project
