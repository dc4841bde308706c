#pragma once
#include <string>

#include "figures/drawing.h"
#include "furrow/base/result.h"

namespace furrow::figures {

/// Height of a capital letter over the base line, and depth of a descender under it, in ems of DejaVu Sans.
inline constexpr double kCapHeight = 0.729;
inline constexpr double kDescent = 0.236;

/// Width of one line of text. 0 when the font is missing; render() then says so.
double text_width_pt(const std::string& text, double size_pt, bool bold = false);

/// A drawing in both its forms.
struct Rendered {
  std::string png;
  std::string svg;
  int width_px = 0, height_px = 0;  ///< of the PNG
};

/// Paints with VTK, with no display: PNG through an off-screen OpenGL context, SVG through VTK's SVG device.
/// `title` and `description` go into the SVG for screen readers. Safe to call from any thread; drawings are
/// painted one at a time. Errors: no_renderer (no usable EGL/OpenGL), no_font (DejaVu Sans is not there),
/// figure_too_large.
Result<Rendered> render(const Drawing& drawing, double dpi, const std::string& title,
                        const std::string& description);

}  // namespace furrow::figures
