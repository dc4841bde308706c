// A sigma and what it is made of.
#include "furrow/figures/stacked.h"

#include <algorithm>
#include <cmath>

#include "figures/finish.h"
#include "figures/plot.h"
#include "furrow/geom/angles.h"

namespace furrow::figures {
namespace {

constexpr double kPlotHeightMm = 72.0;
constexpr Colour kLightGrey{0xB4, 0xB4, 0xB4};

/// Causes that belong together, from the bottom of the stack to its top.
struct Layer {
  std::string name;
  Colour colour;
  std::vector<std::string> causes;
};

const std::vector<Layer>& layers() {
  static const std::vector<Layer> kLayers = {{"picture", kBlue, {"picture"}},
                                             {"plants", kGreen, {"plants"}},
                                             {"spacing", kVermillion, {"spacing"}},
                                             {"half width", kOrange, {"half_width"}},
                                             {"foliage and outline", kSkyBlue, {"foliage", "outline"}},
                                             {"pitch and slope", kPurple, {"pitch", "terrain", "ground"}},
                                             {"roll", kMidGrey, {"roll"}},
                                             {"camera", kBlack, {"focal", "distortion"}},
                                             {"other shots", kLightGrey, {"other"}}};
  return kLayers;
}

/// One bar of the stack, from `low` to `high` on the x axis.
struct Bar {
  double low = 0.0, high = 0.0;
  double sigma = 0.0;  ///< NaN for none
  std::vector<altitude::SigmaShare> shares;
};

/// Height of a layer: its part of the squares, so that the layers add up to the sigma.
double thickness(const Bar& bar, const Layer& layer) {
  double mine = 0.0, all = 0.0;
  for (const altitude::SigmaShare& share : bar.shares) {
    const double square = share.sigma_m * std::abs(share.sigma_m);
    all += square;
    if (std::find(layer.causes.begin(), layer.causes.end(), share.cause) != layer.causes.end())
      mine += square;
  }
  return all > 0.0 && std::isfinite(bar.sigma) ? bar.sigma * std::max(0.0, mine / all) : 0.0;
}

/// A layer over all bars as one stepped area.
Band band_of(const std::vector<Bar>& bars, const std::vector<double>& below, const std::vector<double>& above,
             const Frame& frame, Colour colour) {
  Band band{{}, {}, colour};
  for (std::size_t i = 0; i < bars.size(); ++i) {
    for (const double x : {bars[i].low, bars[i].high}) {
      band.upper.push_back(frame.map(x, std::min(above[i], frame.y.high)));
      band.lower.push_back(frame.map(x, std::min(below[i], frame.y.high)));
    }
  }
  return band;
}

struct Stack {
  std::string name, caption;
  Axis x;
  std::string y_text;
  std::vector<Bar> bars;
  base::CsvTable data;
};

/// Layers that are thick enough anywhere to be seen.
std::vector<Layer> layers_in(const std::vector<Bar>& bars) {
  std::vector<Layer> seen;
  for (const Layer& layer : layers()) {
    const bool shown = std::any_of(bars.begin(), bars.end(),
                                   [&](const Bar& bar) { return thickness(bar, layer) > 0.005 * bar.sigma; });
    if (shown) seen.push_back(layer);
  }
  return seen;
}

Result<Figure> draw_stack(const Stack& stack, const FigureOptions& options) {
  std::vector<double> sigmas;
  for (const Bar& bar : stack.bars) {
    if (std::isfinite(bar.sigma)) sigmas.push_back(bar.sigma);
  }
  if (sigmas.empty()) return nothing_to_draw(stack.name, "no height with a sigma", "at least one");
  FURROW_TRY(Drawing drawing, paper(options, kPlotHeightMm));
  const std::vector<Layer> shown = layers_in(stack.bars);
  std::vector<LegendEntry> legend;
  for (const Layer& layer : shown) {
    LegendEntry entry{layer.name, layer.colour};
    entry.bar = true;
    legend.push_back(entry);
  }
  const double inner_width = drawing.width_pt - 2 * kMarginPt;
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner_width, legend);
  const Frame frame = draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                                {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt}, stack.x,
                                axis_over(stack.y_text, sigmas, 6, true));
  std::vector<double> below(stack.bars.size(), 0.0);
  for (const Layer& layer : shown) {
    std::vector<double> above = below;
    for (std::size_t i = 0; i < above.size(); ++i) above[i] += thickness(stack.bars[i], layer);
    drawing.items.push_back(band_of(stack.bars, below, above, frame, layer.colour));
    below = above;
  }
  return finish(stack.name, stack.caption, drawing, stack.data, options);
}

