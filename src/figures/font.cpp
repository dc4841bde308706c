#include "figures/font.h"

#include <ft2build.h>
#include FT_FREETYPE_H

#include <map>
#include <mutex>

#include "figures/utf8.h"

namespace furrow::figures {
namespace {

/// Advances of one font file, read on demand. VTK knows them too, but only rounded to 1/32 em.
class Advances {
 public:
  explicit Advances(const char* file) {
    if (FT_Init_FreeType(&library_) != 0) return;
    if (FT_New_Face(library_, file, 0, &face_) != 0) face_ = nullptr;
  }
  Advances(const Advances&) = delete;
  Advances& operator=(const Advances&) = delete;
  ~Advances() {
    if (face_ != nullptr) FT_Done_Face(face_);
    if (library_ != nullptr) FT_Done_FreeType(library_);
  }

  double width_em(const std::string& text) {
    if (face_ == nullptr) return 0.0;
    const std::scoped_lock lock(mutex_);
    FT_Pos units = 0;
    FT_UInt previous = 0;
    for (const char32_t code : characters(text)) {
      const FT_UInt glyph = FT_Get_Char_Index(face_, code);
      FT_Vector kerning{0, 0};
      if (previous != 0) FT_Get_Kerning(face_, previous, glyph, FT_KERNING_UNSCALED, &kerning);
      units += kerning.x + advance(glyph);
      previous = glyph;
    }
    return static_cast<double>(units) / face_->units_per_EM;
  }

 private:
  FT_Pos advance(FT_UInt glyph) {
    const auto known = known_.find(glyph);
    if (known != known_.end()) return known->second;
    const bool loaded = FT_Load_Glyph(face_, glyph, FT_LOAD_NO_SCALE) == 0;
    return known_[glyph] = loaded ? face_->glyph->metrics.horiAdvance : 0;
  }

  FT_Library library_ = nullptr;
  FT_Face face_ = nullptr;
  std::mutex mutex_;
  std::map<FT_UInt, FT_Pos> known_;
};

}  // namespace

double text_width_pt(const std::string& text, double size_pt, bool bold) {
  static Advances regular(kFont), heavy(kBoldFont);
  return size_pt * (bold ? heavy : regular).width_em(text);
}

}  // namespace furrow::figures
