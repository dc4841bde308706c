#include "figures/canvas.h"

#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkContextActor.h>
#include <vtkContextItem.h>
#include <vtkContextScene.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkRect.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSVGContextDevice2D.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkXMLDataElement.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <sstream>
#include <string_view>

#include "figures/font.h"
#include "figures/gl_window.h"
#include "figures/utf8.h"
#include "furrow/base/file.h"
#include "furrow/base/text.h"

namespace furrow::figures {
namespace {

constexpr double kPointsPerInch = 72.0;
constexpr double kMmPerInch = 25.4;
/// Units of the SVG's view box per point: whole-numbered font sizes stay fine enough, and coordinates short.
constexpr double kSvgUnitsPerPt = 20.0;
/// The PNG is painted up to this many times larger and averaged: smooth edges for lines, fills and text
/// alike. On a software renderer that is faster than multisampling for the same smoothness.
constexpr int kMostSupersampling = 3;
/// Side of a texture that any OpenGL 3.2 renderer in use today offers (Mesa's software renderer: 16384).
constexpr int kLargestSidePx = 8192;
constexpr int kJpegQuality = 88;

/// VTK's font cache and the one OpenGL context: one caller at a time.
std::mutex& vtk_mutex() {
  static std::mutex mutex;
  return mutex;
}

void set_font(vtkTextProperty& property, int size_px, bool bold) {
  property.SetFontFamily(VTK_FONT_FILE);
  property.SetFontFile(bold ? kBoldFont : kFont);
  property.SetFontSize(size_px);
  property.SetJustificationToLeft();
  property.SetVerticalJustificationToBottom();
}

/// Paints a Drawing through VTK's 2-D context, on whichever device stands behind it.
class DrawingItem : public vtkContextItem {
 public:
  static DrawingItem* New();
  vtkTypeMacro(DrawingItem, vtkContextItem)

      const Drawing* drawing = nullptr;
  double scale = 1.0;      ///< device units per point
  double height = 0.0;     ///< of the device, whose y runs upwards
  bool is_vector = false;  ///< the device fills any polygon and takes pictures from elsewhere
  /// What of the drawing's pictures is to be painted, as textures, and where on the paper.
  struct Photograph {
    vtkSmartPointer<vtkImageData> rows;
    Point top_left = Point::Zero();  ///< device units, y downwards from the paper's top
    Point size = Point::Zero();
  };
  std::vector<Photograph> pictures;

  bool Paint(vtkContext2D* painter) override {
    if (!is_vector) paint_pictures(*painter);
    for (const auto& item : drawing->items) {
      std::visit([&](const auto& shape) { paint(*painter, shape); }, item);
    }
    return true;
  }

 private:
  std::vector<float> device_points(const std::vector<Point>& points) const {
    std::vector<float> xy;
    xy.reserve(2 * points.size());
    for (const Point& point : points) {
      xy.push_back(static_cast<float>(point.x() * scale));
      xy.push_back(static_cast<float>(height - point.y() * scale));
    }
    return xy;
  }

  static void fill_with(vtkContext2D& painter, Colour colour) {
    painter.GetPen()->SetLineType(vtkPen::NO_PEN);
    painter.GetBrush()->SetColor(colour.r, colour.g, colour.b, colour.a);
  }

  void paint(vtkContext2D& painter, const Stroke& stroke) const {
    painter.GetPen()->SetLineType(vtkPen::SOLID_LINE);
    painter.GetPen()->SetColor(stroke.colour.r, stroke.colour.g, stroke.colour.b, stroke.colour.a);
    painter.GetPen()->SetWidth(static_cast<float>(stroke.width_pt * scale));
    for (const auto& line : dashes(stroke)) {
      if (line.size() < 2) continue;
      auto xy = device_points(line);
      painter.DrawPoly(xy.data(), static_cast<int>(line.size()));
    }
  }

  void paint(vtkContext2D& painter, const Fill& fill) const {
    if (fill.corners.size() < 3) return;
    fill_with(painter, fill.colour);
    auto xy = device_points(fill.corners);
    painter.DrawPolygon(xy.data(), static_cast<int>(fill.corners.size()));
  }

