#pragma once
#include <cstddef>
#include <functional>

namespace furrow::base {

/// Calls body(i) for every i in [0, count) on up to `threads` threads (0: one per core). Each i is called
/// once; the order is free, so body must write only to its own place. The first exception is rethrown after
/// all threads have ended.
void parallel_for(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

}  // namespace furrow::base
