#pragma once
#include <optional>
#include <vector>

#include "furrow/follow/follower.h"
#include "furrow/image/video.h"
#include "furrow/project/follow_job.h"
#include "furrow/rows/row_lines.h"

namespace furrow::project {

/// What one picture of a source showed.
struct SeenPicture {
  image::TimedPicture source;
  rows::RowLines lines;
  follow::Sighting sighting;
};

/// Every kLanes-th picture of a source, in order: each starts its row search from the one before in its lane.
/// The number of lanes is fixed, so that results do not depend on the number of threads.
class Lane {
 public:
  explicit Lane(const FollowJobOptions& options) : options_(&options) {}
  /// Never fails: what stopped it stands in the sighting.
  SeenPicture look(image::TimedPicture source);

 private:
  const FollowJobOptions* options_;
  std::optional<rows::RowLines> before_;
  std::optional<Camera> camera_;  ///< at the size of the picture before
};
inline constexpr std::size_t kLanes = 2;

}  // namespace furrow::project
