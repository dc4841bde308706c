#pragma once
#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "furrow/image/video.h"

namespace furrow::project {

/// Reads a source ahead in a thread of its own, a few pictures at most. A recorded source waits for the
/// taker; of a live one the oldest pictures are skipped, so that what is steered by is fresh.
class PictureQueue {
 public:
  PictureQueue(std::unique_ptr<image::PictureSource> source, double silence_s, const std::atomic<bool>* stop);
  PictureQueue(const PictureQueue&) = delete;
  PictureQueue& operator=(const PictureQueue&) = delete;
  /// Waits for the picture that is being read, unless the source is silent: then its thread is left to
  /// itself.
  ~PictureQueue();

  const image::SourceInfo& info() const { return info_; }
  /// Up to `most` pictures: as many when recorded, as many as there are (one at least) when live. Empty at
  /// the end, when stopped, and when a live source stays silent.
  std::vector<image::TimedPicture> take(std::size_t most);
  /// Once take() gave nothing:
  std::vector<std::string> trouble() const;
  bool failed() const;
  std::int64_t skipped() const;

 private:
  struct Shared;
  image::SourceInfo info_;
  double silence_s_;
  const std::atomic<bool>* stop_;
  bool is_silent_ = false;
  std::shared_ptr<Shared> shared_;  ///< outlives this when a silent source's thread is left to itself
  std::thread reader_;
};

}  // namespace furrow::project
