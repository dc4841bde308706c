#include "furrow/calib/verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Dense>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

#include "calib/set_faults.h"
#include "furrow/base/text.h"
#include "furrow/base/value.h"
#include "furrow/calib/uncertainty.h"

namespace furrow::calib {
namespace {

using base::format_fixed;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr double kPercent = 100.0;
/// Cells of the coverage criterion.
constexpr int kCellColumns = 6, kCellRows = 4;

std::vector<const View*> used_views(const Calibration& calibration) {
  std::vector<const View*> out;
  for (const View& view : calibration.views) {
    if (view.used) out.push_back(&view);
  }
  return out;
}

Eigen::Vector3d normal_in_cam(const View& view) {
  return view.cam_from_board.rotation * Eigen::Vector3d::UnitZ();
}

Criterion at_most(const std::string& name, double value, double limit, const std::string& sentence) {
  return {name, value, limit, value <= limit, sentence};
}

Criterion at_least(const std::string& name, double value, double limit, const std::string& sentence) {
  return {name, value, limit, value >= limit, sentence};
}

Criterion focal_criterion(const Calibration& calibration, const TrustLimits& limits) {
  const double percent = height_error_percent(calibration.camera).value_or(kNan);
  return at_most("focal_sigma", percent, limits.focal_sigma_percent,
                 std::isfinite(percent) ? "focal length known to " + format_fixed(percent, 2) +
                                              " % (one sigma); heights carry the same error"
                                        : "the pictures do not determine the focal length");
}

Criterion rms_criterion(const Calibration& calibration, const TrustLimits& limits) {
  constexpr double kReferenceWidthPx = 1280.0;
  const double limit_px =
      limits.rms_px_per_1280 * std::max(1.0, calibration.camera.width / kReferenceWidthPx);
  return at_most(
      "rms", calibration.rms_px, limit_px,
      "RMS " + format_fixed(calibration.rms_px, 3) + " px" +
          (calibration.rms_px <= limit_px ? "" : ": the lens is not of this model, or corners are wrong"));
}

Criterion tilt_criterion(const Calibration& calibration, const TrustLimits& limits) {
  const double degrees = largest_tilt_rad(calibration) / kDegree;
  return at_least("tilt", degrees, limits.smallest_tilt_deg,
                  degrees >= limits.smallest_tilt_deg
                      ? "boards differ in tilt by up to " + format_fixed(degrees, 0) + " deg"
                      : "all boards are nearly parallel (" + format_fixed(degrees, 1) +
                            " deg apart): focal length and distance cannot be told apart");
}

Criterion coverage_criterion(const Calibration& calibration, const TrustLimits& limits) {
  const std::vector<int> cells = coverage(calibration, kCellColumns, kCellRows);
  const auto filled = std::count_if(cells.begin(), cells.end(), [](int n) { return n > 0; });
  const double share = static_cast<double>(filled) / static_cast<double>(cells.size());
  return at_least("coverage", share, limits.smallest_coverage,
                  "corners in " + std::to_string(filled) + " of " + std::to_string(cells.size()) +
                      " parts of the picture");
}

Criterion views_criterion(const Calibration& calibration, const TrustLimits& limits) {
  const auto count = static_cast<double>(used_views(calibration).size());
  return at_least("views", count, limits.fewest_views, format_fixed(count, 0) + " usable pictures");
}

Criterion outlier_criterion(const Calibration& calibration, const TrustLimits& limits) {
  const int all = calibration.corners + calibration.corners_left_out;
  const double percent = all > 0 ? kPercent * calibration.corners_left_out / all : kNan;
  return at_most("outliers", percent, limits.left_out_percent,
                 format_fixed(percent, 1) + " % of the corners were left out as outliers" +
                     (percent <= limits.left_out_percent
                          ? ""
                          : ": more than stains explain; the lens may be of another model"));
}

/// Why fx and fy differ: the board, if square pixels and a stretched board fit as well; the pictures, if they
/// do not.
std::string aspect_explained(const Calibration& calibration,
                             const std::vector<target::BoardDetection>& detections, CalibrateOptions options,
                             bool& board_is_to_blame) {
  options.solve_aspect = true;
  const auto other = calibrate(detections, calibration.board, options);
  // A better or equal fit with one parameter exchanged for another: a tenth more RMS is beyond what that
  // exchange can cost by chance.
  constexpr double kAsGood = 1.1;
  board_is_to_blame = !other.ok() || other->rms_px <= kAsGood * calibration.rms_px;
  if (!other.ok()) return ": measure a square of the board both ways";
  const std::string fit = "solving the board's aspect with square pixels (--squares unknown_aspect) gives " +
                          format_fixed(other->board_aspect.value, 4) + ", f " +
                          format_fixed(other->camera.fx, 1) + " px and RMS " +
                          format_fixed(other->rms_px, 3) + " px, against " +
                          format_fixed(calibration.rms_px, 3) + " px";
  if (board_is_to_blame) {
    // Told apart only by boards seen at several rolls; where both fit, a sensor's square pixels are the surer
    // thing.
    return ": the board's squares are not square (a monitor or a stretched print); " + fit;
  }
  return ": the pictures themselves are stretched, not the board, since " + fit +
         "; carry this camera only to pictures that were stretched alike";
}

Criterion aspect_criterion(const Calibration& calibration,
                           const std::vector<target::BoardDetection>& detections,
                           const CalibrateOptions& options, const TrustLimits& limits) {
  const Camera& camera = calibration.camera;
  const double off = kPercent * (camera.fx / camera.fy - 1.0);
  // fx / fy that noise alone explains is no sign of anything.
  double sigma = 0.0;
  if (camera.covariance.rows() >= 2) {
    const double variance = camera.covariance(0, 0) + camera.covariance(1, 1) - 2.0 * camera.covariance(0, 1);
    sigma = kPercent * std::sqrt(std::max(0.0, variance)) / camera.fy;
  }
  constexpr double kSigmas = 3.0;
  const double limit = std::max(limits.aspect_percent, kSigmas * sigma);
  Criterion out{"aspect", off, limit, std::abs(off) <= limit, "fx is " + format_fixed(off, 2) + " % over fy"};
  if (out.met || options.square_pixels || options.solve_aspect) return out;
  bool board_is_to_blame = true;
  out.sentence += aspect_explained(calibration, detections, options, board_is_to_blame);
  out.met = !board_is_to_blame;
  return out;
}

/// Two cameras from every other view, in name order.
struct Halves {
  Camera a, b;
  camera::CameraDifference difference;
};

std::optional<Halves> solve_halves(const Calibration& calibration,
                                   const std::vector<target::BoardDetection>& detections,
                                   const CalibrateOptions& options) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < detections.size() && i < calibration.views.size(); ++i) {
    if (calibration.views[i].used) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t x, std::size_t y) { return detections[x].image < detections[y].image; });
  std::array<std::vector<target::BoardDetection>, 2> half;
  for (std::size_t i = 0; i < order.size(); ++i) half[i % 2].push_back(detections[order[i]]);
  target::BoardSpec board = calibration.board;
  // The solve starts from the board as it was described; an aspect that was solved is solved again.
  if (options.solve_aspect) board.aspect = 1.0;
  const auto a = calibrate(half[0], board, options), b = calibrate(half[1], board, options);
  if (!a.ok() || !b.ok()) return std::nullopt;
  auto difference = camera::compare_cameras(a->camera, b->camera);
  if (!difference.ok()) return std::nullopt;
  return Halves{a->camera, b->camera, std::move(difference).value()};
}

