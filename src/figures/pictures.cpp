// Figures made of pictures.
#include "furrow/figures/pictures.h"

#include <algorithm>
#include <cmath>

#include "figures/finish.h"
#include "figures/font.h"
#include "figures/plot.h"
#include "furrow/base/text.h"

namespace furrow::figures {
namespace {

/// Edges narrower than the picture's own detail: line art and masks keep their exact pixels.
bool few_tones(const Image& picture) {
  constexpr std::size_t kStep = 97, kMostTones = 24;
  std::vector<bool> seen(256, false);
  std::size_t tones = 0;
  for (std::size_t i = 0; i < picture.data.size(); i += kStep) {
    if (seen[picture.data[i]]) continue;
    seen[picture.data[i]] = true;
    ++tones;
  }
  return tones <= kMostTones;
}

/// An upright line through the whole picture with a triangle at its foot.
void draw_upright(Drawing& drawing, double x, double height_pt, Colour colour, double width_pt,
                  const Dash& dash) {
  constexpr Colour kRim{0x10, 0x10, 0x10, 170};
  for (const auto& [ink, width] : {std::pair{kRim, width_pt + 1.2}, std::pair{colour, width_pt}}) {
    drawing.items.push_back(Stroke{{{x, 0.0}, {x, height_pt}}, ink, width, dash});
  }
  drawing.items.push_back(Fill{{{x, height_pt - 9.0}, {x + 5.0, height_pt}, {x - 5.0, height_pt}}, colour});
}

}  // namespace

Result<Figure> contact_sheet(const std::string& name, const std::string& caption,
                             const std::vector<NamedPicture>& pictures, const FigureOptions& options) {
  const auto empty = [](const NamedPicture& one) { return one.picture.empty() || one.picture.width < 1; };
  if (pictures.empty()) return nothing_to_draw(name, "no pictures", "at least one");
  if (const auto bad = std::find_if(pictures.begin(), pictures.end(), empty); bad != pictures.end()) {
    return nothing_to_draw(name, "an empty picture, \"" + bad->name + "\"", "pictures with pixels");
  }
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  constexpr double kGapPt = 6.0, kNarrowestPt = 150.0;
  const double inner = drawing.width_pt - 2 * kMarginPt;
  const auto columns =
      std::clamp<std::size_t>(static_cast<std::size_t>(inner / kNarrowestPt), 1, pictures.size());
  const double width = (inner - kGapPt * static_cast<double>(columns - 1)) / static_cast<double>(columns);
  double top = kMarginPt;
  for (std::size_t first = 0; first < pictures.size(); first += columns) {
    double tallest = 0.0;
    for (std::size_t i = first; i < std::min(first + columns, pictures.size()); ++i) {
      const Image& image = pictures[i].picture;
      const double height = std::min(width * image.height / image.width, 1.6 * width);
      const double own_width = height * image.width / image.height;
      const Point corner(kMarginPt + static_cast<double>(i - first) * (width + kGapPt), top);
      drawing.pictures.push_back({image, corner, own_width, height, few_tones(image)});
      add_frame(drawing, corner, corner + Point(own_width, height), kMidGrey, 0.5);
      drawing.items.push_back(Text{corner + Point(0, height + 3.0 + kCapHeight * kLegendTextPt),
                                   std::to_string(i + 1) + ". " + pictures[i].name, kLegendTextPt});
      tallest = std::max(tallest, height);
    }
    top += tallest + 2.2 * kLegendTextPt;
  }
  drawing.height_pt = top;
  return finish(name, caption, drawing, {}, options);
}

Result<Figure> following_overlay(const Image& picture, const FollowingView& view, const std::string& shot_id,
                                 const FigureOptions& options) {
  const std::string name = "following_" + file_stem(shot_id);
  if (picture.empty() || picture.width < 1)
    return nothing_to_draw(name, "an empty picture", "the shot's picture");
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  const double scale = drawing.width_pt / picture.width, height = picture.height * scale;
  drawing.pictures.push_back({picture, Point::Zero(), drawing.width_pt, height, false});
  const double middle_px = 0.5 * (picture.width - 1);
  const auto x_at = [&](double deviation_px) { return scale * (middle_px + deviation_px + 0.5); };
  struct Line {
    LegendEntry look;
    std::optional<double> at_px;
  };
  // The thesis's green, red and blue, in colours that stay apart for everybody.
  const std::vector<Line> lines{{{"picture's middle", kGreen, 1.4}, 0.0},
                                {{"followed row", kVermillion, 1.4, {5.0, 2.5}}, view.deviation_px},
                                {{"steer by", kBlue, 1.8, {1.8, 1.8}}, view.steer_px}};
  std::vector<LegendEntry> legend;
  base::CsvTable table;
  table.columns = {"line", "deviation_px"};
  std::string numbers;
  for (const Line& line : lines) {
    if (!line.at_px || !std::isfinite(*line.at_px)) continue;
    const double x = x_at(*line.at_px);
    if (x >= 0.0 && x <= drawing.width_pt) {
      draw_upright(drawing, x, height, line.look.colour, line.look.line_pt, line.look.dash);
    }
    LegendEntry entry = line.look;
    if (&line != &lines.front()) entry.name += ", " + tick_text(*line.at_px, 1) + " px";
    legend.push_back(entry);
    table.rows.push_back({line.look.name, cell(*line.at_px, 4)});
  }
  drawing.height_pt = height + kMarginPt;
  drawing.height_pt +=
      draw_legend(drawing, {kMarginPt, height + kMarginPt}, drawing.width_pt - 2 * kMarginPt, legend);
  const std::string caption = "Row following in " + shot_id +
                              ": the middle of the picture, the followed row where it crosses the middle "
                              "picture row, drawn upright, and the line to steer by" +
                              (view.deviation_px ? "." : "; no row crosses the middle here.");
  return finish(name, caption, drawing, std::move(table), options);
}

Result<Figure> residual_map(const calib::Calibration& calibration, const FigureOptions& options) {
  const std::string name = "residual_map";
  std::vector<double> lengths;
  for (const calib::View& view : calibration.views) {
    if (!view.used) continue;
    for (const auto& residual : view.residual_px) lengths.push_back(residual.norm());
  }
  std::erase_if(lengths, [](double v) { return !std::isfinite(v); });
  if (lengths.empty() || calibration.camera.width < 1) {
    return nothing_to_draw(name, "a calibration without residuals", "at least one used view");
  }
  std::sort(lengths.begin(), lengths.end());
  const double typical = std::max(lengths[lengths.size() * 95 / 100], 1e-9);
  // The 95th percentile becomes 4 % of the picture's width, by a round factor.
  const Ticks steps = nice_ticks(0.0, 0.04 * calibration.camera.width / typical, 2);
  const double factor = steps.values.size() > 1 ? steps.values.back() : 1.0;

  const double aspect = static_cast<double>(calibration.camera.height) / calibration.camera.width;
  FURROW_TRY(Drawing drawing, paper(options, 1.0));
  const double inner = drawing.width_pt - 2 * kMarginPt;
  LegendEntry arrows{"residual of a corner, " + tick_text(factor, 0) + " times enlarged", kBlue, 0.8};
  drawing.height_pt = 1.0;
  const double legend_height = draw_legend(drawing, {kMarginPt, kMarginPt}, inner, {arrows});
  drawing.height_pt = legend_height + std::min(aspect, 1.4) * (inner - 40.0) + 40.0;
  const Axis x = axis_between("u / px", -0.5, calibration.camera.width - 0.5, 8);
  const Axis y = axis_between("v / px", -0.5, calibration.camera.height - 0.5, 6);
  Frame frame = draw_axes(drawing, {kMarginPt, kMarginPt + legend_height},
                          {drawing.width_pt - kMarginPt, drawing.height_pt - kMarginPt}, x, flipped(y));
  base::CsvTable table;
  table.columns = {"view_number", "u_px", "v_px", "residual_u_px", "residual_v_px"};
  for (std::size_t k = 0; k < calibration.views.size(); ++k) {
    const calib::View& view = calibration.views[k];
    if (!view.used) continue;
    for (std::size_t i = 0; i < std::min(view.observed_px.size(), view.residual_px.size()); ++i) {
      const Eigen::Vector2d at = view.observed_px[i], tip = at + factor * view.residual_px[i];
      table.rows.push_back({std::to_string(k + 1), cell(at.x(), 3), cell(at.y(), 3),
                            cell(view.residual_px[i].x(), 4), cell(view.residual_px[i].y(), 4)});
      if (!at.allFinite() || !tip.allFinite()) continue;
      for (const auto& part : clip({frame.map(at.x(), at.y()), frame.map(tip.x(), tip.y())}, frame.top_left,
                                   frame.bottom_right)) {
        drawing.items.push_back(Stroke{part, kBlue, 0.7});
        add_marker(drawing, Marker::circle, frame.map(at.x(), at.y()), 1.5, kInk);
      }
    }
  }
  const std::string caption = "Residuals of " + count_of(lengths.size(), "corner") +
                              " over the picture, found minus projected, " + tick_text(factor, 0) +
                              " times enlarged; 95 % of them are shorter than " + cell(typical, 3) +
                              " px. Dots are the corners. Arrows that agree with their neighbours show what "
                              "the lens model leaves over.";
  return finish(name, caption, drawing, std::move(table), options);
}

}  // namespace furrow::figures