  void paint(vtkContext2D& painter, const Band& band) const {
    if (band.upper.size() < 2 || band.upper.size() != band.lower.size()) return;
    fill_with(painter, band.colour);
    std::vector<Point> points;
    if (is_vector) {
      points = band.upper;
      points.insert(points.end(), band.lower.rbegin(), band.lower.rend());
    } else {
      for (std::size_t i = 0; i < band.upper.size(); ++i) {
        points.push_back(band.upper[i]);
        points.push_back(band.lower[i]);
      }
    }
    auto xy = device_points(points);
    if (is_vector) {
      painter.DrawPolygon(xy.data(), static_cast<int>(points.size()));
    } else {
      painter.DrawQuadStrip(xy.data(), static_cast<int>(points.size()));
    }
  }

  void paint(vtkContext2D& painter, const Text& text) const {
    if (text.text.empty()) return;
    auto& property = *painter.GetTextProp();
    set_font(property, std::max(1, static_cast<int>(std::lround(text.size_pt * scale))), text.bold);
    property.SetColor(text.colour.r / 255.0, text.colour.g / 255.0, text.colour.b / 255.0);
    property.SetOpacity(text.colour.a / 255.0);
    property.SetOrientation(text.upward ? 90.0 : 0.0);
    const double share = text.align == Align::start ? 0.0 : text.align == Align::middle ? 0.5 : 1.0;
    const double along_pt = -share * text_width_pt(text.text, text.size_pt, text.bold);
    const double down_pt = kDescent * text.size_pt;
    const Point corner = text.anchor + (text.upward ? Point(down_pt, -along_pt) : Point(along_pt, down_pt));
    painter.DrawString(static_cast<float>(corner.x() * scale),
                       static_cast<float>(height - corner.y() * scale), printable(text.text).c_str());
  }

