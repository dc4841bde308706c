// A module includes only lower modules, and third-party headers stay out of include/.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// The table of docs/conventions.md.
const std::map<std::string, int> kLevel = {{"base", 0},     {"image", 1},  {"stats", 1},   {"geom", 1},
                                           {"geo", 2},      {"camera", 2}, {"target", 3},  {"telemetry", 3},
                                           {"rows", 3},     {"depth", 3},  {"calib", 4},   {"sync", 4},
                                           {"altitude", 4}, {"follow", 4}, {"sim", 5},     {"audit", 6},
                                           {"figures", 7},  {"report", 8}, {"project", 9}, {"cli", 10}};
// Modules of one level that may still include each other, one way only: {from, to}.
const std::set<std::pair<std::string, std::string>> kAllowedWithinLevel = {};

struct Include {
  fs::path file;
  std::string module;
  std::string header;
  bool is_ours = false;
};

std::vector<Include> includes_below(const fs::path& root) {
  static const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::vector<Include> found;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const auto extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp") continue;
    const std::string module = fs::relative(entry.path(), root).begin()->string();
    std::ifstream stream(entry.path());
    std::smatch match;
    for (std::string line; std::getline(stream, line);) {
      if (std::regex_search(line, match, pattern))
        found.push_back({entry.path(), module, match[2], match[2].str().starts_with("furrow/")});
    }
  }
  return found;
}

std::string module_of(const std::string& header) {
  const auto start = header.find('/') + 1;
  return header.substr(start, header.find('/', start) - start);
}

void expect_downward(const Include& include) {
  const std::string target =
      include.is_ours ? module_of(include.header) : include.header.substr(0, include.header.find('/'));
  if (!include.is_ours && (!kLevel.contains(target) || include.header.find('/') == std::string::npos)) return;
  ASSERT_TRUE(kLevel.contains(include.module)) << include.file << " is in a module without a level";
  ASSERT_TRUE(kLevel.contains(target))
      << include.file << " includes the unknown module of " << include.header;
  if (target == include.module || kAllowedWithinLevel.contains({include.module, target})) return;
  EXPECT_LT(kLevel.at(target), kLevel.at(include.module)) << include.file << " includes " << include.header;
}

TEST(Layers, ModulesIncludeOnlyLowerModules) {
  for (const auto* folder : {"include/furrow", "src"}) {
    const auto includes = includes_below(fs::path(FURROW_SOURCE_DIR) / folder);
    ASSERT_GT(includes.size(), 20U) << "the test looked in the wrong place";
    for (const auto& include : includes) expect_downward(include);
  }
}

TEST(Layers, PublicHeadersKnowOnlyStdAndEigen) {
  for (const auto& include : includes_below(fs::path(FURROW_SOURCE_DIR) / "include/furrow")) {
    const bool std_or_eigen =
        include.header.starts_with("Eigen/") ||
        (include.header.find('/') == std::string::npos && include.header.find('.') == std::string::npos);
    EXPECT_TRUE(include.is_ours || std_or_eigen) << include.file << " includes " << include.header;
  }
}

}  // namespace
