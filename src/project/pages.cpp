#include "project/pages.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

#include "furrow/audit/truth.h"
#include "furrow/base/parallel.h"
#include "furrow/base/text.h"
#include "furrow/base/version.h"
#include "furrow/calib/uncertainty.h"
#include "furrow/figures/camera_maps.h"
#include "furrow/figures/pictures.h"
#include "furrow/image/image.h"
#include "project/height_sections.h"

namespace furrow::project {
namespace {

using base::format_fixed;

std::string size_text(const Camera& camera) {
  return std::to_string(camera.width) + "x" + std::to_string(camera.height);
}

report::PageTable camera_table(const Camera& camera) {
  const std::vector<std::string> names = camera::intrinsic_names(camera);
  // The knots of a splined lens are hundreds; calibration.json has them.
  constexpr Eigen::Index kMostShown = 16;
  report::PageTable table;
  table.caption = "Intrinsics (" + camera::model_name(camera.model) + ") at " + size_text(camera) +
                  " px; \u00b1 is one sigma";
  table.cells.columns = {"parameter", "value"};
  const Eigen::VectorXd values = camera::intrinsics(camera);
  for (Eigen::Index i = 0;
       i < std::min(values.size(), camera.distortion.size() > kMostShown ? 4 : kMostShown); ++i) {
    const bool known = camera.covariance.rows() == values.size();
    const double sigma = known ? std::sqrt(camera.covariance(i, i)) : std::nan("");
    table.cells.rows.push_back({names[static_cast<std::size_t>(i)] + (i < 4 ? " / px" : ""),
                                with_sigma(values[i], sigma, i < 4 ? 2 : 5)});
  }
  return table;
}

/// A share as what it adds, in percent.
std::string growth(double share) {
  if (std::isnan(share)) return "";
  return std::isfinite(share) ? format_fixed(100.0 * share, 1) + " %" : "the rest fixes no lens";
}

report::PageTable view_table(const calib::Calibration& calibration,
                             const std::vector<calib::ViewGain>& gains) {
  report::PageTable table;
  table.caption =
      "Pictures of the board, by the view numbers of the figures; what one adds is by how much the sigmas of "
      "the focal length and of the whole picture would grow without it";
  table.collapsed = calibration.views.size() > 20;
  const bool any_left_out = std::any_of(calibration.views.begin(), calibration.views.end(),
                                        [](const calib::View& view) { return !view.reason.empty(); });
  table.cells.columns = {
      "view", "picture", "used", "RMS / px", "mean error / px", "adds to focal length", "adds to picture"};
  if (any_left_out) table.cells.columns.emplace_back("why not");
  for (std::size_t i = 0; i < calibration.views.size(); ++i) {
    const calib::View& view = calibration.views[i];
    const bool known = view.used && i < gains.size();
    table.cells.rows.push_back({std::to_string(i + 1), view.image, view.used ? "yes" : "no",
                                view.used ? format_fixed(view.rms_px, 3) : "",
                                view.used ? format_fixed(view.mean_error_px, 3) : "",
                                known ? growth(gains[i].focal) : "", known ? growth(gains[i].picture) : ""});
    if (any_left_out) table.cells.rows.back().push_back(view.reason);
  }
  return table;
}

/// How much of its bound the search for the boards took, and in which pictures it left something out.
std::string search_words(const std::vector<calib::View>& views) {
  const auto most = std::max_element(
      views.begin(), views.end(),
      [](const calib::View& a, const calib::View& b) { return a.search_steps < b.search_steps; });
  if (most == views.end()) return "";
  constexpr double kMillion = 1e6;
  const auto bound = static_cast<double>(target::kMostSearchSteps),
             steps = static_cast<double>(most->search_steps);
  std::string cut;
  for (const calib::View& view : views) {
    if (view.search_cut) cut += (cut.empty() ? "" : ", ") + view.image;
  }
  return "The search for a board ends at " + format_fixed(bound / kMillion, 0) +
         " million steps a picture (pixels looked at, pairs of corners compared); the most was " +
         format_fixed(steps / kMillion, 1) + " million (" + format_fixed(100.0 * steps / bound, 1) +
         " %), in " + most->image + ". " +
         (cut.empty() ? "Nothing was left out."
                      : "So full of detail that weaker corners were left out: " + cut + ".");
}

/// What the set lacks, in words, and the poses that would help most.
void add_next_pictures(const calib::Verdict& verdict, report::Section& section) {
  std::string missing;
  for (const std::string& one : verdict.next_pictures) missing += (missing.empty() ? "" : "; ") + one;
  if (!missing.empty()) section.paragraphs.push_back("Missing among the pictures: " + missing + ".");
  if (verdict.next_views.empty()) return;
  report::PageTable table;
  table.caption =
      "Which pictures to take next, each counting on those before it; sigmas are what the corners' noise "
      "leaves";
  table.cells.columns = {"", "hold the board so", "sigma of the picture / px", "of the focal length / %"};
  for (std::size_t i = 0; i < verdict.next_views.size(); ++i) {
    const calib::NextView& view = verdict.next_views[i];
    table.cells.rows.push_back({std::to_string(i + 1), view.how_to_hold,
                                format_fixed(view.picture_sigma_px, 3), format_fixed(view.focal_percent, 3)});
  }
  section.tables.push_back(std::move(table));
}

report::PageTable truth_table(const std::vector<audit::TruthComparison>& comparison) {
  return {"Height above the canopy against the truth of the simulation (estimate - truth)",
          audit::comparison_table(comparison)};
}

report::PageTable shot_table(const std::vector<audit::ShotRecord>& records) {
  const auto number = [](double value, int decimals) {
    return std::isfinite(value) ? format_fixed(value, decimals) : std::string();
  };
  const auto estimate = [](const Estimate& e, int decimals) {
    return std::isfinite(e.value) ? with_sigma(e.value, e.sigma, decimals) : std::string();
  };
  report::PageTable table;
  table.caption = "Every shot; \u00b1 is one sigma; shots.csv has all columns";
  table.collapsed = records.size() > 12;
  table.cells.columns = {"shot",
                         "log height above take-off / m",
                         "VPS / m",
                         "log pitch / deg",
                         "pitch / deg",
                         "above canopy, thesis / m",
                         "above canopy, spacing / m",
                         "above canopy, refined / m",
                         "above canopy, shot alone / m",
                         "above ground, refined / m",
                         "above canopy, fused / m",
                         "cross-track / m",
                         "heading error / deg",
                         "rows",
                         "status"};
  for (const auto& r : records) {
    table.cells.rows.push_back(
        {r.shot_id, number(r.height_takeoff_m, 1), number(r.height_vps_m, 1), number(r.pitch_log_deg, 1),
         estimate(r.pitch_deg, 2), number(r.above_canopy_thesis_m.value, 2),
         estimate(r.above_canopy_spacing_m, 2), estimate(r.above_canopy_refined_m, 2),
         estimate(r.above_canopy_shot_m, 2), estimate(r.above_ground_refined_m, 2),
         estimate(r.above_canopy_fused_m, 2), estimate(r.cross_track_m, 2), estimate(r.heading_error_deg, 2),
         std::to_string(r.rows_used), r.status == "ok" ? "ok" : r.status + ": " + r.reason});
  }
  return table;
}

std::vector<std::string> run_summary(const RunContent& content,
                                     const std::vector<audit::TruthComparison>& comparison) {
  std::vector<double> heights;
  std::vector<double> sigmas;
  for (const auto& record : content.records) {
    if (!record.above_canopy_refined_m.usable()) continue;
    heights.push_back(record.above_canopy_refined_m.value);
    sigmas.push_back(record.above_canopy_refined_m.sigma);
  }
  std::vector<std::string> words;
  words.push_back(std::to_string(heights.size()) + " of " + std::to_string(content.records.size()) +
                  " shots have a height above the canopy measured from their rows.");
  if (!heights.empty()) {
    double low = heights[0];
    double high = heights[0];
    double sum = 0.0;
    for (std::size_t i = 0; i < heights.size(); ++i) {
      low = std::min(low, heights[i]);
      high = std::max(high, heights[i]);
      sum += sigmas[i];
    }
    words.push_back("Heights run from " + format_fixed(low, 2) + " to " + format_fixed(high, 2) +
                    " m, with a mean sigma of " + format_fixed(sum / static_cast<double>(sigmas.size()), 2) +
                    " m.");
  }
  std::string against_truth;
  for (const audit::TruthComparison& line : comparison) {
    if (line.shots == 0) continue;
    against_truth += (against_truth.empty() ? "Error against the simulation's truth, RMS: " : "; ") +
                     line.method + " " + format_fixed(line.rmse_m, 3) + " m (" +
                     format_fixed(100.0 * line.rmse_share, 1) + " %)";
  }
  if (!against_truth.empty()) words.push_back(against_truth + ".");
  for (const auto& finding : content.findings) {
    if (finding.verdict == audit::Verdict::fail)
      words.push_back("Failed: " + finding.title + ": " + finding.value + ", " + finding.limit + ".");
  }
  return words;
}

}  // namespace

std::string with_sigma(double value, double sigma, int decimals) {
  return format_fixed(value, decimals) +
         (std::isfinite(sigma) ? " \u00b1 " + format_fixed(sigma, decimals) : "");
}

namespace {

/// A figure to draw; one that is not wanted is left out where a calibration has no numbers for it.
struct ToDraw {
  bool wanted;
  std::function<Result<figures::Figure>()> draw;
};

void add_uncertainty(const calib::Calibration& calibration, double flight_height_m,
                     std::vector<ToDraw>& out) {
  const Camera& camera = calibration.camera;
  const std::string height = format_fixed(flight_height_m, 1) + " m";
  const auto map = [&camera](const std::string& name, const std::string& quantity, const std::string& caption,
                             calib::UncertaintyMap (*values)(const calib::Calibration&, double, int, int),
                             const calib::Calibration& of, double distance_m) {
    constexpr int kColumns = 48, kRows = 32;
    return [=, &camera, &of] {
      return figures::picture_map({name, quantity, caption, kColumns, kRows, camera.width, camera.height,
                                   values(of, distance_m, kColumns, kRows).values});
    };
  };
  out.push_back({false, map("projection_uncertainty", "projection sigma / px",
                            "Standard deviation, in the worst direction, of where a point " + height +
                                " away is seen: what the corners' noise leaves open of the lens, the boards' "
                                "poses counted (mrcal's definition).",
                            calib::projection_sigma_map, calibration, flight_height_m)});
  out.push_back({false, map("height_error", "height error / %",
                            "The same as an error of the height, one sigma, when a known length between the "
                            "picture's middle and that place is seen from " +
                                height + "; in the middle it is the focal length's.",
                            calib::height_error_map, calibration, flight_height_m)});
}

/// The part of a photograph that a view shows, no larger than a figure can use.
Result<Image> telling_part(const std::filesystem::path& file, const Camera& camera, const calib::TellingView& view) {
  FURROW_TRY(const Image whole, image::read_image(file));
  if (whole.width != camera.width || whole.height != camera.height)
    return Error{"picture_size_differs", file.filename().string(),
                 std::to_string(whole.width) + "x" + std::to_string(whole.height), size_text(camera), ""};
  constexpr int kWidestPx = 1600;  // beyond what the figure's width holds, so that shrinking twice costs no detail
  Image part = image::crop(whole, view.left_px, view.top_px, view.width_px, view.height_px);
  if (part.width <= kWidestPx) return part;
  const double scale = static_cast<double>(kWidestPx) / part.width;
  return image::resize(part, kWidestPx, std::max(1, static_cast<int>(std::lround(scale * part.height))));
}

void add_corners(const JudgedCalibration& judged, std::vector<ToDraw>& out) {
  for (std::size_t i = 0; i < judged.telling.views.size(); ++i) {
    out.push_back({false, [&judged, i]() -> Result<figures::Figure> {
                     const calib::TellingView& view = judged.telling.views[i];
                     FURROW_TRY(const Image part, telling_part(judged.pictures[view.view], judged.calibration.camera, view));
                     // Photographs are what a page weighs and what takes longest to paint.
                     constexpr double kPhotographDpi = 150.0;
                     return figures::corners_overlay(part, judged.calibration, judged.telling, i,
                                                     {figures::kTwoColumnsMm, kPhotographDpi});
                   }});
  }
}

std::vector<ToDraw> to_draw(const JudgedCalibration& judged, double flight_height_m) {
  const calib::Calibration& calibration = judged.calibration;
  const calib::Verdict& verdict = judged.verdict;
  std::vector<ToDraw> out{{true, [&] { return figures::reprojection_bars(calibration); }}};
  add_corners(judged, out);
  const std::vector<ToDraw> more{
      {true, [&] { return figures::board_poses(calibration); }},
      {true, [&] { return figures::coverage_map(calibration); }},
      {true, [&] { return figures::residual_map(calibration); }},
      {true, [&] { return figures::residual_histogram(calibration); }},
      {false, [&] { return figures::distortion_curve(camera::distortion_curve(calibration.camera)); }}};
  out.insert(out.end(), more.begin(), more.end());
  add_uncertainty(calibration, flight_height_m, out);
  if (!verdict.halves) return out;
  out.push_back({false, [&] {
                   return figures::picture_map(figures::difference_map(
                       "halves_difference",
                       "Cross-validation: how far two cameras, each solved from every other picture, put the "
                       "same direction apart; RMS " +
                           format_fixed(verdict.halves_rms_px, 3) + " px, where their covariances predict " +
                           format_fixed(verdict.halves_expected_rms_px, 3) + " px.",
                       calibration.camera, *verdict.halves));
                 }});
  return out;
}

}  // namespace

Result<std::vector<figures::Figure>> calibration_figures(const JudgedCalibration& judged,
                                                         double flight_height_m, int threads) {
  const std::vector<ToDraw> wanted = to_draw(judged, flight_height_m);
  std::vector<std::optional<Result<figures::Figure>>> drawn(wanted.size());
  base::parallel_for(wanted.size(), threads, [&](std::size_t i) { drawn[i] = wanted[i].draw(); });
  std::vector<figures::Figure> made;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!drawn[i]->ok() && wanted[i].wanted) return drawn[i]->error();
    if (drawn[i]->ok()) made.push_back(std::move(*drawn[i]).value());
  }
  return made;
}

