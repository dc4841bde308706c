#include "furrow/target/sheet.h"

#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "furrow/base/text.h"
#include "furrow/image/image.h"
#include "furrow/target/artwork.h"

namespace furrow::target {
namespace {

constexpr double kMm = 1e-3;
/// No printer reaches the paper's edge; most stay 5 mm away.
constexpr double kMargin_m = 8 * kMm;
/// The line of text and the bar below the board, and the white between them.
constexpr double kStrip_m = 12 * kMm, kGap_m = 5 * kMm;
/// The bar to measure; half of it where the page is narrow.
constexpr double kBar_m = 100 * kMm, kNarrow_m = 180 * kMm;
constexpr double kLine_m = 0.3 * kMm, kText_m = 3.2 * kMm, kSmallText_m = 2.5 * kMm;
constexpr double kPointsPerMetre = 72.0 / 0.0254, kInch_m = 0.0254;
constexpr double kLeastDpi = 50.0, kMostDpi = 1200.0, kMostPixels = 2e8;

const std::array<Paper, 10> kPapers{{{"A6", 0.105, 0.148},
                                     {"A5", 0.148, 0.210},
                                     {"A4", 0.210, 0.297},
                                     {"A3", 0.297, 0.420},
                                     {"A2", 0.420, 0.594},
                                     {"A1", 0.594, 0.841},
                                     {"A0", 0.841, 1.189},
                                     {"letter", 0.2159, 0.2794},
                                     {"legal", 0.2159, 0.3556},
                                     {"tabloid", 0.2794, 0.4318}}};

std::string in_mm(double metres) {
  return base::format_double(std::round(metres / kMm * 1e3) / 1e3);
}

/// What the page must hold at least: board, margins and the strip below.
Eigen::Vector2d needed_m(const BoardSpec& board) {
  const PrintedExtent printed = printed_extent(board);
  return printed.high_m - printed.low_m + Eigen::Vector2d(2 * kMargin_m, 2 * kMargin_m + kGap_m + kStrip_m);
}

/// The page's width and height, turned so that the board fits; nothing when it fits neither way.
std::optional<Eigen::Vector2d> page_for(const BoardSpec& board, const Paper& paper) {
  const Eigen::Vector2d need = needed_m(board);
  for (const Eigen::Vector2d& page :
       {Eigen::Vector2d(paper.height_m, paper.width_m), Eigen::Vector2d(paper.width_m, paper.height_m)}) {
    if (need.x() <= page.x() && need.y() <= page.y()) return page;
  }
  return std::nullopt;
}

BoardSpec scaled(BoardSpec board, double factor) {
  board.square_m *= factor;
  board.marker_m *= factor;
  board.gap_m *= factor;
  return board;
}

/// The largest whole millimetre of a square (or tag) with which the board fits; 0 when none does.
int largest_square_mm(const BoardSpec& board, const Paper& paper) {
  int mm = static_cast<int>(board.square_m / kMm);
  while (mm > 0 && !page_for(scaled(board, mm * kMm / board.square_m), paper)) --mm;
  return mm;
}

Error too_small(const BoardSpec& board, const Paper& paper) {
  const Eigen::Vector2d need = needed_m(board);
  std::string hint;
  const auto larger = std::find_if(kPapers.begin(), kPapers.end(),
                                   [&](const Paper& other) { return page_for(board, other); });
  if (larger != kPapers.end()) hint = "it fits on " + larger->name;
  if (const int mm = largest_square_mm(board, paper); mm > 0) {
    hint += std::string(hint.empty() ? "" : "; ") + "on " + paper.name + " a " +
            (board.kind == BoardKind::aprilgrid ? "tag" : "square") + " may have " + std::to_string(mm) +
            " mm";
  }
  return {"sheet_too_small", board.name,
          "the board needs " + in_mm(need.x()) + " x " + in_mm(need.y()) + " mm with its margins",
          "at most " + in_mm(paper.width_m) + " x " + in_mm(paper.height_m) + " mm (" + paper.name + ")",
          hint};
}

/// A cairo drawing, in metres from the page's top-left, and where it goes.
struct Drawing {
  std::shared_ptr<cairo_surface_t> surface;
  std::shared_ptr<cairo_t> cairo;
};

Drawing drawing_on(cairo_surface_t* surface, double units_per_metre) {
  Drawing out{{surface, cairo_surface_destroy}, {cairo_create(surface), cairo_destroy}};
  cairo_scale(out.cairo.get(), units_per_metre, units_per_metre);
  return out;
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

void add_rectangle(cairo_t* cairo, double x, double y, double width, double height) {
  cairo_rectangle(cairo, x, y, width, height);
}

/// One path for all that is black: between two rectangles of one path no seam shows.
void draw_board(cairo_t* cairo, const BoardSpec& board, const Eigen::Vector2d& first_corner_m) {
  for (const Rectangle& r : black_rectangles(board)) {
    const Eigen::Vector2d low = first_corner_m + r.low_m, size = r.high_m - r.low_m;
    add_rectangle(cairo, low.x(), low.y(), size.x(), size.y());
  }
  cairo_fill(cairo);
}

/// Text on a baseline, made smaller where it would be wider than `room_m`.
void draw_text(cairo_t* cairo, const std::string& text, double x, double y, double height_m, double room_m) {
  cairo_set_font_size(cairo, height_m);
  cairo_text_extents_t extents{};
  cairo_text_extents(cairo, text.c_str(), &extents);
  if (extents.x_advance > room_m) cairo_set_font_size(cairo, height_m * room_m / extents.x_advance);
  cairo_move_to(cairo, x, y);
  cairo_show_text(cairo, text.c_str());
}

/// A bar between two ticks, its left end at x, its line at y.
void draw_bar(cairo_t* cairo, double x, double y, double length_m) {
  constexpr double kTick_m = 4 * kMm;
  add_rectangle(cairo, x, y - 0.5 * kLine_m, length_m, kLine_m);
  for (int tenth = 0; tenth <= 10; ++tenth) {
    const double tick_m = tenth % 10 == 0 ? kTick_m : 0.4 * kTick_m;
    const double at = x + 0.1 * tenth * length_m;
    // The outer edges of the end ticks are the length.
    const double left = tenth == 0 ? at : (tenth == 10 ? at - kLine_m : at - 0.5 * kLine_m);
    add_rectangle(cairo, left, y - 0.5 * tick_m, kLine_m, tick_m);
  }
  cairo_fill(cairo);
  draw_text(cairo, in_mm(length_m) + " mm between the outer edges of the end ticks", x, y + 4.5 * kMm,
            kSmallText_m, length_m);
}

void draw_strip(cairo_t* cairo, const BoardSpec& board, const Eigen::Vector2d& page) {
  const double bar_m = page.x() < kNarrow_m ? 0.5 * kBar_m : kBar_m;
  const double top = page.y() - kMargin_m - kStrip_m, left = kMargin_m, right = page.x() - kMargin_m - bar_m;
  const double room_m = right - left - kGap_m;
  draw_text(cairo, board.name, left, top + 3.5 * kMm, kText_m, room_m);
  draw_text(cairo, describe(board), left, top + 7.5 * kMm, kSmallText_m, room_m);
  draw_text(cairo, "Print at 100 %, not fitted to the page; then measure the bar.", left, top + 11.2 * kMm,
            kSmallText_m, room_m);
  draw_bar(cairo, right, top + 4 * kMm, bar_m);
}

Sheet page_of(const BoardSpec& board, const Eigen::Vector2d& page) {
  const PrintedExtent printed = printed_extent(board);
  const Eigen::Vector2d size = printed.high_m - printed.low_m;
  // In the middle of what the strip leaves.
  const Eigen::Vector2d low(0.5 * (page.x() - size.x()), kMargin_m + 0.5 * (page.y() - needed_m(board).y()));
  return {page.x(), page.y(), low - printed.low_m, {}};
}

/// Everything, in black.
void draw(cairo_t* cairo, const BoardSpec& board, const Sheet& sheet) {
  cairo_select_font_face(cairo, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  // Hints fit letters to pixels; a page in metres has none.
  const std::shared_ptr<cairo_font_options_t> options(cairo_font_options_create(),
                                                      cairo_font_options_destroy);
  cairo_font_options_set_hint_style(options.get(), CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options.get(), CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(cairo, options.get());
  draw_board(cairo, board, sheet.first_corner_m);
  draw_strip(cairo, board, {sheet.width_m, sheet.height_m});
}

/// White paper: viewers show a page without it as they like.
void draw_paper(cairo_t* cairo, const Sheet& sheet) {
  cairo_set_source_rgb(cairo, 1, 1, 1);
  add_rectangle(cairo, 0, 0, sheet.width_m, sheet.height_m);
  cairo_fill(cairo);
  cairo_set_source_rgb(cairo, 0, 0, 0);
}

std::string pdf_bytes(const BoardSpec& board, const Sheet& sheet) {
  std::string bytes;
  const Drawing drawing =
      drawing_on(cairo_pdf_surface_create_for_stream(append, &bytes, sheet.width_m * kPointsPerMetre,
                                                     sheet.height_m * kPointsPerMetre),
                 kPointsPerMetre);
  cairo_pdf_surface_set_metadata(drawing.surface.get(), CAIRO_PDF_METADATA_TITLE, board.name.c_str());
  // A date would make every run another file; the format wants one.
  cairo_pdf_surface_set_metadata(drawing.surface.get(), CAIRO_PDF_METADATA_CREATE_DATE,
                                 "2000-01-01T00:00:00Z");
  draw(drawing.cairo.get(), board, sheet);
  cairo_surface_finish(drawing.surface.get());
  return bytes;
}

/// Cairo numbers all surfaces of a process; the same page must be the same file.
std::string without_surface_number(std::string svg) {
  const std::string mark = "id=\"surface";
  const std::size_t at = svg.find(mark);
  if (at == std::string::npos) return svg;
  const std::size_t digits = at + mark.size(), end = svg.find('"', digits);
  return svg.erase(digits, end - digits);
}

std::string svg_bytes(const BoardSpec& board, const Sheet& sheet) {
  std::string bytes;
  const Drawing drawing = drawing_on(
      cairo_svg_surface_create_for_stream(append, &bytes, sheet.width_m / kMm, sheet.height_m / kMm),
      1.0 / kMm);
  cairo_svg_surface_set_document_unit(drawing.surface.get(), CAIRO_SVG_UNIT_MM);
  draw_paper(drawing.cairo.get(), sheet);
  draw(drawing.cairo.get(), board, sheet);
  cairo_surface_finish(drawing.surface.get());
  return without_surface_number(bytes);
}

std::string big_endian(std::uint32_t value) {
  std::string out;
  for (const int shift : {24, 16, 8, 0}) out += static_cast<char>(value >> shift & 0xff);
  return out;
}

/// The PNG with its resolution stated (chunk pHYs, PNG specification 11.3.5.3), so that programs print it
/// true to scale.
std::string with_resolution(const std::string& png, double dpi) {
  const auto per_metre = static_cast<std::uint32_t>(std::lround(dpi / kInch_m));
  const std::string chunk = "pHYs" + big_endian(per_metre) + big_endian(per_metre) + '\1';
  const auto sum = crc32(0, reinterpret_cast<const Bytef*>(chunk.data()), static_cast<uInt>(chunk.size()));
  // After the signature (8 bytes) and the header chunk (25).
  constexpr std::size_t kAfterHeader = 33;
  check(png.size() > kAfterHeader, "with_resolution: no PNG");
  return png.substr(0, kAfterHeader) + big_endian(static_cast<std::uint32_t>(chunk.size() - 4)) + chunk +
         big_endian(static_cast<std::uint32_t>(sum)) + png.substr(kAfterHeader);
}

/// Ink as coverage, one byte a pixel; 255 is black.
std::string png_bytes(const BoardSpec& board, const Sheet& sheet, double dpi) {
  const double px_per_metre = dpi / kInch_m;
  Image picture = image::make_image(static_cast<int>(std::lround(sheet.width_m * px_per_metre)),
                                    static_cast<int>(std::lround(sheet.height_m * px_per_metre)), 1);
  const Drawing drawing =
      drawing_on(cairo_image_surface_create(CAIRO_FORMAT_A8, picture.width, picture.height), px_per_metre);
  draw(drawing.cairo.get(), board, sheet);
  cairo_surface_flush(drawing.surface.get());
  const unsigned char* ink = cairo_image_surface_get_data(drawing.surface.get());
  check(ink != nullptr, "png_bytes: cairo gave no picture");
  const int stride = cairo_image_surface_get_stride(drawing.surface.get());
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u)
      *picture.at(u, v) = static_cast<std::uint8_t>(255 - ink[static_cast<std::ptrdiff_t>(v) * stride + u]);
  }
  return with_resolution(image::encode_image(picture, ".png"), dpi);
}

Status check_dpi(const Sheet& sheet, double dpi) {
  const double pixels = sheet.width_m * sheet.height_m * dpi * dpi / (kInch_m * kInch_m);
  if (dpi >= kLeastDpi && dpi <= kMostDpi && pixels <= kMostPixels) return Done{};
  return Error{"bad_dpi", "--dpi", base::format_double(dpi) + " dots per inch",
               "50 to 1200, and at most 200 megapixels", "PDF and SVG have no pixels"};
}

/// "600x400mm".
std::optional<Paper> paper_in_mm(const std::string& name) {
  if (!name.ends_with("mm")) return std::nullopt;
  const auto sides = base::split(std::string_view(name).substr(0, name.size() - 2), 'x');
  if (sides.size() != 2) return std::nullopt;
  const auto a = base::parse_double(sides[0]), b = base::parse_double(sides[1]);
  constexpr double kLeast_mm = 50.0, kMost_mm = 5000.0;
  if (!a || !b || !(std::min(*a, *b) >= kLeast_mm) || !(std::max(*a, *b) <= kMost_mm)) return std::nullopt;
  return Paper{name, std::min(*a, *b) * kMm, std::max(*a, *b) * kMm};
}

}  // namespace

Result<Paper> find_paper(const std::string& name) {
  const std::string wanted = base::to_lower(name);
  for (const Paper& paper : kPapers) {
    if (base::to_lower(paper.name) == wanted) return paper;
  }
  if (const auto paper = paper_in_mm(wanted)) return *paper;
  return Error{"paper_unknown", "--paper", "'" + name + "'",
               "A0 to A6, letter, legal, tabloid, or a size like 600x400mm", ""};
}

Result<SheetFormat> sheet_format(const std::filesystem::path& file) {
  const std::string extension = base::to_lower(file.extension().string());
  if (extension == ".pdf") return SheetFormat::pdf;
  if (extension == ".svg") return SheetFormat::svg;
  if (extension == ".png") return SheetFormat::png;
  return Error{"sheet_format", file.string(), "the extension '" + extension + "'", ".pdf, .svg or .png", ""};
}

std::string describe(const BoardSpec& board) {
  const auto counts = [](int x, int y) { return std::to_string(x) + " x " + std::to_string(y); };
  const std::string side = in_mm(board.square_m) + " mm";
  if (board.kind == BoardKind::charuco) {
    return "ChArUco, " + counts(board.corners_x + 1, board.corners_y + 1) + " squares of " + side +
           ", markers of " + in_mm(board.marker_m) + " mm, " + board.dictionary;
  }
  if (board.kind == BoardKind::aprilgrid) {
    return "AprilGrid, " + counts(board.corners_x / 2, board.corners_y / 2) + " tags of " + side +
           ", gaps of " + in_mm(board.gap_m) + " mm, " + board.dictionary;
  }
  return "checkerboard, " + counts(board.corners_x, board.corners_y) + " inner corners, squares of " + side;
}

Result<Sheet> draw_sheet(const BoardSpec& board, const Paper& paper, SheetFormat format, double dpi) {
  FURROW_DO(validate(board));
  const auto page = page_for(board, paper);
  if (!page) return too_small(board, paper);
  Sheet sheet = page_of(board, *page);
  switch (format) {
    case SheetFormat::pdf:
      sheet.bytes = pdf_bytes(board, sheet);
      break;
    case SheetFormat::svg:
      sheet.bytes = svg_bytes(board, sheet);
      break;
    case SheetFormat::png:
      FURROW_DO(check_dpi(sheet, dpi));
      sheet.bytes = png_bytes(board, sheet, dpi);
      break;
  }
  return sheet;
}

}  // namespace furrow::target
