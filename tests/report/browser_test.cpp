// The report as a browser shows it, in headless Chromium where that is installed.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "furrow/base/file.h"
#include "furrow/base/text.h"
#include "furrow/report/page.h"
#include "report/sample_page.h"

namespace furrow::report {
namespace {

namespace fs = std::filesystem;

std::string browser() {
  for (const char* name : {"/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"}) {
    if (fs::exists(name)) return name;
  }
  return "";
}

/// What the browser's document holds after loading, and what it complained of.
struct Loaded {
  int exit_code = -1;
  std::string dom, log;
};

class Browser : public testing::Test {
 protected:
  void SetUp() override {
    if (browser().empty())
      GTEST_SKIP() << "no chromium: apt-get install chromium to check the report in a browser";
    folder_ = fs::temp_directory_path() / "furrow_browser_test";
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  Loaded load(const std::string& html, int width_px) const {
    const fs::path page = folder_ / "report.html", dom = folder_ / "dom.html", log = folder_ / "log.txt";
    EXPECT_TRUE(base::write_file(page, html).ok());
    // No sandbox: tests may run as root. The time limit keeps a stuck browser from stopping the tests.
    const std::string command =
        "timeout 120 " + browser() +
        " --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --hide-scrollbars"
        " --user-data-dir='" +
        (folder_ / "profile").string() + "' --enable-logging=stderr --log-level=0" +
        " --window-size=" + std::to_string(width_px) + ",900 --dump-dom 'file://" + page.string() + "' > '" +
        dom.string() + "' 2> '" + log.string() + "'";
    Loaded loaded;
    loaded.exit_code = std::system(command.c_str());
    loaded.dom = base::read_file(dom).value();
    loaded.log = base::read_file(log).value();
    return loaded;
  }

  fs::path folder_;
};

/// The page with a measuring script in it. The page itself forbids scripts, so the copy loses that line.
std::string with_probe(std::string html) {
  const auto policy = html.find("<meta http-equiv=\"Content-Security-Policy\"");
  EXPECT_NE(policy, std::string::npos);
  html.erase(policy, html.find('>', policy) + 1 - policy);
  const std::string probe = R"(<script>window.addEventListener('load', () => {
const lines = [...document.images].map(i => `image ${i.complete} ${i.naturalWidth} ${i.naturalHeight} ${i.clientWidth} ${i.clientHeight}`);
lines.push(`page ${document.documentElement.scrollWidth} ${window.innerWidth}`);
const found = document.createElement('pre'); found.id = 'probe'; found.textContent = lines.join('\n') + '\n'; document.body.append(found);
});</script>)";
  return html.insert(html.find("</body>"), probe);
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST_F(Browser, ShowsEveryFigureWithoutAComplaint) {
  const std::string html = to_html(samples::page());
  const Loaded loaded = load(html, 1200);
  ASSERT_EQ(loaded.exit_code, 0) << loaded.log;
  EXPECT_EQ(count(loaded.dom, "<figure "), 6u);
  EXPECT_EQ(count(loaded.dom, "<img src=\"data:image/svg+xml;base64,"), 6u);
  EXPECT_EQ(count(loaded.dom, "<table"), 3u);
  EXPECT_EQ(count(loaded.dom, "<details>"), 1u);
  EXPECT_EQ(loaded.log.find("CONSOLE"), std::string::npos) << loaded.log;
}

TEST_F(Browser, FiguresHaveASizeAndThePageFitsDesktopAndPhone) {
  const std::string html = with_probe(to_html(samples::page()));
  // 500 px is the narrowest window that headless Chromium opens.
  for (const int width_px : {1200, 500}) {
    SCOPED_TRACE(width_px);
    const Loaded loaded = load(html, width_px);
    ASSERT_EQ(loaded.exit_code, 0) << loaded.log;
    const auto probe = loaded.dom.find("<pre id=\"probe\">");
    ASSERT_NE(probe, std::string::npos);
    std::istringstream lines(loaded.dom.substr(probe + 16));
    int images = 0, pages = 0;
    for (std::string word; lines >> word;) {
      if (word == "image") {
        std::string complete;
        int natural_width = 0, natural_height = 0, width = 0, height = 0;
        ASSERT_TRUE(lines >> complete >> natural_width >> natural_height >> width >> height);
        ++images;
        EXPECT_EQ(complete, "true");
        EXPECT_GT(natural_width, 100) << "image " << images << " did not decode";
        EXPECT_GT(natural_height, 50);
        EXPECT_GT(width, 300);
        EXPECT_GT(height, 100);
        // Shown in its own proportions.
        EXPECT_NEAR(static_cast<double>(height) / width, static_cast<double>(natural_height) / natural_width,
                    0.02);
      } else if (word == "page") {
        int content = 0, window = 0;
        ASSERT_TRUE(lines >> content >> window);
        ++pages;
        EXPECT_LE(content, window) << "the page must not scroll sideways";
      }
    }
    EXPECT_EQ(images, 6);
    EXPECT_EQ(pages, 1);
  }
}

TEST_F(Browser, HostileTextRunsNothing) {
  Page page = samples::page();
  page.title = "<img src=x onerror=\"document.title='owned'\">";
  page.sections[1].tables[0].cells.rows[0][0] = "</td></table><script>document.title='owned'</script>";
  page.sections[0].figures[0].caption = "\" onload=\"document.title='owned'";
  const Loaded loaded = load(with_probe(to_html(page)), 1200);
  ASSERT_EQ(loaded.exit_code, 0);
  EXPECT_EQ(loaded.dom.find("<title>owned"), std::string::npos);
  EXPECT_EQ(count(loaded.dom, "\nimage "), 5u) << "six figures and no picture of the attacker's";
}

}  // namespace
}  // namespace furrow::report
