#pragma once
#include <string>

namespace furrow::figures {

// DejaVu Sans, from fonts-dejavu-core. VTK's built-in font has no Greek letters.
inline constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
inline constexpr const char* kBoldFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf";

/// Height of a capital letter over the base line, and depth of a descender under it, in ems.
inline constexpr double kCapHeight = 0.729;
inline constexpr double kDescent = 0.236;

/// Width of one line of text, by the font's unhinted advances. 0 when the font is missing; render() then says
/// so.
double text_width_pt(const std::string& text, double size_pt, bool bold = false);

}  // namespace furrow::figures
