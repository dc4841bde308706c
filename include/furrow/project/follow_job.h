#pragma once
#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/base/csv.h"
#include "furrow/base/value.h"
#include "furrow/camera/camera.h"
#include "furrow/follow/follower.h"
#include "furrow/image/video.h"
#include "furrow/rows/detect.h"

namespace furrow::project {

/// One picture's line of the output.
struct FollowedPicture {
  std::int64_t index = 0;
  std::string name;
  double confidence = 0.0;  ///< that the rows are right
  follow::Following following;
};

struct FollowJobOptions {
  follow::FollowerOptions follower;
  rows::Method method = rows::Method::field;
  /// With a camera and a length (row spacing, height above the canopy or half width) offsets are metres, else
  /// px.
  std::optional<Camera> camera;
  altitude::FieldKnowledge field;
  Estimate height_above_canopy_m;  ///< as something else measured it; unusable when nothing did
  altitude::AttitudePrior attitude;
  /// Folder for follow.csv, figures/ and overlay.mp4; nothing writes none.
  std::optional<std::filesystem::path> out;
  bool overlay = true;
  /// Deviations read by hand (columns picture, deviation_m / _cm / _px, and flight when there are several),
  /// compared in `out`.
  std::optional<std::filesystem::path> by_hand;
  /// Where MAVLink frames go (SteeringLink); nothing sends none.
  std::optional<std::string> steer_to;
  /// Longest silence of a live source, seconds.
  double silence_s = 5.0;
  int threads = 0;  ///< 0: one per core; results do not depend on it
  /// Called for every picture in order; false ends the run.
  std::function<bool(const FollowedPicture&)> on_picture;
  /// Ends the run in good order when it becomes true; must outlive the job.
  const std::atomic<bool>* stop = nullptr;
};

/// What `furrow follow` did.
struct FollowOutcome {
  std::int64_t pictures = 0, seen = 0, held = 0;
  std::int64_t row_changes = 0;    ///< changes of the followed row and new counts after the first
  std::int64_t skipped = 0;        ///< live pictures that came faster than they could be looked at
  std::vector<std::string> notes;  ///< what a person should know, one sentence each
  bool source_failed = false;      ///< a live source went away
  base::CsvTable by_hand;          ///< the table of thesis section 4; empty without `by_hand`
  std::vector<std::string> files;  ///< written, relative to `out`
};

/// The line of a picture, flat: the fields of docs/cli.md.
base::Value followed_value(const FollowedPicture& picture, bool is_metric);

/// Pictures -> rows -> followed row -> lines, files and steering frames. Memory does not grow with the
/// source's length. Errors: those of the by-hand file, of writing, and of opening the link.
Result<FollowOutcome> follow_job(std::unique_ptr<image::PictureSource> source,
                                 const FollowJobOptions& options);

}  // namespace furrow::project
