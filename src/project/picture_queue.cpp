#include "project/picture_queue.h"

#include <chrono>

#include "furrow/base/text.h"

namespace furrow::project {

using image::TimedPicture;

struct PictureQueue::Shared {
  std::unique_ptr<image::PictureSource> source;
  mutable std::mutex mutex;
  std::condition_variable has_picture, has_room;
  std::deque<TimedPicture> pictures;
  std::size_t bytes = 0;
  bool is_live = false, has_ended = false, is_closed = false;
  std::int64_t skipped = 0;

  /// Large pictures wait in smaller numbers.
  bool is_full() const {
    constexpr std::size_t kMost = 4, kMostBytes = std::size_t{256} << 20U;
    return pictures.size() >= kMost || (bytes > kMostBytes && !pictures.empty());
  }
  TimedPicture pop() {
    TimedPicture first = std::move(pictures.front());
    pictures.pop_front();
    bytes -= first.picture.data.size();
    return first;
  }
  /// False when nobody wants pictures any more.
  bool push(TimedPicture picture) {
    std::unique_lock lock(mutex);
    if (!is_live) has_room.wait(lock, [this] { return is_closed || !is_full(); });
    while (is_live && is_full()) pop(), ++skipped;
    if (is_closed) return false;
    bytes += picture.picture.data.size();
    pictures.push_back(std::move(picture));
    has_picture.notify_one();
    return true;
  }
};

PictureQueue::PictureQueue(std::unique_ptr<image::PictureSource> source, double silence_s,
                           const std::atomic<bool>* stop)
    : info_(source->info()), silence_s_(silence_s), stop_(stop), shared_(std::make_shared<Shared>()) {
  shared_->source = std::move(source);
  shared_->is_live = info_.kind == image::SourceKind::live;
  reader_ = std::thread([shared = shared_] {
    while (auto picture = shared->source->next()) {
      if (!shared->push(std::move(*picture))) return;
    }
    const std::lock_guard lock(shared->mutex);
    shared->has_ended = true;
    shared->has_picture.notify_one();
  });
}

PictureQueue::~PictureQueue() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->is_closed = true;
    shared_->has_room.notify_one();
  }
  if (is_silent_) {
    reader_.detach();
  } else {
    reader_.join();
  }
}

std::vector<TimedPicture> PictureQueue::take(std::size_t most) {
  using namespace std::chrono_literals;
  std::vector<TimedPicture> taken;
  const auto is_stopped = [this] { return stop_ != nullptr && *stop_; };
  if (is_stopped()) return taken;
  const std::size_t least = shared_->is_live ? 1 : most;
  std::unique_lock lock(shared_->mutex);
  auto heard = std::chrono::steady_clock::now();
  while (taken.size() < most) {
    while (!shared_->pictures.empty() && taken.size() < most) taken.push_back(shared_->pop());
    shared_->has_room.notify_one();
    if (taken.size() >= least || shared_->has_ended || is_stopped()) break;
    // Woken now and then to see whether to stop.
    shared_->has_picture.wait_for(lock, 100ms);
    if (!shared_->pictures.empty()) heard = std::chrono::steady_clock::now();
    is_silent_ = shared_->is_live &&
                 std::chrono::steady_clock::now() - heard > std::chrono::duration<double>(silence_s_);
    if (is_silent_) break;
  }
  return taken;
}

std::vector<std::string> PictureQueue::trouble() const {
  if (is_silent_) {
    return {"the camera has sent nothing for " + base::format_double(silence_s_) +
            " s: unplugged, or its cable or network is down"};
  }
  const std::lock_guard lock(shared_->mutex);
  if (!shared_->has_ended) return {};  // stopped by the user; the reader still holds the source
  return shared_->source->trouble();
}

bool PictureQueue::failed() const {
  if (is_silent_) return true;
  const std::lock_guard lock(shared_->mutex);
  return shared_->has_ended && shared_->source->failed();
}

std::int64_t PictureQueue::skipped() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->skipped;
}

}  // namespace furrow::project