Criterion halves_criterion(const std::optional<Halves>& halves, const TrustLimits& limits) {
  if (!halves) {
    return {"halves", kNan, limits.halves_focal_percent, false,
            "too few good pictures to compare two halves of them"};
  }
  const double a = camera::focal_on_axis_px(halves->a).mean(), b = camera::focal_on_axis_px(halves->b).mean();
  const double percent = kPercent * std::abs(a - b) / (0.5 * (a + b));
  return at_most("halves", percent, limits.halves_focal_percent,
                 "two halves of the pictures differ by " + format_fixed(percent, 2) +
                     " % in focal length and by " + format_fixed(halves->difference.rms_px, 2) +
                     " px over the picture (" + format_fixed(halves->difference.expected_rms_px, 2) +
                     " px predicted)");
}

void add_empty_parts(const Calibration& calibration, std::vector<std::string>& out) {
  constexpr int kParts = 3;
  const std::vector<int> cells = coverage(calibration, kParts, kParts);
  const Camera& camera = calibration.camera;
  for (int i = 0; i < kParts * kParts; ++i) {
    if (cells[static_cast<std::size_t>(i)] > 0) continue;
    const Eigen::Vector2d middle((i % kParts + 0.5) * camera.width / kParts,
                                 (i / kParts + 0.5) * camera.height / kParts);
    out.push_back("no board in the " + part_of_picture(camera, middle) + " of the picture: hold it there");
  }
}