report::Section calibration_section(const calib::Calibration& calibration, const calib::Verdict& verdict,
                                    const std::vector<audit::Finding>& findings,
                                    std::vector<figures::Figure> made) {
  report::Section section;
  section.title = "Calibration";
  const auto& board = calibration.board;
  section.paragraphs = {
      "Board " + board.name + ": " + std::to_string(board.corners_x) + " x " +
          std::to_string(board.corners_y) + " inner corners, squares of " +
          format_fixed(1000.0 * board.square_m, 2) + " mm" +
          (board.aspect == 1.0 ? "" : ", height / width " + format_fixed(board.aspect, 4)) + ".",
      "RMS is over the distances of all corners in both directions (OpenCV's definition; mrcal prints this "
      "divided by "
      "the square root of 2). The solve ended after " +
          std::to_string(calibration.iterations) + " iterations (Ceres: " + calibration.termination + ")."};
  if (calibration.board_aspect.observations > 0) {
    section.paragraphs.push_back(
        "The board's squares were not taken for square: height / width solved as " +
        with_sigma(calibration.board_aspect.value, calibration.board_aspect.sigma, 4) +
        ", with square pixels (fx = fy).");
  }
  if (!calibration.model_choice.empty()) section.paragraphs.push_back(calibration.model_choice);
  section.paragraphs.insert(section.paragraphs.end(), calibration.warnings.begin(),
                            calibration.warnings.end());
  section.paragraphs.push_back(search_words(calibration.views));
  section.findings = findings;
  section.tables = {camera_table(calibration.camera), view_table(calibration, verdict.gains)};
  add_next_pictures(verdict, section);
  section.figures = std::move(made);
  return section;
}

