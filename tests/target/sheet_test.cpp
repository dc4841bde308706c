#include "furrow/target/sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "furrow/base/file.h"
#include "furrow/target/detect.h"

namespace furrow::target {
namespace {

std::vector<BoardSpec> own_boards() {
  std::vector<BoardSpec> out;
  const auto files =
      base::expand_pattern("*.yaml", std::filesystem::path(FURROW_SOURCE_DIR) / "calib_targets");
  check(files.ok(), "boards in calib_targets");
  for (const auto& file : *files) {
    const auto board = read_board(file);
    EXPECT_TRUE(board.ok()) << board.error().message();
    if (board.ok()) out.push_back(*board);
  }
  return out;
}

Paper paper(const std::string& name) {
  const auto found = find_paper(name);
  check(found.ok(), "a paper");
  return *found;
}

// What is printed is found, every corner where the page has it.
TEST(Sheet, EveryBoardOfOursIsFoundOnItsSheet) {
  for (const BoardSpec& board : own_boards()) {
    constexpr double kDpi = 72.0, kPxPerMetre = kDpi / 0.0254;
    const auto sheet = draw_sheet(board, paper(board.square_m > 0.06 ? "A0" : "A2"), SheetFormat::png, kDpi);
    ASSERT_TRUE(sheet.ok()) << sheet.error().message();
    const auto picture = image::decode_image(sheet->bytes, board.name);
    ASSERT_TRUE(picture.ok()) << picture.error().message();
    EXPECT_EQ(picture->width, std::lround(sheet->width_m * kPxPerMetre));
    const BoardDetection found = detect_board(*picture, board);
    ASSERT_TRUE(found.found) << board.name << ": " << found.reason;
    const auto corners = corners_in_board(board);
    ASSERT_EQ(found.corners_px.size(), corners.size()) << board.name;
    // A checkerboard that looks the same from the other side may be counted from there.
    const Eigen::Vector2d first_px = kPxPerMetre * sheet->first_corner_m - Eigen::Vector2d(0.5, 0.5);
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Eigen::Vector2d wanted = first_px + kPxPerMetre * corners[c].head<2>();
      EXPECT_LT((found.corners_px[c] - wanted).norm(), 0.1) << board.name << " corner " << c;
    }
  }
}

TEST(Sheet, PagesHaveThePapersSize) {
  const BoardSpec board{"b", 9, 6, 0.025, 1.0};
  const auto svg = draw_sheet(board, paper("A4"), SheetFormat::svg);
  ASSERT_TRUE(svg.ok()) << svg.error().message();
  EXPECT_NE(svg->bytes.find("width=\"297mm\" height=\"210mm\" viewBox=\"0 0 297 210\""), std::string::npos);
  const auto pdf = draw_sheet(board, paper("A4"), SheetFormat::pdf);
  ASSERT_TRUE(pdf.ok());
  EXPECT_NE(pdf->bytes.find("/MediaBox [ 0 0 841.889764 595.275591 ]"), std::string::npos);
  // A square of 25 mm in the SVG's own units, which are millimetres.
  EXPECT_NE(svg->bytes.find("M 23.5 "), std::string::npos);
  EXPECT_NE(svg->bytes.find("L 48.5 "), std::string::npos);
  const auto png = draw_sheet(board, paper("a4"), SheetFormat::png, 300);
  ASSERT_TRUE(png.ok());
  // 300 dots per inch are 11811 per metre: 0x2e23, twice, unit metre.
  EXPECT_NE(png->bytes.find(std::string("pHYs\0\0\x2e\x23\0\0\x2e\x23\1", 13)), std::string::npos);
  EXPECT_TRUE(image::decode_image(png->bytes, "b.png").ok());
}

TEST(Sheet, SameBoardSameBytes) {
  const BoardSpec board{"b", 9, 6, 0.025, 1.0};
  for (const SheetFormat format : {SheetFormat::pdf, SheetFormat::svg, SheetFormat::png}) {
    EXPECT_EQ(draw_sheet(board, paper("A4"), format)->bytes, draw_sheet(board, paper("A4"), format)->bytes);
  }
}

TEST(Sheet, RefusesWhatDoesNotFitAndSaysWhatWould) {
  const BoardSpec board{"big", 9, 6, 0.038, 1.0};
  const auto a4 = draw_sheet(board, paper("A4"), SheetFormat::pdf);
  ASSERT_FALSE(a4.ok());
  EXPECT_EQ(a4.error().code, "sheet_too_small");
  EXPECT_NE(a4.error().hint.find("it fits on A2"), std::string::npos) << a4.error().message();
  EXPECT_NE(a4.error().hint.find("may have 25 mm"), std::string::npos) << a4.error().message();
  EXPECT_TRUE(draw_sheet(board, paper("A2"), SheetFormat::pdf).ok());
  EXPECT_FALSE(draw_sheet(board, paper("A3"), SheetFormat::pdf).ok());  // 299 of 297 mm
  BoardSpec smaller = board;
  smaller.square_m = 0.025;
  EXPECT_TRUE(draw_sheet(smaller, paper("A4"), SheetFormat::pdf).ok());
  EXPECT_FALSE(draw_sheet({"huge", 90, 60, 0.5, 1.0}, paper("A0"), SheetFormat::pdf).ok());
  EXPECT_FALSE(draw_sheet({"fine", 9, 6, 0.025, 1.0}, paper("A4"), SheetFormat::png, 1e6).ok());
  EXPECT_FALSE(draw_sheet({"none", 9, 6, 25.0, 1.0}, paper("A4"), SheetFormat::pdf).ok());
}

TEST(Sheet, KnowsPapersAndFormats) {
  EXPECT_NEAR(paper("600x400mm").height_m, 0.6, 1e-12);
  EXPECT_NEAR(paper("Letter").width_m, 0.2159, 1e-12);
  for (const char* wrong : {"", "A", "B4", "x", "600mm", "1x1mm", "nanx5mm", "1e9x1e9mm"})
    EXPECT_FALSE(find_paper(wrong).ok()) << wrong;
  EXPECT_TRUE(sheet_format("a/b.PDF").ok());
  EXPECT_FALSE(sheet_format("b").ok());
  EXPECT_FALSE(sheet_format("b.jpg").ok());
}

}  // namespace
}  // namespace furrow::target
