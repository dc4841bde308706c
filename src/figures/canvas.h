#pragma once
#include <string>

#include "figures/drawing.h"
#include "furrow/base/result.h"

namespace furrow::figures {

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
