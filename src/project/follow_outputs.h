#pragma once
#include <deque>
#include <fstream>
#include <memory>
#include <optional>
#include <vector>

#include "furrow/base/file.h"
#include "furrow/figures/following.h"
#include "furrow/follow/mavlink.h"
#include "furrow/follow/steering_link.h"
#include "project/follow_chain.h"
#include "project/overlay_video.h"

namespace furrow::project {

/// The steering frames of a run: a setpoint for every picture, a heartbeat a second.
class SteeringSender {
 public:
  explicit SteeringSender(follow::SteeringLink link) : link_(std::move(link)) {}
  void send(const follow::Following& following);
  const follow::SteeringLink& link() const { return link_; }

 private:
  follow::SteeringLink link_;
  follow::MavlinkAddress address_;
  std::uint8_t sequence_ = 0;
  std::optional<base::Nanoseconds> last_heartbeat_;
};

/// The files of a run, each under its name only when the run ends in good order.
class FollowFiles {
 public:
  static Result<FollowFiles> create(const FollowJobOptions& options, double nominal_rate_hz);
  Status add(const FollowedPicture& picture, SeenPicture seen);
  /// Errors: file_unwritable. Returns the names written.
  Result<std::vector<std::string>> finish();

 private:
  FollowFiles(const FollowJobOptions& options, double rate_hz, base::PartFile csv);
  void keep_for_figure(const follow::Following& following);

  const FollowJobOptions* options_;
  double rate_hz_;
  base::PartFile csv_file_;
  std::ofstream csv_;
  std::unique_ptr<OverlayVideo> overlay_;
  figures::FollowingCurves curves_;
  std::size_t keep_every_ = 1, since_kept_ = 0;
};

}  // namespace furrow::project
