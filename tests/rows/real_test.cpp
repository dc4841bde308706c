// Pictures with published truth; their numbers at the time of writing are in docs/formulation/rows.md. The
// limits here are lower, so that an improvement elsewhere is not an error here, but a method that breaks is.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <vector>

#include "furrow/rows/detect.h"
#include "furrow/stats/robust.h"

namespace furrow::rows {
namespace {

namespace fs = std::filesystem;

fs::path data_folder() {
  const char* data = std::getenv("FURROW_DATA");
  return data != nullptr ? fs::path(data) : fs::path(FURROW_SOURCE_DIR) / "../shared/data";
}

std::vector<fs::path> pictures_in(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::exists(folder))
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".jpg") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Median over the picture's rows of the relative error of the spacing, from the field.
double spacing_error(const fs::path& truth_file, const RowLines& lines) {
  std::ifstream in(truth_file);
  std::vector<double> d;
  for (double c = 0.0, spacing = 0.0; in >> c >> spacing;) d.push_back(spacing);
  std::vector<double> errors;
  for (std::size_t i = 0; i < d.size(); ++i)
    errors.push_back(
        std::abs(lines.field->spacing_at(240.0 - static_cast<double>(d.size() - i)) / d[i] - 1.0));
  return stats::median(errors);
}

TEST(RealPictures, CropRowBenchmarkSpacings) {
  const auto files = pictures_in(data_folder() / "rows/crbd-train");
  if (files.empty()) GTEST_SKIP() << "no pictures in " << data_folder() / "rows/crbd-train";
  int right = 0, seen = 0;
  for (std::size_t i = 0; i < files.size(); i += 4) {
    const auto picture = image::read_image(files[i]);
    ASSERT_TRUE(picture.ok());
    const RowLines lines = detect(*picture);
    ++seen;
    if (lines.ok() && spacing_error(fs::path(files[i]).replace_extension(".crp"), lines) < 0.05) ++right;
  }
  EXPECT_GE(right, seen - 2) << "of " << seen;
}

TEST(RealPictures, WheatFromAboveIsFoundAtOneSpacing) {
  const auto files = pictures_in(data_folder() / "flights/mini-se/wheat");
  if (files.empty()) GTEST_SKIP() << "no pictures in " << data_folder() / "flights/mini-se/wheat";
  std::vector<double> spacings;
  for (std::size_t i = 0; i < files.size(); i += 3) {
    const auto picture = image::read_image(files[i]);
    ASSERT_TRUE(picture.ok());
    const RowLines lines = detect(*picture);
    ASSERT_TRUE(lines.ok()) << files[i];
    EXPECT_GT(lines.confidence, 0.9) << files[i];
    spacings.push_back(lines.field->spacing_at(0.5 * picture->height));
  }
  // One flight at one height: the spacings agree, so no picture shows half or double of it.
  for (const double spacing : spacings) EXPECT_NEAR(spacing / stats::median(spacings), 1.0, 0.25);
}

}  // namespace
}  // namespace furrow::rows
