#include "furrow/project/camera_job.h"

#include <cmath>
#include <limits>

#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
#include "furrow/base/text.h"
#include "furrow/calib/choose_model.h"
#include "furrow/calib/uncertainty.h"
#include "furrow/figures/camera_maps.h"
#include "furrow/geom/angles.h"
#include "furrow/image/image.h"
#include "furrow/image/remap.h"
#include "furrow/image/video.h"
#include "furrow/target/detect.h"

namespace furrow::project {
namespace {

namespace fs = std::filesystem;
using base::format_fixed;
using base::Value;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPercent = 100.0;

std::string size_of(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

Camera pinhole_like(const Camera& camera) {
  Camera out;
  out.width = camera.width;
  out.height = camera.height;
  const Eigen::Vector2d focal_px = camera::focal_on_axis_px(camera);
  out.fx = focal_px.x();
  out.fy = focal_px.y();
  out.cx = camera.cx;
  out.cy = camera.cy;
  out.provenance =
      "pinhole of undistorted pictures" + (camera.provenance.empty() ? "" : "; lens " + camera.provenance);
  return out;
}

/// Where each pixel of the pinhole's picture lies in the lens's; NaN where the lens has no such ray.
std::vector<Eigen::Vector2d> undistortion(const Camera& lens, const Camera& pinhole, int threads) {
  std::vector<Eigen::Vector2d> out(static_cast<std::size_t>(lens.width) *
                                   static_cast<std::size_t>(lens.height));
  base::parallel_for(static_cast<std::size_t>(lens.height), threads, [&](std::size_t v) {
    for (int u = 0; u < lens.width; ++u) {
      const Eigen::Vector3d ray(((u - pinhole.cx) / pinhole.fx),
                                (static_cast<double>(v) - pinhole.cy) / pinhole.fy, 1.0);
      const auto px = camera::project(lens, ray);
      const auto back = px ? camera::unproject(lens, *px) : std::nullopt;
      // Beyond a fold the pixel belongs to another ray.
      constexpr double kSameRay = 1e-6;
      const bool same = back && (*back - ray.head<2>()).norm() <= kSameRay * ray.norm();
      const bool inside = same && px->x() >= -0.5 && px->y() >= -0.5 && px->x() <= lens.width - 0.5 &&
                          px->y() <= lens.height - 0.5;
      out[v * static_cast<std::size_t>(lens.width) + static_cast<std::size_t>(u)] =
          inside ? *px : Eigen::Vector2d::Constant(kNan);
    }
  });
  return out;
}

/// What a picture's undistorted copy is called: JPEG and PNG keep their names, others become PNG.
std::string undistorted_name(const fs::path& file) {
  const std::string end = base::to_lower(file.extension().string());
  const bool keeps = end == ".jpg" || end == ".jpeg" || end == ".png";
  return keeps ? file.filename().string() : file.stem().string() + ".png";
}

Status undistort_one(const fs::path& file, const Camera& lens, const std::vector<Eigen::Vector2d>& from_px,
                     const fs::path& out) {
  FURROW_TRY(const Image picture, image::read_image(file));
  if (picture.width != lens.width || picture.height != lens.height) {
    return Error{"picture_size_differs", file.filename().string(), size_of(picture.width, picture.height),
                 "the camera's " + size_of(lens.width, lens.height), ""};
  }
  return image::write_image(out, image::remap(picture, lens.width, lens.height, from_px));
}

Image mask_of(const Camera& lens, const std::vector<Eigen::Vector2d>& from_px, double& masked_share) {
  Image mask = image::make_image(lens.width, lens.height, 1);
  std::size_t masked = 0;
  for (std::size_t i = 0; i < from_px.size(); ++i) {
    const bool seen = std::isfinite(from_px[i].x());
    masked += seen ? 0 : 1;
    mask.data[i] = seen ? 255 : 0;
  }
  masked_share = static_cast<double>(masked) / static_cast<double>(from_px.size());
  return mask;
}

double mean_focal(const Camera& camera) {
  return camera::focal_on_axis_px(camera).mean();
}

void fill_refit(const Camera& old, const std::vector<target::BoardDetection>& detections,
                const target::BoardSpec& board, ValidateOutcome& out) {
  calib::CalibrateOptions options;
  options.model = old.model;
  const auto refit = calib::calibrate(detections, board, options);
  out.refit_rms_px = out.focal_change_percent = out.focal_change_sigma_percent = kNan;
  out.added_px = out.rms_px;
  if (!refit.ok()) return;
  out.refit_rms_px = refit->rms_px;
  out.added_px = std::sqrt(std::max(0.0, out.rms_px * out.rms_px - refit->rms_px * refit->rms_px));
  out.focal_change_percent = kPercent * (mean_focal(refit->camera) / mean_focal(old) - 1.0);
  out.focal_change_sigma_percent = calib::height_error_percent(refit->camera).value_or(kNan);
}

void judge_validation(const Camera& old, const ValidateLimits& limits, ValidateOutcome& out) {
  constexpr double kReferenceWidthPx = 1280.0, kSigmas = 3.0;
  const double limit_px = limits.added_px_per_1280 * std::max(1.0, old.width / kReferenceWidthPx);
  const double focal_limit = std::isfinite(out.focal_change_sigma_percent)
                                 ? std::max(limits.focal_percent, kSigmas * out.focal_change_sigma_percent)
                                 : limits.focal_percent;
  const bool fits = out.added_px <= limit_px, enough = out.boards >= limits.fewest_boards;
  const bool same_focal = !(std::abs(out.focal_change_percent) > focal_limit);
  out.still_good = fits && same_focal && enough;
  const std::string focal = std::isfinite(out.focal_change_percent)
                                ? "; a new solve moves the focal length by " +
                                      format_fixed(out.focal_change_percent, 2) + " % (sigma " +
                                      format_fixed(out.focal_change_sigma_percent, 2) + " %)"
                                : "";
  const std::string misfit = "the old lens adds " + format_fixed(out.added_px, 2) +
                             " px to the corners' misfit (limit " + format_fixed(limit_px, 2) + " px)";
  if (out.still_good) {
    out.sentence = "Still good to " + format_fixed(out.added_px, 2) + " px: " + misfit + focal + ".";
  } else if (!enough) {
    out.sentence = "Not assessed: " + std::to_string(out.boards) + " boards, at least " +
                   std::to_string(limits.fewest_boards) + " wanted; " + misfit + focal + ".";
  } else {
    out.sentence = "No longer good: " + misfit + focal + " (limit " + format_fixed(focal_limit, 2) +
                   " %). Calibrate anew.";
  }
}

Value optional_value(const std::optional<double>& value) {
  return value ? Value(*value) : Value();
}

Value optional_degrees(const std::optional<double>& angle_rad) {
  return angle_rad ? Value(geom::rad_to_deg(*angle_rad)) : Value();
}

}  // namespace

Result<CameraShown> show_camera(const fs::path& file, const std::optional<SensorSize>& sensor) {
  CameraShown out;
  FURROW_TRY(out.camera, camera::read_camera(file));
  out.description = camera::describe(out.camera);
  if (sensor) {
    out.focal_mm = camera::focal_length_mm(out.description.focal_px.x(), sensor->width_mm, out.camera.width);
    out.ideal_fov = camera::field_of_view(sensor->width_mm, sensor->height_mm, *out.focal_mm);
  }
  return out;
}

Status convert_camera(const fs::path& file, const fs::path& out, camera::CameraFormat format,
                      const camera::ExportOptions& options) {
  FURROW_TRY(const Camera camera, camera::read_camera(file));
  FURROW_TRY(const std::string text, camera::export_camera(camera, format, options));
  return base::write_file(out, text);
}

Result<UndistortOutcome> undistort_pictures(const fs::path& camera, const std::vector<fs::path>& named,
                                            const fs::path& out, const JobOptions& job) {
  FURROW_TRY(const Camera lens, camera::read_camera(camera));
  FURROW_TRY(const auto images, image::picture_files(named));
  std::vector<std::string> names;
  names.reserve(images.size());
  for (const fs::path& file : images) names.push_back(undistorted_name(file));
  names = base::names_apart(std::move(names), images);
  UndistortOutcome outcome;
  outcome.pinhole = pinhole_like(lens);
  const std::vector<Eigen::Vector2d> from_px = undistortion(lens, outcome.pinhole, job.threads);
  const Image mask = mask_of(lens, from_px, outcome.masked_share);
  for (std::size_t i = 0; i < images.size(); ++i) {
    base::report(job.progress, "undistorting", i, images.size());
    const Status status = undistort_one(images[i], lens, from_px, out / names[i]);
    if (status.ok()) {
      outcome.written.push_back(names[i]);
    } else {
      outcome.failed.push_back(status.error().message());
    }
  }
  base::report(job.progress, "undistorting", images.size(), images.size());
  if (outcome.written.empty()) {
    return Error{"nothing_undistorted", "pictures",
                 outcome.failed.empty() ? "none given" : outcome.failed.front(),
                 "pictures of " + size_of(lens.width, lens.height), ""};
  }
  FURROW_DO(image::write_image(out / "mask.png", mask));
  FURROW_DO(base::write_file(out / "camera.yaml", camera::to_opencv_yaml(outcome.pinhole)));
  return outcome;
}

Result<DiffOutcome> diff_cameras(const fs::path& a, const fs::path& b, const std::optional<fs::path>& out) {
  DiffOutcome outcome;
  FURROW_TRY(outcome.a, camera::read_camera(a));
  FURROW_TRY(outcome.b, camera::read_camera(b));
  if (outcome.a.width != outcome.b.width || outcome.a.height != outcome.b.height) {
    FURROW_TRY(outcome.b, camera::carry_camera(outcome.b, outcome.a.width, outcome.a.height));
  }
  constexpr int kColumns = 48, kRows = 32;
  FURROW_TRY(outcome.difference, camera::compare_cameras(outcome.a, outcome.b, kColumns, kRows));
  outcome.focal_percent = kPercent * (mean_focal(outcome.b) / mean_focal(outcome.a) - 1.0);
  if (!out) return outcome;
  const auto& d = outcome.difference;
  FURROW_TRY(const figures::Figure figure,
             figures::picture_map(figures::difference_map(
                 "camera_difference",
                 "How far " + b.filename().string() + " and " + a.filename().string() +
                     " put the same direction apart, the turn between them taken out; RMS " +
                     format_fixed(d.rms_px, 3) + " px, largest " + format_fixed(d.largest_px, 3) + " px.",
                 outcome.a, d)));
  FURROW_DO(figures::write_figure(*out, figure));
  return outcome;
}

Result<ValidateOutcome> validate_camera(const fs::path& camera, const std::vector<fs::path>& named,
                                        const fs::path& board_file, const ValidateLimits& limits,
                                        const JobOptions& job) {
  FURROW_TRY(const Camera old, camera::read_camera(camera));
  FURROW_TRY(const target::BoardSpec board, target::read_board(board_file));
  FURROW_TRY(const auto images, image::picture_files(named));
  const auto detections = target::detect_boards(images, board, {}, job.threads, job.progress);
  for (const target::BoardDetection& one : detections) {
    if (one.found && (one.width != old.width || one.height != old.height)) {
      return Error{"picture_sizes_differ", fs::path(one.image).filename().string(),
                   size_of(one.width, one.height),
                   "pictures of the camera's size, " + size_of(old.width, old.height), ""};
    }
  }
  ValidateOutcome out;
  out.views = calib::locate_boards(old, detections, board);
  double squared = 0.0;
  std::string why;
  for (const calib::View& view : out.views) {
    if (!view.used) {
      if (why.empty()) why = "; " + fs::path(view.image).filename().string() + ": " + view.reason;
      continue;
    }
    ++out.boards;
    out.corners += static_cast<int>(view.observed_px.size());
    squared += view.rms_px * view.rms_px * static_cast<double>(view.observed_px.size());
  }
  if (out.boards == 0) {
    return Error{"too_few_boards", "pictures",
                 "no board in " + std::to_string(out.views.size()) + " pictures" + why, "at least one",
                 "check the board's corner counts (inner corners, not squares)"};
  }
  out.rms_px = std::sqrt(squared / out.corners);
  fill_refit(old, detections, board, out);
  judge_validation(old, limits, out);
  return out;
}

Value to_value(const CameraShown& shown) {
  const Camera& camera = shown.camera;
  const camera::Description& d = shown.description;
  Value out;
  out.set("model", camera::model_name(camera.model));
  out.set("image_size", base::Array{camera.width, camera.height});
  Value values;
  const std::vector<std::string> names = camera::intrinsic_names(camera);
  const Eigen::VectorXd p = camera::intrinsics(camera);
  for (std::size_t i = 0; i < names.size(); ++i) values.set(names[i], p[static_cast<Eigen::Index>(i)]);
  out.set("intrinsics", values);
  out.set("focal_px", base::Array{d.focal_px.x(), d.focal_px.y()});
  out.set("focal_mm", optional_value(shown.focal_mm));
  out.set("fov_horizontal_deg", optional_degrees(d.horizontal_rad));
  out.set("fov_vertical_deg", optional_degrees(d.vertical_rad));
  out.set("fov_diagonal_deg", optional_degrees(d.diagonal_rad));
  if (shown.ideal_fov) {
    out.set("ideal_fov_deg", base::Array{geom::rad_to_deg(shown.ideal_fov->horizontal_rad),
                                         geom::rad_to_deg(shown.ideal_fov->vertical_rad),
                                         geom::rad_to_deg(shown.ideal_fov->diagonal_rad)});
  }
  out.set("corner_distortion_px", optional_value(d.corner_distortion_px));
  out.set("without_inverse_share", d.without_inverse);
  out.set("inverse_reach_px", optional_value(d.inverse_reach_px));
  out.set("provenance", camera.provenance);
  return out;
}

Value to_value(const UndistortOutcome& outcome) {
  Value out;
  base::Array written(outcome.written.begin(), outcome.written.end()),
      failed(outcome.failed.begin(), outcome.failed.end());
  out.set("written", written);
  out.set("failed", failed);
  out.set("masked_share", outcome.masked_share);
  out.set("fx", outcome.pinhole.fx);
  out.set("fy", outcome.pinhole.fy);
  return out;
}

Value to_value(const DiffOutcome& outcome) {
  const camera::CameraDifference& d = outcome.difference;
  Value out;
  out.set("rms_px", d.rms_px);
  out.set("largest_px", d.largest_px);
  out.set("expected_rms_px", d.expected_rms_px);
  out.set("turn_deg", base::Array{geom::rad_to_deg(d.b_from_a_rad.x()), geom::rad_to_deg(d.b_from_a_rad.y()),
                                  geom::rad_to_deg(d.b_from_a_rad.z())});
  out.set("compared_share", d.compared_share);
  out.set("focal_percent", outcome.focal_percent);
  return out;
}

Value to_value(const ValidateOutcome& outcome) {
  Value out;
  out.set("still_good", outcome.still_good);
  out.set("sentence", outcome.sentence);
  out.set("good_to_px", outcome.added_px);
  out.set("boards", outcome.boards);
  out.set("corners", outcome.corners);
  out.set("rms_px", outcome.rms_px);
  out.set("refit_rms_px", outcome.refit_rms_px);
  out.set("focal_change_percent", outcome.focal_change_percent);
  out.set("focal_change_sigma_percent", outcome.focal_change_sigma_percent);
  base::Array views;
  for (const calib::View& view : outcome.views) {
    Value one;
    one.set("image", fs::path(view.image).filename().string());
    one.set("used", view.used);
    one.set("rms_px", view.rms_px);
    one.set("reason", view.reason);
    views.push_back(one);
  }
  out.set("views", views);
  return out;
}

}  // namespace furrow::project