/// Larger of the two sides of the box about a view's corners, as a share of the picture's.
double filled_share(const View& view, const Camera& camera) {
  Eigen::Vector2d low = view.observed_px.front(), high = low;
  for (const Eigen::Vector2d& px : view.observed_px) {
    low = low.cwiseMin(px);
    high = high.cwiseMax(px);
  }
  return ((high - low).array() / Eigen::Array2d(camera.width, camera.height)).maxCoeff();
}

void add_small_boards(const Calibration& calibration, std::vector<std::string>& out) {
  constexpr double kWantedShare = 0.4;
  double largest = 0.0, nearest_m = std::numeric_limits<double>::infinity();
  for (const View* view : used_views(calibration)) {
    largest = std::max(largest, filled_share(*view, calibration.camera));
    nearest_m = std::min(nearest_m, view->cam_from_board.translation.norm());
  }
  if (largest >= kWantedShare || !std::isfinite(nearest_m)) return;
  out.push_back("nothing nearer than " + format_fixed(nearest_m, 2) + " m: no board fills more than " +
                format_fixed(kPercent * largest, 0) +
                " % of the picture; bring it nearer, or take a larger one");
}

void add_missing_tilts(const std::vector<const View*>& views, std::vector<std::string>& out) {
  constexpr double kWantedTilt_deg = 20.0;
  double about_x = 0.0, about_y = 0.0, nearest_m = std::numeric_limits<double>::infinity(), farthest_m = 0.0;
  for (const View* view : views) {
    const Eigen::Vector3d n = normal_in_cam(*view);
    about_x = std::max(about_x, std::abs(std::atan2(n.y(), n.z())) / kDegree);
    about_y = std::max(about_y, std::abs(std::atan2(n.x(), n.z())) / kDegree);
    nearest_m = std::min(nearest_m, view->cam_from_board.translation.norm());
    farthest_m = std::max(farthest_m, view->cam_from_board.translation.norm());
  }
  if (about_x < kWantedTilt_deg) {
    out.push_back("no tilt about x above 20 deg (largest " + format_fixed(about_x, 0) +
                  "): lean the board's top towards or away from the camera");
  }
  if (about_y < kWantedTilt_deg) {
    out.push_back("no tilt about y above 20 deg (largest " + format_fixed(about_y, 0) +
                  "): turn one side of the board towards the camera");
  }
  constexpr double kWantedDepthRatio = 1.5;
  if (farthest_m < kWantedDepthRatio * nearest_m) {
    out.push_back("all boards stand at nearly one distance (" + format_fixed(nearest_m, 2) + " to " +
                  format_fixed(farthest_m, 2) + " m): add some nearer and some farther");
  }
}

std::string summarized(const std::vector<Criterion>& criteria) {
  std::string faults;
  for (const Criterion& criterion : criteria) {
    if (!criterion.met) faults += (faults.empty() ? "" : "; ") + criterion.sentence;
  }
  return faults.empty() ? "Enough." : "Do not trust: " + faults + ".";
}

}  // namespace

double largest_tilt_rad(const Calibration& calibration) {
  const std::vector<const View*> views = used_views(calibration);
  if (views.size() < 2) return kNan;
  double largest = 0.0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t j = i + 1; j < views.size(); ++j) {
      const double cosine = normal_in_cam(*views[i]).dot(normal_in_cam(*views[j]));
      largest = std::max(largest, std::acos(std::clamp(cosine, -1.0, 1.0)));
    }
  }
  return largest;
}

std::vector<int> coverage(const Calibration& calibration, int columns, int rows) {
  check(columns > 0 && rows > 0, "coverage: a grid needs cells");
  std::vector<int> out(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (const View* view : used_views(calibration)) {
    for (const Eigen::Vector2d& px : view->observed_px) {
      const int i =
          std::clamp(static_cast<int>((px.x() + 0.5) * columns / calibration.camera.width), 0, columns - 1);
      const int j =
          std::clamp(static_cast<int>((px.y() + 0.5) * rows / calibration.camera.height), 0, rows - 1);
      ++out[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)];
    }
  }
  return out;
}

