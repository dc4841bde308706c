#include "furrow/audit/finding.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "furrow/base/text.h"
#include "furrow/stats/agreement.h"
#include "furrow/stats/robust.h"

namespace furrow::audit {
namespace {

using base::format_fixed;

Finding judged(std::string id, std::string title, bool passes, std::string value, std::string limit,
               std::string evidence) {
  return {std::move(id),    std::move(title), passes ? Verdict::pass : Verdict::fail,
          std::move(value), std::move(limit), std::move(evidence)};
}

Finding not_assessed(std::string id, std::string title, std::string why) {
  return {std::move(id), std::move(title), Verdict::not_assessed, "", "", std::move(why)};
}

std::string percent(double share) {
  return format_fixed(100.0 * share, 0) + " %";
}

/// "12 no_rows (shot-0003, shot-0004, shot-0009, ...): the first one's reason", one clause per status.
std::string failures(const std::vector<ShotRecord>& records) {
  constexpr std::size_t kNamed = 3;
  std::map<std::string, std::vector<const ShotRecord*>> by_status;
  for (const ShotRecord& record : records) {
    if (!record.above_canopy_refined_m.usable()) by_status[record.status].push_back(&record);
  }
  std::string text;
  for (const auto& [status, shots] : by_status) {
    std::string names;
    for (std::size_t i = 0; i < std::min(shots.size(), kNamed); ++i)
      names += (i > 0 ? ", " : "") + shots[i]->shot_id;
    if (shots.size() > kNamed) names += ", ...";
    if (!text.empty()) text += "; ";
    text.append(std::to_string(shots.size())).append(" ").append(status).append(" (" + names + ")");
    if (!shots[0]->reason.empty()) text += ": " + shots[0]->reason;
  }
  return text.empty() ? "every shot has one" : text;
}

Finding shots_with_height(const std::vector<ShotRecord>& records, const Limits& limits) {
  const auto with = std::count_if(records.begin(), records.end(), [](const ShotRecord& record) {
    return record.above_canopy_refined_m.usable();
  });
  const double share = static_cast<double>(with) / static_cast<double>(records.size());
  return judged("shots.with_height", "Shots with a height from their rows", share >= limits.shots_with_height,
                std::to_string(with) + " of " + std::to_string(records.size()) + " (" + percent(share) + ")",
                "at least " + percent(limits.shots_with_height), failures(records));
}

/// Log minus refined height above the ground. A barometer's zero is the take-off point, so a constant
/// difference may be terrain; the finding says by how much they part and does not say who is right.
Finding log_height(const std::vector<ShotRecord>& records, double row_height_m, const Limits& limits) {
  const std::string title = "Log height above take-off against height above ground from the rows";
  std::vector<double> log;
  std::vector<double> refined;
  std::vector<double> sigmas;
  for (const ShotRecord& record : records) {
    if (!record.above_canopy_refined_m.usable() || !std::isfinite(record.height_takeoff_m)) continue;
    log.push_back(record.height_takeoff_m);
    refined.push_back(record.above_canopy_refined_m.value + row_height_m);
    sigmas.push_back(record.above_canopy_refined_m.sigma);
  }
  if (!std::isfinite(row_height_m))
    return not_assessed("heights.log", title, "the height of the rows is not given (rows.height_m)");
  if (log.size() < 2)
    return not_assessed("heights.log", title,
                        "fewer than two shots have both a log height and a refined one");
  const stats::Agreement result = stats::agreement(log, refined);
  // The shots share spacing and pitch bias, so their mean is no better than one of them.
  const double limit = limits.log_height_m + limits.log_height_sigmas * stats::median(sigmas);
  return judged(
      "heights.log", title, std::abs(result.mean_error) <= limit,
      format_fixed(result.mean_error, 2) + " m on average, sd " + format_fixed(result.sd_error, 2) + " m",
      "within " + format_fixed(limit, 2) + " m",
      std::to_string(result.pairs) + " shots; largest difference " + format_fixed(result.max_abs_error, 2) +
          " m");
}

Finding pitch_bias(const std::vector<ShotRecord>& records, const Limits& limits) {
  const std::string title = "Gimbal pitch of the log against pitch from the rows";
  std::vector<double> log;
  std::vector<double> refined;
  for (const ShotRecord& record : records) {
    if (!record.pitch_deg.usable()) continue;
    log.push_back(record.pitch_log_deg);
    refined.push_back(record.pitch_deg.value);
  }
  const stats::Agreement result = stats::agreement(log, refined);
  if (result.pairs < 2)
    return not_assessed("pitch.bias", title,
                        "fewer than two shots have both a gimbal pitch and a refined one");
  return judged(
      "pitch.bias", title, std::abs(result.mean_error) <= limits.pitch_bias_deg,
      format_fixed(result.mean_error, 2) + " deg on average, sd " + format_fixed(result.sd_error, 2) + " deg",
      "within " + format_fixed(limits.pitch_bias_deg, 2) + " deg",
      std::to_string(result.pairs) + " shots; log minus rows");
}

Finding trust(const calib::Verdict& verdict) {
  std::string evidence = verdict.summary;
  std::string missing;
  for (const std::string& one : verdict.next_pictures)
    missing += (missing.empty() ? " Missing: " : "; ") + one;
  if (!missing.empty()) evidence += missing + ".";
  if (!verdict.next_views.empty())
    evidence += " The next picture that helps most: " + verdict.next_views.front().sentence + ".";
  std::size_t met = 0;
  for (const calib::Criterion& criterion : verdict.criteria) met += criterion.met ? 1 : 0;
  return judged("calibration.trust", "Whether the calibration can be trusted with a height", verdict.trusted,
                std::to_string(met) + " of " + std::to_string(verdict.criteria.size()) + " conditions met",
                "all of them", evidence);
}

}  // namespace

Finding assess_focal(double focal_px, int width_px, double focal_length_35mm_mm, const Limits& limits) {
  const std::string title = "Focal length in use against the pictures' metadata";
  if (!std::isfinite(focal_length_35mm_mm))
    return not_assessed("camera.focal", title, "the pictures state no 35 mm equivalent");
  const auto focal_px_of = [&](double height_over_width) {
    constexpr double kDiagonal35mm = 43.2666153;  // of 36 mm x 24 mm
    return focal_length_35mm_mm / kDiagonal35mm * width_px * std::hypot(1.0, height_over_width);
  };
  const double low = focal_px_of(9.0 / 16.0);
  const double high = focal_px_of(3.0 / 4.0);
  const double outside = std::max({0.0, low / focal_px - 1.0, focal_px / high - 1.0});
  return judged(
      "camera.focal", title, outside <= limits.focal_share, format_fixed(focal_px, 0) + " px",
      format_fixed(low, 0) + " to " + format_fixed(high, 0) + " px, give or take " +
          percent(limits.focal_share),
      "metadata: " + format_fixed(focal_length_35mm_mm, 0) + " mm (35 mm equivalent), pictures " +
          std::to_string(width_px) + " px wide; outside the range by " + format_fixed(100.0 * outside, 1) +
          " %. A calibration in another mode, zoom or crop than the shots moves every height by its share.");
}

std::vector<Finding> assess_calibration(const calib::Calibration& calibration, const calib::Verdict& verdict,
                                        const Limits& limits) {
  std::size_t used = 0;
  std::string unused;
  for (const calib::View& view : calibration.views) {
    if (view.used) {
      ++used;
    } else {
      unused += (unused.empty() ? "not used: " : "; ") + view.image + " (" + view.reason + ")";
    }
  }
  const std::string views =
      std::to_string(used) + " of " + std::to_string(calibration.views.size()) + " pictures used";
  return {judged("calibration.rms", "Reprojection error of the calibration",
                 calibration.usable && calibration.rms_px <= limits.calibration_rms_px,
                 format_fixed(calibration.rms_px, 3) + " px RMS, mean " +
                     format_fixed(calibration.mean_error_px, 3) + " px",
                 "at most " + format_fixed(limits.calibration_rms_px, 2) + " px RMS",
                 views + (unused.empty() ? "" : "; " + unused)),
          trust(verdict)};
}

std::vector<Finding> assess_shots(const std::vector<ShotRecord>& records, double row_height_m,
                                  const Limits& limits) {
  if (records.empty())
    return {not_assessed("shots.with_height", "Shots with a height from their rows", "there are no shots")};
  return {shots_with_height(records, limits), log_height(records, row_height_m, limits),
          pitch_bias(records, limits)};
}

}  // namespace furrow::audit