report::Page calibration_page(const calib::Calibration& calibration, const calib::Verdict& verdict,
                              report::Section section) {
  std::size_t used = 0;
  for (const auto& view : calibration.views) used += view.used ? 1 : 0;
  const Camera& camera = calibration.camera;
  report::Page page;
  page.title = "Camera calibration";
  page.subtitle = std::to_string(used) + " of " + std::to_string(calibration.views.size()) + " pictures, " +
                  std::to_string(calibration.corners) + " corners, " + size_text(camera) + " px";
  const auto measured = [&camera](double value, Eigen::Index i) {
    return with_sigma(value, i < camera.covariance.rows() ? std::sqrt(camera.covariance(i, i)) : std::nan(""),
                      2);
  };
  page.summary = {verdict.trusted ? "Enough: the pictures fix this camera well enough for a height."
                                  : "Do not trust this camera with a height; why not stands below.",
                  "Focal length fx " + measured(camera.fx, 0) + ", fy " + measured(camera.fy, 1) +
                      " px; principal point (" + measured(camera.cx, 2) + ", " + measured(camera.cy, 3) +
                      ") px; \u00b1 is one sigma of what noise does.",
                  "Reprojection error " + format_fixed(calibration.rms_px, 3) + " px RMS, " +
                      format_fixed(calibration.mean_error_px, 3) + " px mean distance."};
  page.sections.push_back(std::move(section));
  page.provenance = {{"program", "furrow " + base::version()}, {"command", "calibrate"}};
  return page;
}