Verdict judge(const Calibration& calibration, const std::vector<target::BoardDetection>& detections,
              const CalibrateOptions& options, const TrustLimits& limits) {
  Verdict out;
  const std::optional<Halves> halves = solve_halves(calibration, detections, options);
  out.sigma_factor = out.halves_rms_px = out.halves_expected_rms_px = kNan;
  if (halves) {
    out.halves = halves->difference;
    out.halves_rms_px = halves->difference.rms_px;
    out.halves_expected_rms_px = halves->difference.expected_rms_px;
    const double factor = out.halves_rms_px / out.halves_expected_rms_px;
    out.sigma_factor = std::isfinite(factor) ? std::max(1.0, factor) : kNan;
  }
  out.criteria = {views_criterion(calibration, limits),
                  focal_criterion(calibration, limits),
                  rms_criterion(calibration, limits),
                  tilt_criterion(calibration, limits),
                  coverage_criterion(calibration, limits),
                  outlier_criterion(calibration, limits),
                  aspect_criterion(calibration, detections, options, limits),
                  zoom_criterion(calibration, detections, options, out.sigma_factor),
                  bend_criterion(calibration, detections, options, limits.halves_focal_percent),
                  halves_criterion(halves, limits)};
  out.trusted =
      std::all_of(out.criteria.begin(), out.criteria.end(), [](const Criterion& c) { return c.met; });
  out.summary = summarized(out.criteria);
  add_empty_parts(calibration, out.next_pictures);
  add_missing_tilts(used_views(calibration), out.next_pictures);
  add_small_boards(calibration, out.next_pictures);
  out.next_views = next_views(calibration);
  out.gains = information_gain(calibration);
  return out;
}

Camera widened_camera(const Calibration& calibration, const Verdict& verdict) {
  Camera camera = calibration.camera;
  if (!(verdict.sigma_factor > 1.0)) return camera;
  camera.covariance *= verdict.sigma_factor * verdict.sigma_factor;
  camera.provenance += "; sigma widened " + format_fixed(verdict.sigma_factor, 1) +
                       " times, as two halves of the pictures differ";
  return camera;
}

namespace {

base::Value next_view_entry(const NextView& view) {
  const Eigen::Vector3d rotation = geom::rotation_vector(view.cam_from_board.rotation);
  const Eigen::Vector3d& translation = view.cam_from_board.translation;
  base::Value pose;
  pose.set("rotation_vector_rad", base::Array{rotation.x(), rotation.y(), rotation.z()});
  pose.set("translation_m", base::Array{translation.x(), translation.y(), translation.z()});
  base::Value out;
  out.set("cam_from_board", pose);
  out.set("middle_px", base::Array{view.middle_px.x(), view.middle_px.y()});
  out.set("distance_m", view.distance_m);
  out.set("tilt_x_deg", view.tilt_x_rad / kDegree);
  out.set("tilt_y_deg", view.tilt_y_rad / kDegree);
  out.set("upright", view.upright);
  out.set("picture_sigma_px", view.picture_sigma_px);
  out.set("focal_percent", view.focal_percent);
  out.set("sentence", view.sentence);
  return out;
}

}  // namespace

std::string to_json(const Verdict& verdict) {
  base::Array criteria;
  for (const Criterion& c : verdict.criteria) {
    base::Value one;
    one.set("name", c.name);
    one.set("value", c.value);
    one.set("limit", c.limit);
    one.set("met", c.met);
    one.set("sentence", c.sentence);
    criteria.push_back(one);
  }
  base::Array next;
  for (const std::string& text : verdict.next_pictures) next.emplace_back(text);
  base::Value out;
  out.set("trusted", verdict.trusted);
  out.set("summary", verdict.summary);
  out.set("sigma_factor", verdict.sigma_factor);
  out.set("halves_rms_px", verdict.halves_rms_px);
  out.set("halves_expected_rms_px", verdict.halves_expected_rms_px);
  out.set("criteria", criteria);
  out.set("next_pictures", next);
  base::Array views;
  for (const NextView& view : verdict.next_views) views.push_back(next_view_entry(view));
  out.set("next_views", views);
  base::Array gains;
  for (const ViewGain& gain : verdict.gains) {
    base::Value one;
    one.set("image", gain.image);
    one.set("focal", gain.focal);
    one.set("picture", gain.picture);
    gains.push_back(one);
  }
  out.set("gains", gains);
  return base::to_json(out) + "\n";
}

}  // namespace furrow::calib