  void paint_pictures(vtkContext2D& painter) const {
    for (const Photograph& one : pictures) {
      const double bottom = height - (one.top_left.y() + one.size.y());
      painter.DrawImage(vtkRectf(static_cast<float>(one.top_left.x()), static_cast<float>(bottom),
                                 static_cast<float>(one.size.x()), static_cast<float>(one.size.y())),
                        one.rows);
    }
  }
};
vtkStandardNewMacro(DrawingItem);

/// Rows [first, end) of a picture.
vtkSmartPointer<vtkImageData> texture(const Image& rgb, int first, int end) {
  auto data = vtkSmartPointer<vtkImageData>::New();
  data->SetDimensions(rgb.width, end - first, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* to = static_cast<std::uint8_t*>(data->GetScalarPointer());
  const auto row_bytes = static_cast<std::ptrdiff_t>(rgb.width) * 3;
  for (int v = end - 1; v >= first; --v, to += row_bytes) std::copy_n(rgb.at(0, v), row_bytes, to);
  return data;
}

/// The rows of the pictures that a strip of the paper shows: the renderer takes a texture anew for each strip.
std::vector<DrawingItem::Photograph> rows_in_strip(const Drawing& drawing, const std::vector<Image>& pictures,
                                                   double scale, double strip_top, double strip_bottom) {
  std::vector<DrawingItem::Photograph> out;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Image& rgb = pictures[i];
    const Picture& place = drawing.pictures[i];
    const double top = place.top_left.y() * scale, row = place.height_pt * scale / rgb.height;
    constexpr int kBeyond = 2;  // rows that smoothing between rows looks at
    const int first = std::max(0, static_cast<int>(std::floor((strip_top - top) / row)) - kBeyond);
    const int end = std::min(rgb.height, static_cast<int>(std::ceil((strip_bottom - top) / row)) + kBeyond);
    if (first >= end) continue;
    out.push_back({texture(rgb, first, end), {place.top_left.x() * scale, top + first * row},
                   {place.width_pt * scale, (end - first) * row}});
  }
  return out;
}

Image as_rgb(const Image& picture) {
  if (picture.channels == 3) return picture;
  Image rgb = image::make_image(picture.width, picture.height, 3);
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    std::fill_n(rgb.data.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, picture.data[i]);
  }
  return rgb;
}

/// How many times larger a PNG of that size is painted.
int supersampling(int width, int height) {
  return std::clamp(kLargestSidePx / std::max(width, height), 1, kMostSupersampling);
}

/// Writes the mean of each block of `times` x `times` pixels, turned the right way up, to `rows` rows of
/// `small` from `top` on.
void average_down(const std::uint8_t* pixels, int times, int top, int rows, Image& small) {
  const int width = small.width;
  const std::size_t wide_bytes = static_cast<std::size_t>(width) * static_cast<std::size_t>(times) * 3;
  const int count = times * times;
  std::vector<int> sums(wide_bytes);
  for (int v = 0; v < rows; ++v) {
    std::fill(sums.begin(), sums.end(), 0);
    const std::uint8_t* from =
        pixels + wide_bytes * static_cast<std::size_t>(rows - 1 - v) * static_cast<std::size_t>(times);
    for (int row = 0; row < times; ++row, from += wide_bytes) {
      for (std::size_t i = 0; i < wide_bytes; ++i) sums[i] += from[i];
    }
    std::uint8_t* to = small.at(0, top + v);
    const int* block = sums.data();
    for (int u = 0; u < width; ++u, to += 3, block += 3 * static_cast<std::ptrdiff_t>(times)) {
      for (int c = 0; c < 3; ++c) {
        int sum = count / 2;
        for (int column = 0; column < times; ++column) sum += block[3 * column + c];
        to[c] = static_cast<std::uint8_t>(sum / count);
      }
    }
  }
}

/// The process's one context and window. They live to the end: VTK's own statics may be gone when ours would
/// be destroyed.
struct Renderer {
  std::unique_ptr<SurfacelessContext> context;
  vtkSmartPointer<BorrowedContextWindow> window;
};

Result<Renderer*> renderer() {
  static Renderer* made = nullptr;
  if (made == nullptr) {
    FURROW_TRY(auto context, SurfacelessContext::create());
    made = new Renderer{std::move(context), vtkSmartPointer<BorrowedContextWindow>::New()};
    made->window->SetOwnContext(0);
    made->window->SetMultiSamples(0);
    made->window->SetOffScreenRendering(1);
    made->window->SetDPI(static_cast<int>(kPointsPerInch));
  }
  return made;
}

/// Pictures at their size on the PNG.
std::vector<Image> fitted_pictures(const Drawing& drawing, double px_per_pt) {
  std::vector<Image> fitted;
  for (const Picture& picture : drawing.pictures) {
    const int width = std::max(1, static_cast<int>(std::lround(picture.width_pt * px_per_pt)));
    const int height = std::max(1, static_cast<int>(std::lround(picture.height_pt * px_per_pt)));
    fitted.push_back(as_rgb(image::resize(picture.image, width, height)));
  }
  return fitted;
}

/// Paints strip by strip: of the whole picture, supersampled, the renderer would keep several copies at once,
/// some hundred MB for a figure of a page's width. Empty where OpenGL gives no pixels.
Image paint_strips(vtkRenderWindow& window, DrawingItem& item, const std::vector<Image>& pictures, int width,
                   int height, int times) {
  constexpr int kStripPx = 80;
  const int strip_px = std::min(kStripPx, height);
  window.SetSize(width * times, strip_px * times);
  Image painted = image::make_image(width, height, 3);
  vtkNew<vtkUnsignedCharArray> pixels;
  for (int top = 0; top < height; top += strip_px) {
    // The last strip may end above the window's lower edge; y runs upwards from there.
    item.height = static_cast<double>(top + strip_px) * times;
    item.pictures = rows_in_strip(*item.drawing, pictures, item.scale, static_cast<double>(top) * times, item.height);
    window.Render();
    const int rows = std::min(strip_px, height - top), lowest = (strip_px - rows) * times;
    constexpr int kBackBuffer = 0;
    window.GetPixelData(0, lowest, width * times - 1, strip_px * times - 1, kBackBuffer, pixels.Get(), 0);
    if (pixels->GetNumberOfValues() != static_cast<vtkIdType>(width) * rows * times * times * 3) return {};
    average_down(pixels->GetPointer(0), times, top, rows, painted);
  }
  return painted;
}

Result<Image> paint_pixels(const Drawing& drawing, double px_per_pt, int width, int height,
                           const std::vector<Image>& pictures) {
  FURROW_TRY(Renderer * gl, renderer());
  if (!gl->context->make_current()) {
    return Error{"no_renderer", "figures", "the OpenGL context was lost",
                 "a context that can be made current", ""};
  }
  const int times = supersampling(width, height);
  vtkNew<DrawingItem> item;
  item->drawing = &drawing;
  item->scale = px_per_pt * times;

  vtkNew<vtkRenderer> layer;
  layer->SetBackground(1.0, 1.0, 1.0);
  vtkNew<vtkContextScene> scene;
  scene->SetRenderer(layer);
  scene->AddItem(item);
  vtkNew<vtkContextActor> actor;
  actor->SetScene(scene);
  layer->AddActor(actor);
  gl->window->AddRenderer(layer);
  const Image painted = paint_strips(*gl->window, *item, pictures, width, height, times);
  gl->window->RemoveRenderer(layer);
  gl->context->release();
  if (painted.empty()) {
    return Error{"no_renderer", "figures", "OpenGL returned no pixels", "a picture", ""};
  }
  return painted;
}

std::string escape_xml(const std::string& text) {
  std::string out;
  for (const char c : printable(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string svg_picture(const Picture& picture, const Image& fitted) {
  const char* extension = picture.lossless ? ".png" : ".jpg";
  const char* type = picture.lossless ? "image/png" : "image/jpeg";
  const auto units = [](double pt) { return base::format_fixed(pt * kSvgUnitsPerPt, 1); };
  return "<image x=\"" + units(picture.top_left.x()) + "\" y=\"" + units(picture.top_left.y()) +
         "\" width=\"" + units(picture.width_pt) + "\" height=\"" + units(picture.height_pt) +
         "\" preserveAspectRatio=\"none\" xlink:href=\"data:" + type + ";base64," +
         base::base64(image::encode_image(fitted, extension, kJpegQuality)) + "\"/>\n";
}

/// Coordinates with one decimal: a tenth of a unit is 0.002 mm on paper, and VTK writes four times as much.
std::string with_short_coordinates(const std::string& svg) {
  std::string out;
  out.reserve(svg.size());
  std::size_t from = 0;
  while (from < svg.size()) {
    std::size_t start = std::min(svg.find(" d=\"", from), svg.find(" points=\"", from));
    if (start == std::string::npos) break;
    start = svg.find('"', start) + 1;
    const std::size_t end = std::min(svg.find('"', start), svg.size());
    out.append(svg, from, start - from);
    int decimals = -1;  // -1: before the point
    for (std::size_t i = start; i < end; ++i) {
      const char c = svg[i];
      const bool digit = c >= '0' && c <= '9';
      decimals = c == '.' ? 0 : digit && decimals >= 0 ? decimals + 1 : -1;
      if (decimals <= 1) out += c;
    }
    from = end;
  }
  return out.append(svg, from);
}

/// VTK's SVG device asks its window for size and resolution only: no OpenGL takes part.
std::string vector_items(const Drawing& drawing) {
  const double width = drawing.width_pt * kSvgUnitsPerPt, height = drawing.height_pt * kSvgUnitsPerPt;
  vtkNew<BorrowedContextWindow> window;
  window->SetSize(static_cast<int>(std::ceil(width)), static_cast<int>(std::ceil(height)));
  window->SetDPI(static_cast<int>(kPointsPerInch));
  vtkNew<vtkRenderer> layer;
  window->AddRenderer(layer);
  vtkNew<vtkXMLDataElement> page, definitions;
  page->SetName("g");
  page->SetAttribute("stroke-linejoin", "round");
  page->SetAttribute("fill", "none");
  definitions->SetName("defs");
  vtkNew<vtkSVGContextDevice2D> device;
  device->SetSVGContext(page, definitions);
  device->Begin(layer);
  vtkNew<vtkContext2D> painter;
  painter->Begin(device);
  vtkNew<DrawingItem> item;
  item->drawing = &drawing;
  item->scale = kSvgUnitsPerPt;
  item->height = std::ceil(height);
  item->is_vector = true;
  item->Paint(painter);
  painter->End();
  device->End();
  std::ostringstream text;
  page->PrintXML(text, vtkIndent());
  return with_short_coordinates(text.str());
}

std::string paint_svg(const Drawing& drawing, const std::vector<Image>& pictures, const std::string& title,
                      const std::string& description) {
  const auto mm = [](double pt) { return base::format_fixed(pt * kMmPerInch / kPointsPerInch, 2); };
  const std::string width = base::format_fixed(std::ceil(drawing.width_pt * kSvgUnitsPerPt), 0);
  const std::string height = base::format_fixed(std::ceil(drawing.height_pt * kSvgUnitsPerPt), 0);
  std::string svg =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" role=\"img\" "
      "width=\"" +
      mm(drawing.width_pt) + "mm\" height=\"" + mm(drawing.height_pt) + "mm\" viewBox=\"0 0 " + width + " " +
      height + "\">\n<title>" + escape_xml(title) + "</title>\n<desc>" + escape_xml(description) +
      "</desc>\n<rect width=\"" + width + "\" height=\"" + height + "\" fill=\"#ffffff\"/>\n";
  for (std::size_t i = 0; i < pictures.size(); ++i) svg += svg_picture(drawing.pictures[i], pictures[i]);
  return svg + vector_items(drawing) + "</svg>\n";
}

void append_big_endian(std::string& out, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8)
    out += static_cast<char>(static_cast<unsigned char>(value >> shift));
}

/// CRC-32 of a PNG chunk (PNG specification, annex D).
std::uint32_t crc32(std::string_view bytes) {
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0u ? 0xEDB88320u : 0u);
  }
  return ~crc;
}

/// The PNG with its resolution in it, so that it is placed at its size on paper.
std::string with_resolution(const std::string& png, double dpi) {
  constexpr std::size_t kHeaderEnd = 8 + 25;  // signature and the IHDR chunk, which is always first
  constexpr double kInchesPerMetre = 1000.0 / kMmPerInch;
  if (png.size() < kHeaderEnd) return png;
  const auto dots_per_metre = static_cast<std::uint32_t>(std::lround(dpi * kInchesPerMetre));
  std::string body = "pHYs";
  append_big_endian(body, dots_per_metre);
  append_big_endian(body, dots_per_metre);
  body += '\1';  // per metre
  std::string chunk;
  append_big_endian(chunk, static_cast<std::uint32_t>(body.size() - 4));
  chunk += body;
  append_big_endian(chunk, crc32(body));
  return png.substr(0, kHeaderEnd) + chunk + png.substr(kHeaderEnd);
}

Status check_font() {
  for (const char* font : {kFont, kBoldFont}) {
    if (!std::filesystem::exists(font)) {
      return Error{"no_font", font, "no such file", "DejaVu Sans", "install fonts-dejavu-core"};
    }
  }
  return Done{};
}

}  // namespace

