// What each source says of the height.
#include "furrow/figures/sources.h"

#include <cmath>
#include <limits>

#include "figures/finish.h"
#include "figures/looks.h"
#include "figures/plot.h"

namespace furrow::figures {
namespace {

using altitude::HeightSource;
using audit::ShotRecord;

constexpr double kPlotHeightMm = 78.0;

Series look_of(HeightSource source) {
  switch (source) {
    case HeightSource::vision:
      return look("rows (vision)", kBlue, 0.0, {}, Marker::circle);
    case HeightSource::depth:
      return look("depth map, less its bias", kMidGrey, 0.0, {}, Marker::plus);
    case HeightSource::baro:
      return look("log (barometer), less its bias", kOrange, 0.0, {}, Marker::square);
    case HeightSource::vps:
      return look("VPS, soil less the row height", kGreen, 0.0, {}, Marker::diamond);
    case HeightSource::gnss:
      return look("GNSS, less its bias", kSkyBlue, 0.0, {}, Marker::triangle);
  }
  return {};
}

/// Readings of a source with the bias taken off: the fused height and what the reading is away from it.
Series readings_of(const audit::FlightFusion& fusion, HeightSource source, bool gated) {
  Series series = gated ? look("left out", kVermillion, 0.0, {}, Marker::cross) : look_of(source);
  const auto place = static_cast<std::size_t>(source);
  for (std::size_t i = 0; i < fusion.samples.size(); ++i) {
    const altitude::FusedHeight& height = fusion.fused.heights[i];
    const bool wanted = height.left_out[place] == gated;
    series.x.push_back(static_cast<double>(fusion.shots[i] + 1));
    series.y.push_back(wanted ? height.above_canopy_m.value + height.residual_m[place]
                              : std::numeric_limits<double>::quiet_NaN());
  }
  return series;
}

bool any_value(const Series& series) {
  for (const double y : series.y) {
    if (std::isfinite(y)) return true;
  }
  return false;
}

Series fused_series(const audit::FlightFusion& fusion) {
  Series series = look("fused, \u00b11\u03c3", kPurple, 1.3, {}, Marker::none);
  for (std::size_t i = 0; i < fusion.samples.size(); ++i) {
    series.x.push_back(static_cast<double>(fusion.shots[i] + 1));
    series.y.push_back(fusion.fused.heights[i].above_canopy_m.value);
    series.sigma.push_back(fusion.fused.heights[i].above_canopy_m.sigma);
  }
  return series;
}

Series truth_series(const std::vector<ShotRecord>& records) {
  Series series = truth_look();
  for (std::size_t i = 0; i < records.size(); ++i) {
    series.x.push_back(static_cast<double>(i + 1));
    series.y.push_back(records[i].truth_above_canopy_m);
  }
  return series;
}

/// The axis is set by the fused heights and the readings used; what was left out may lie beyond it.
Axis axis_of(const Series& fused, const std::vector<Series>& readings) {
  std::vector<double> inside;
  for (std::size_t i = 0; i < fused.y.size(); ++i) {
    inside.push_back(fused.y[i] - fused.sigma[i]);
    inside.push_back(fused.y[i] + fused.sigma[i]);
  }
  for (const Series& series : readings) inside.insert(inside.end(), series.y.begin(), series.y.end());
  std::erase_if(inside, [](double v) { return !std::isfinite(v); });
  return axis_over("height above canopy / m", inside, 7);
}

}  // namespace

Result<Figure> fusion_over_shots(const std::vector<ShotRecord>& records, const audit::FlightFusion& fusion,
                                 const FigureOptions& options) {
  const std::string name = "fusion_over_shots";
  if (fusion.samples.empty()) return nothing_to_draw(name, "no shot with a time", "at least one");
  const Series fused = fused_series(fusion), truth = truth_series(records);
  std::vector<Series> used, drawn;
  Series out;
  for (const HeightSource source : audit::speaking_sources(fusion)) {
    used.push_back(readings_of(fusion, source, false));
    const Series gated = readings_of(fusion, source, true);
    out = out.x.empty() ? gated : out;
    drawn.push_back(gated);
  }
  std::vector<LegendEntry> legend = {legend_of(fused)};
  for (const Series& series : used) legend.push_back(legend_of(series));
  bool any_gated = false;
  for (const Series& series : drawn) any_gated |= any_value(series);
  if (any_gated) legend.push_back(legend_of(out));
  if (any_value(truth)) legend.push_back(legend_of(truth));

  FURROW_TRY(Drawing drawing, paper(options, kPlotHeightMm));
  const double inner_width = drawing.width_pt - 2 * kMarginPt;
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner_width, legend);
  const Frame frame =
      draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt},
                counting_axis("shot number", records.size(), inner_width), axis_of(fused, used));
  drawn.insert(drawn.end(), used.begin(), used.end());
  if (any_value(truth)) drawn.push_back(truth);
  drawn.push_back(fused);
  const int beyond = draw_series(drawing, frame, drawn);
  return finish(
      name,
      "Height above the canopy from all sources together, the band one sigma wide to each side, and "
      "what each source says once its bias is taken off." +
          beyond_text(beyond),
      drawing, audit::fusion_table(records, fusion), options);
}

}  // namespace furrow::figures
