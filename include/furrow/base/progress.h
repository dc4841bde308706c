#pragma once
#include <cstddef>
#include <functional>
#include <string>

namespace furrow::base {

/// One step of long work.
struct ProgressEvent {
  std::string stage;      ///< e.g. "detecting boards"
  std::size_t done = 0;   ///< items finished
  std::size_t total = 0;  ///< items in all; 0 when unknown
};

/// Called from any thread but never from two at a time. An empty function means nobody watches.
using Progress = std::function<void(const ProgressEvent&)>;

inline void report(const Progress& progress, const char* stage, std::size_t done, std::size_t total) {
  if (progress) progress({stage, done, total});
}

}  // namespace furrow::base
