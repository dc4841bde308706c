#include "figures/finish.h"

#include <cmath>

#include "figures/canvas.h"
#include "figures/plot.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"

namespace furrow::figures {

Result<Drawing> paper(const FigureOptions& options, double height_mm) {
  // Below this axis texts no longer fit beside a plot; above, a figure is wider than any page.
  constexpr double kNarrowestMm = 60.0, kWidestMm = 1000.0;
  if (!(options.width_mm >= kNarrowestMm && options.width_mm <= kWidestMm) || !(options.dpi >= 30.0)) {
    return Error{"figure_size", "figures",
                 "a figure " + base::format_double(options.width_mm) + " mm wide at " +
                     base::format_double(options.dpi) + " dpi",
                 "60 to 1000 mm and at least 30 dpi", ""};
  }
  Drawing drawing;
  drawing.width_pt = options.width_mm * kPointsPerMm;
  drawing.height_pt = height_mm * kPointsPerMm;
  return drawing;
}

Result<Figure> finish(const std::string& name, const std::string& caption, const Drawing& drawing,
                      base::CsvTable data, const FigureOptions& options) {
  FURROW_TRY(Rendered painted, render(drawing, options.dpi, name, caption));
  Figure figure;
  figure.name = name;
  figure.caption = caption;
  figure.png = std::move(painted.png);
  figure.svg = std::move(painted.svg);
  figure.data = std::move(data);
  figure.width_px = painted.width_px;
  figure.height_px = painted.height_px;
  return figure;
}

Error nothing_to_draw(const std::string& figure, const std::string& found, const std::string& wanted) {
  return {"nothing_to_draw", figure, found, wanted, ""};
}

std::string cell(double value, int decimals) {
  return std::isfinite(value) ? base::format_fixed(value, decimals) : std::string();
}

std::string count_of(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

std::string file_stem(const std::string& shot_id) {
  std::string stem;
  for (const char c : shot_id) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    stem += plain ? c : '_';
  }
  return stem.empty() ? "shot" : stem;
}

std::string beyond_text(int beyond) {
  if (beyond <= 0) return "";
  return " Arrows at the frame: " + count_of(static_cast<std::size_t>(beyond), "value") +
         " beyond the axis (numbers in the data table).";
}

Status write_figure(const std::filesystem::path& folder, const Figure& figure) {
  FURROW_DO(base::write_file(folder / (figure.name + ".png"), figure.png));
  FURROW_DO(base::write_file(folder / (figure.name + ".svg"), figure.svg));
  if (!figure.data.rows.empty()) {
    FURROW_DO(base::write_file(folder / (figure.name + ".csv"), base::to_csv(figure.data)));
  }
  return Done{};
}

}  // namespace furrow::figures
