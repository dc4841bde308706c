#include "furrow/report/page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "furrow/base/file.h"
#include "report/sample_page.h"

namespace furrow::report {
namespace {

/// Painted once: most of a page's time goes into its figures.
const Page& sample() {
  static const Page page = samples::page();
  return page;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Page, AnswerFirstThenSectionsThenProvenance) {
  const std::string html = to_html(sample());
  const auto summary = html.find("A height above the canopy for 43"),
             failed = html.find("Log against pictures"), camera = html.find("<h2 id=\"section-1\">Camera"),
             heights = html.find("<h2 id=\"section-2\">Heights"),
             provenance = html.find("<h2 id=\"provenance\"");
  ASSERT_NE(provenance, std::string::npos);
  EXPECT_LT(summary, failed);
  EXPECT_LT(failed, camera);
  EXPECT_LT(camera, heights);
  EXPECT_LT(heights, provenance);
  EXPECT_TRUE(holds(html, "1 failed"));
  EXPECT_TRUE(holds(html, "1 passed"));
  EXPECT_TRUE(holds(html, "1 not assessed"));
  EXPECT_TRUE(holds(html, "<a href=\"#finding-2\">Log against pictures</a>"));
}

TEST(Page, StandsAlone) {
  const std::string html = to_html(sample());
  for (const char* foreign : {"<script", "http://", "https://", "@import", "url(", "onload", "file:"}) {
    EXPECT_FALSE(holds(html, foreign)) << foreign;
  }
  EXPECT_EQ(count(html, "<img src=\"data:image/"), count(html, "<figure"));
  EXPECT_EQ(count(html, "<img "), count(html, "alt=\""));
  EXPECT_EQ(count(html, "<th scope=\"col\""), 4u + sample().sections[1].tables[1].cells.columns.size());
}

/// With FURROW_FIGURES_OUT set, the page is left there to be looked at.
TEST(Page, CanBeKept) {
  const char* folder = std::getenv("FURROW_FIGURES_OUT");
  if (folder == nullptr) GTEST_SKIP() << "set FURROW_FIGURES_OUT to a folder to keep report.html";
  EXPECT_TRUE(base::write_file(std::filesystem::path(folder) / "report.html", to_html(sample())).ok());
}

TEST(Page, SamePageSameBytes) {
  EXPECT_EQ(to_html(sample()), to_html(samples::page()));
}

TEST(Page, HostileTextStaysText) {
  const std::string hostile = "<script>alert('&\"{{title}}{{{style}}}')</script>\xff\x01<!-- </style> -->";
  Page page;
  page.title = page.subtitle = hostile;
  page.summary = {hostile};
  page.provenance = {{hostile, hostile}};
  Section section;
  section.title = hostile;
  section.paragraphs = {hostile};
  section.findings = {{hostile, hostile, audit::Verdict::fail, hostile, hostile, hostile}};
  section.tables = {{hostile, {"", {hostile}, {{hostile}}, {}, {}}, true}};
  figures::Figure figure;
  figure.name = figure.caption = hostile;
  figure.svg = "<svg/>";
  figure.data = section.tables[0].cells;
  section.figures = {figure};
  page.sections = {section};
  const std::string html = to_html(page);
  EXPECT_FALSE(holds(html, "<script"));
  EXPECT_FALSE(holds(html, "<!--"));
  EXPECT_FALSE(holds(html, "\xff"));
  EXPECT_FALSE(holds(html, std::string(1, '\x01')));
  EXPECT_EQ(count(html, "</style>"), 1u);
  EXPECT_TRUE(holds(html, "&lt;script&gt;alert(&apos;&amp;&quot;{{title}}{{{style}}}&apos;)"))
      << "templates are not read twice";
  // The attribute keeps its quotes closed: the next thing after the caption is the width.
  EXPECT_TRUE(holds(html, "--&gt;\" width=\"0\""));
}

TEST(Page, VerdictsDifferByWordAndShape) {
  Page page;
  Section section;
  for (const auto verdict : {audit::Verdict::pass, audit::Verdict::fail, audit::Verdict::not_assessed}) {
    section.findings.push_back({"id", "title", verdict, "", "", ""});
  }
  page.sections = {section};
  const std::string html = to_html(page);
  for (const char* word : {">Pass<", ">Fail<", ">Not assessed<"}) {
    EXPECT_TRUE(holds(html, std::string("</svg>") + (word + 1))) << word;
  }
  EXPECT_TRUE(holds(html, "<circle cx=\"8\" cy=\"8\" r=\"7.5\"")) << "a disc with a tick";
  EXPECT_TRUE(holds(html, "M8 .6L15.8 15H.2z")) << "a triangle";
  EXPECT_TRUE(holds(html, "stroke-dasharray")) << "a broken ring";
}

TEST(Page, NumbersStandRightAlignedAndWordsDoNot) {
  Page page;
  Section section;
  section.tables = {
      {"t",
       {"",
        {"name", "number", "with sigma", "minus", "mixed", "none"},
        {{"a1", "-", "3.02 \u00b1 0.05", "\u22121", "5", ""}, {"b2", "1.5", "-2 %", "-3", "five", ""}},
        {},
        {}},
       false}};
  page.sections = {section};
  const std::string html = to_html(page);
  EXPECT_TRUE(holds(html,
                    "<th scope=\"col\">name</th><th scope=\"col\" class=\"num\">number</th><th scope=\"col\" "
                    "class=\"num\">with sigma</th><th scope=\"col\" class=\"num\">minus</th><th "
                    "scope=\"col\">mixed</th><th scope=\"col\">none</th>"));
  EXPECT_TRUE(holds(html, "<td class=\"short\">a1</td><td class=\"num\">-</td>"))
      << "short words stay on one line";
}

TEST(Page, LongTablesAreCollapsedAndSayHowLong) {
  const std::string html = to_html(sample());
  EXPECT_TRUE(holds(html, "<details>\n<summary>All shots (48 rows)</summary>"));
  EXPECT_EQ(count(html, "<details>"), count(html, "</details>"));
}

TEST(Page, EmptyPageIsStillAPage) {
  const std::string html = to_html({});
  EXPECT_TRUE(html.starts_with("<!DOCTYPE html>"));
  EXPECT_TRUE(holds(html, "</html>"));
  EXPECT_FALSE(holds(html, "id=\"provenance\""));
  EXPECT_FALSE(holds(html, "class=\"tally\""));
}

TEST(Page, FigureCarriesItsNumbers) {
  Page page;
  Section section;
  figures::Figure figure;
  figure.name = "heights";
  figure.caption = "Heights.";
  figure.png = "png";
  figure.data = {"", {"a", "b"}, {{"1", "2"}}, {}, {}};
  section.figures = {figure};
  page.sections = {section};
  const std::string html = to_html(page);
  EXPECT_TRUE(holds(html, "data:image/png;base64," + base::base64("png"))) << "PNG when there is no SVG";
  EXPECT_TRUE(holds(html, "download=\"heights.csv\" href=\"data:text/csv;charset=utf-8;base64," +
                              base::base64("a,b\n1,2\n")));
  EXPECT_TRUE(holds(html, "Numbers (CSV, 1 row)"));
}

}  // namespace
}  // namespace furrow::report
