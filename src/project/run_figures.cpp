#include "project/run_figures.h"

#include "furrow/altitude/birds_eye.h"
#include "furrow/figures/comparison.h"
#include "furrow/figures/figures.h"
#include "furrow/figures/pictures.h"
#include "furrow/figures/sources.h"
#include "furrow/figures/stacked.h"
#include "furrow/image/image.h"

namespace furrow::project {
namespace {

/// Overlays in the report: enough to judge the detection over the flight, few enough to read.
constexpr std::size_t kReportOverlays = 4;

/// Up to kReportOverlays shots, evenly spread over those with rows.
std::vector<std::size_t> shots_to_show(const std::vector<ShotResult>& results) {
  std::vector<std::size_t> with_rows;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].lines.ok()) with_rows.push_back(i);
  }
  if (with_rows.size() <= kReportOverlays) return with_rows;
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < kReportOverlays; ++k)
    chosen.push_back(with_rows[k * (with_rows.size() - 1) / (kReportOverlays - 1)]);
  return chosen;
}

/// From straight above, for a shot that the flight's refinement holds.
Status add_birds_eye(std::vector<figures::Figure>& made, const Image& picture, const ShotResult& result,
                     const altitude::RefinedShot& shot) {
  const auto view = altitude::birds_eye(picture, result.lines, *result.camera, shot);
  if (!view.ok()) return view.error().code == "no_ground" ? Status(Done{}) : view.error();
  FURROW_TRY(made.emplace_back(), figures::birds_eye(*view, result.record.shot_id));
  return Done{};
}

/// Keeps a figure; one that had nothing to draw is left out.
Status keep(std::vector<figures::Figure>& made, Result<figures::Figure> figure) {
  if (!figure.ok() && figure.error().code == "nothing_to_draw") return Done{};
  FURROW_TRY(made.emplace_back(), std::move(figure));
  return Done{};
}

}  // namespace

Result<std::vector<figures::Figure>> overlays(const std::vector<telemetry::Shot>& shots,
                                              const std::vector<ShotResult>& results,
                                              const Result<altitude::RefinedFlight>& flight) {
  std::vector<figures::Figure> made;
  for (const std::size_t i : shots_to_show(results)) {
    FURROW_TRY(const Image picture, image::read_image(shots[i].image));
    FURROW_TRY(made.emplace_back(),
               figures::row_overlay(picture, results[i].lines, results[i].record.shot_id));
    if (flight.ok() && flight->shots[i].usable)
      FURROW_DO(add_birds_eye(made, picture, results[i], flight->shots[i]));
  }
  return made;
}

Status draw_heights(RunContent& content) {
  const auto& records = content.records;
  const double row_height_m = content.project.field.row_height_m.value;
  auto& flight = content.flight_figures;
  FURROW_TRY(flight.emplace_back(), figures::heights_over_shots(records, row_height_m));
  FURROW_TRY(flight.emplace_back(), figures::pitch_over_shots(records));
  FURROW_TRY(flight.emplace_back(), figures::cross_track_over_shots(records));
  FURROW_DO(keep(flight, figures::agreement(figures::heights_against_log(records))));
  FURROW_DO(keep(flight, figures::error_histogram(figures::heights_against_truth(records))));
  FURROW_DO(keep(content.leg_figures, figures::heights_by_leg(records, row_height_m)));
  FURROW_DO(keep(content.leg_figures, figures::log_heights_over_shots(records, false)));
  FURROW_DO(keep(content.leg_figures, figures::log_heights_over_shots(records, true)));
  FURROW_DO(keep(content.budget_figures, figures::budget_over_shots(content.budgets)));
  if (!content.fusion.ok()) return Done{};
  return keep(content.fusion_figures, figures::fusion_over_shots(records, *content.fusion));
}

}  // namespace furrow::project