Result<Rendered> render(const Drawing& drawing, double dpi, const std::string& title,
                        const std::string& description) {
  FURROW_DO(check_font());
  const double px_per_pt = dpi / kPointsPerInch;
  const double wide = drawing.width_pt * px_per_pt, high = drawing.height_pt * px_per_pt;
  constexpr double kLargest = kLargestSidePx;
  if (!(wide >= 1.0 && high >= 1.0 && wide <= kLargest && high <= kLargest)) {
    return Error{"figure_too_large", title,
                 "a figure of " + base::format_fixed(wide, 0) + " x " + base::format_fixed(high, 0) + " px",
                 "sides from 1 to " + base::format_fixed(kLargest, 0) + " px", "lower the width or the dpi"};
  }
  Rendered made;
  made.width_px = static_cast<int>(std::lround(wide));
  made.height_px = static_cast<int>(std::lround(high));
  const std::vector<Image> pictures = fitted_pictures(drawing, px_per_pt);
  Image pixels;
  {
    const std::scoped_lock lock(vtk_mutex());
    FURROW_TRY(pixels, paint_pixels(drawing, px_per_pt, made.width_px, made.height_px, pictures));
    made.svg = paint_svg(drawing, pictures, title, description);
  }
  made.png = with_resolution(image::encode_image(pixels, ".png"), dpi);
  return made;
}

}  // namespace furrow::figures
