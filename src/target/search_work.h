#pragma once
#include <cstdint>

#include "furrow/target/detect.h"

namespace furrow::target {

/// Counts what the search of one picture costs in steps (a pixel looked at, a pair of corners or outlines
/// compared) and ends it at kMostSearchSteps. Unlike seconds, steps are the same on every machine.
class SearchWork {
 public:
  /// Counts steps that are about to be taken; false when they would pass the bound, and must be left out.
  bool spend(std::int64_t steps) {
    if (steps > kMostSearchSteps - steps_) return leave_out();
    steps_ += steps;
    return true;
  }
  /// Notes that something was not looked at; false, to be returned.
  bool leave_out() {
    cut_ = true;
    return false;
  }
  std::int64_t steps() const { return steps_; }
  bool cut() const { return cut_; }

 private:
  std::int64_t steps_ = 0;
  bool cut_ = false;
};

}  // namespace furrow::target