constexpr const char* kHowToRead =
    " Each layer is as thick as its part of the variance; together they are as high as the sigma.";

/// Bars between the middles of neighbouring places.
std::vector<Bar> bars_at(const std::vector<double>& places, const std::vector<altitude::PlannedShot>& plans) {
  std::vector<Bar> bars;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double before = i > 0 ? 0.5 * (places[i] - places[i - 1]) : 0.0;
    const double after = i + 1 < places.size() ? 0.5 * (places[i + 1] - places[i]) : before;
    const Estimate& height = plans[i].height_above_canopy_m;
    bars.push_back({places[i] - (i > 0 ? before : after), places[i] + after,
                    100.0 * height.sigma / height.value, plans[i].height_budget});
  }
  return bars;
}

base::CsvTable plan_data(const std::vector<altitude::PlannedShot>& plans) {
  std::vector<audit::ShotBudget> budgets;
  budgets.reserve(plans.size());
  for (const altitude::PlannedShot& plan : plans)
    budgets.push_back(
        {cell(geom::rad_to_deg(plan.pose.pitch_rad), 1), plan.height_above_canopy_m, plan.height_budget});
  base::CsvTable table = audit::budget_table(budgets);
  table.columns[0] = "pitch_deg";
  table.columns[1] = "above_canopy_m";
  table.columns[2] = "above_canopy_sigma_m";
  return table;
}

Result<Figure> draw_plans(const std::string& name, const std::string& over, const std::string& x_text,
                          const std::vector<double>& places, const std::vector<altitude::PlannedShot>& plans,
                          const FigureOptions& options) {
  if (plans.empty()) return nothing_to_draw(name, "no planned shot with a height", "at least one");
  Stack stack{name,
              "Sigma of the height above the canopy to expect over " + over + ", by cause." + kHowToRead,
              axis_over(x_text, places, 8),
              "sigma / % of height",
              bars_at(places, plans),
              plan_data(plans)};
  stack.x.low = std::min(stack.x.low, stack.bars.front().low);
  stack.x.high = std::max(stack.x.high, stack.bars.back().high);
  return draw_stack(stack, options);
}

}  // namespace

Result<Figure> budget_over_shots(const std::vector<audit::ShotBudget>& budgets,
                                 const FigureOptions& options) {
  Stack stack;
  stack.name = "budget_over_shots";
  stack.x = counting_axis("shot number", budgets.size(), options.width_mm * kPointsPerMm);
  stack.y_text = "sigma of height above canopy / m";
  stack.caption = "Sigma of the refined height above the canopy, by cause." + std::string(kHowToRead);
  for (std::size_t i = 0; i < budgets.size(); ++i) {
    const double at = static_cast<double>(i + 1);
    const auto& height = budgets[i].above_canopy_m;
    stack.bars.push_back(
        {at - 0.5, at + 0.5, height.usable() ? height.sigma : std::nan(""), budgets[i].shares});
  }
  stack.x.low = 0.5;
  stack.x.high = static_cast<double>(budgets.size()) + 0.5;
  stack.data = audit::budget_table(budgets);
  return draw_stack(stack, options);
}

Result<Figure> plan_over_pitch(const std::vector<altitude::PlannedShot>& plans,
                               const FigureOptions& options) {
  // From straight down to the horizon, as angles grow.
  std::vector<altitude::PlannedShot> ordered(plans.rbegin(), plans.rend());
  std::sort(ordered.begin(), ordered.end(),
            [](const auto& a, const auto& b) { return a.pose.pitch_rad < b.pose.pitch_rad; });
  std::vector<double> places;
  places.reserve(ordered.size());
  for (const altitude::PlannedShot& plan : ordered) places.push_back(geom::rad_to_deg(plan.pose.pitch_rad));
  return draw_plans("plan_over_pitch", "the camera's pitch", "camera pitch / \u00b0", places, ordered,
                    options);
}

Result<Figure> plan_over_height(const std::vector<altitude::PlannedShot>& plans,
                                const FigureOptions& options) {
  std::vector<double> places;
  places.reserve(plans.size());
  for (const altitude::PlannedShot& plan : plans) places.push_back(plan.pose.height_above_canopy_m);
  return draw_plans("plan_over_height", "the height above the canopy", "height above canopy / m", places,
                    plans, options);
}

}  // namespace furrow::figures
