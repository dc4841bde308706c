#include "project/follow_chain.h"

#include "furrow/altitude/shot_height.h"
#include "project/shot_chain.h"

namespace furrow::project {
namespace {

rows::RowLines unread(const image::TimedPicture& source, rows::Method method) {
  rows::RowLines lines;
  lines.method = method == rows::Method::thesis ? "thesis" : "field";
  lines.status = source.error->code;
  lines.reason = source.error->message();
  return lines;
}

/// Offset and heading in metres and radians by the lengths that are known: the sighting's px give way to
/// them.
follow::Sighting in_metres(follow::Sighting sighting, const rows::RowLines& lines, const Camera& camera,
                           const FollowJobOptions& options) {
  sighting.offset = {};
  sighting.spacing = options.field.row_spacing_m.value;
  if (!lines.ok()) return sighting;
  const auto measured = altitude::offset_from_rows(lines, camera, options.field, options.attitude,
                                                   options.height_above_canopy_m);
  if (!measured.ok()) {
    sighting.status = measured.error().code;
    sighting.reason = measured.error().message();
    return sighting;
  }
  sighting.offset = measured->cross_track_m;
  sighting.heading_rad = measured->yaw_rad;
  if (!measured->row_spacing_m.usable()) return sighting;
  sighting.spacing = measured->row_spacing_m.value;
  sighting.spacing_sigma = measured->row_spacing_m.sigma;
  sighting.offset_spacing_covariance = measured->cross_track_spacing_covariance_m2;
  return sighting;
}

}  // namespace

SeenPicture Lane::look(image::TimedPicture source) {
  SeenPicture seen;
  if (source.error) {
    seen.lines = unread(source, options_->method);
    seen.sighting = follow::sighting_of(seen.lines, source.t_video_ns);
    seen.source = std::move(source);
    return seen;
  }
  const Image& picture = source.picture;
  rows::DetectOptions detect;
  detect.method = options_->method;
  // A quarter less time a picture, and the same errors on rendered flights (docs/benchmarks.md).
  detect.shape_pixels = 640.0 * 360.0;
  std::optional<Error> no_camera;
  if (options_->camera &&
      (!camera_ || camera_->width != picture.width || camera_->height != picture.height)) {
    auto carried = camera::carry_camera(*options_->camera, picture.width, picture.height);
    camera_.reset();
    if (carried.ok())
      camera_ = std::move(*carried);
    else
      no_camera = carried.error();
  }
  if (camera_) detect.priors = horizon_of(options_->attitude, *camera_);
  if (before_ && before_->width == picture.width && before_->height == picture.height)
    detect.previous = rows::previous_of(*before_);
  seen.lines = rows::detect(picture, detect);
  if (seen.lines.ok()) before_ = seen.lines;
  seen.sighting = follow::sighting_of(seen.lines, source.t_video_ns);
  if (camera_) seen.sighting = in_metres(std::move(seen.sighting), seen.lines, *camera_, *options_);
  if (no_camera) {
    seen.sighting.offset = {};
    seen.sighting.status = no_camera->code;
    seen.sighting.reason = no_camera->message();
  }
  seen.source = std::move(source);
  return seen;
}

}  // namespace furrow::project