report::Page run_page(RunContent content) {
  const auto comparison = audit::compare_with_truth(content.records);
  report::Page page;
  page.title = content.project.name;
  page.subtitle =
      "Height above the crop from row geometry, " + std::to_string(content.records.size()) + " shots";
  page.summary = run_summary(content, comparison);

  report::Section heights;
  heights.title = "Heights";
  heights.findings = content.findings;
  if (!comparison.empty()) heights.tables.push_back(truth_table(comparison));
  heights.figures = std::move(content.flight_figures);
  heights.tables.push_back(shot_table(content.records));
  page.sections.push_back(std::move(heights));

  page.sections.push_back(legs_section(content.records, content.project.field.row_height_m.value,
                                       std::move(content.leg_figures)));
  page.sections.push_back(flight_section(content.flight));
  page.sections.push_back(budget_section(content.budgets, std::move(content.budget_figures)));
  page.sections.push_back(fusion_section(content.records, content.fusion, std::move(content.fusion_figures)));

  report::Section rows;
  rows.title = "Rows";
  rows.paragraphs = {
      "Rows as they were found in pictures spread over the flight; rows.json has all of them."};
  rows.figures = std::move(content.overlays);
  page.sections.push_back(std::move(rows));

  report::Section camera;
  camera.title = "Camera";
  camera.paragraphs = std::move(content.camera_words);
  if (content.calibration.empty()) camera.tables.push_back(camera_table(content.camera));
  page.sections.push_back(std::move(camera));
  for (auto& section : content.calibration) page.sections.push_back(std::move(section));

  report::Section log;
  log.title = "Log";
  log.paragraphs = std::move(content.log_words);
  page.sections.push_back(std::move(log));
  page.provenance = {{"program", "furrow " + base::version()},
                     {"command", "run"},
                     {"project", content.project.file.filename().string()},
                     {"input and output hashes", "manifest.json"}};
  return page;
}

}  // namespace furrow::project
