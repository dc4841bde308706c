#include "furrow/geo/terrain.h"

#include <gtest/gtest.h>

#include <cmath>

#include "furrow/base/file.h"

namespace furrow::geo {
namespace {

class Terrain : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    EXPECT_TRUE(base::write_file(folder_ / name, text).ok());
    return folder_ / name;
  }
  std::filesystem::path folder_ = std::filesystem::path(testing::TempDir()) / "furrow_terrain";
};

constexpr const char* kWgs84 =
    "GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
    "84\",6378137,298.257223563]],PRIMEM[\"Greenwich\",0],UNIT[\"degree\","
    "0.0174532925199433]]";

// ASCII grid: lower-left CORNER of the lower-left cell; rows from the top. Heights are a plane, so bilinear
// is exact.
TEST_F(Terrain, APlaneIsReadAtItsPlaces) {
  std::string text = "ncols 4\nnrows 3\nxllcorner 11.0\nyllcorner 48.0\ncellsize 0.01\nNODATA_value -9999\n";
  const auto plane_m = [](double latitude_deg, double longitude_deg) {
    return 500.0 + 1000.0 * (latitude_deg - 48.0) + 2000.0 * (longitude_deg - 11.0);
  };
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      text += std::to_string(plane_m(48.025 - 0.01 * row, 11.005 + 0.01 * column)) + " ";
    text += "\n";
  }
  const auto file = write("plane.asc", text);
  write("plane.prj", kWgs84);
  testing::internal::CaptureStderr();
  const auto grid = read_terrain(file);
  ASSERT_TRUE(grid.ok()) << grid.error().message();
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(grid->vertical_reference, "not stated");
  for (const auto& [latitude_deg, longitude_deg] :
       {std::pair{48.012, 11.013}, {48.005, 11.005}, {48.0249, 11.0349}}) {
    const auto height_m = terrain_height_m(*grid, latitude_deg, longitude_deg);
    ASSERT_TRUE(height_m.has_value());
    EXPECT_NEAR(*height_m, plane_m(latitude_deg, longitude_deg), 1e-3);
  }
  EXPECT_FALSE(terrain_height_m(*grid, 48.0, 11.02).has_value()) << "outside the cell middles";
  EXPECT_FALSE(terrain_height_m(*grid, 48.01, 12.0).has_value());
  EXPECT_FALSE(terrain_height_m(*grid, std::nan(""), 11.0).has_value());
}

TEST_F(Terrain, VoidsGiveNoHeight) {
  const auto file = write("void.asc",
                          "ncols 3\nnrows 2\nxllcorner 11.0\nyllcorner 48.0\ncellsize 0.01\nNODATA_value "
                          "-9999\n1 2 -9999\n3 4 5\n");
  write("void.prj", kWgs84);
  const auto grid = read_terrain(file);
  ASSERT_TRUE(grid.ok()) << grid.error().message();
  EXPECT_NEAR(terrain_height_m(*grid, 48.010, 11.010).value_or(-1), 2.5, 1e-6);
  EXPECT_FALSE(terrain_height_m(*grid, 48.010, 11.020).has_value());
}

TEST_F(Terrain, WhatIsNoTerrainIsAnError) {
  EXPECT_EQ(read_terrain(folder_ / "none.tif").error().code, "file_missing");
  EXPECT_EQ(read_terrain(write("text.tif", "no grid")).error().code, "terrain_unreadable");
  EXPECT_EQ(
      read_terrain(write("bare.asc", "ncols 2\nnrows 2\nxllcorner 1\nyllcorner 4\ncellsize 1\n1 2\n3 4\n"))
          .error()
          .code,
      "terrain_no_frame");
}

// A grid in UTM: heights count the metres east of easting 444000, so the height found tells where the place
// was looked for. GeoConvert(1) of GeographicLib, EXAMPLES: 38n 444140.54 3684706.36 is 33.3 44.4.
TEST_F(Terrain, ProjectedFramesAreFollowed) {
  std::string text = "ncols 5\nnrows 3\nxllcorner 443950\nyllcorner 3684550\ncellsize 100\n";
  for (int row = 0; row < 3; ++row) text += "0 100 200 300 400\n";
  const auto file = write("utm.asc", text);
  write("utm.prj",
        "PROJCS[\"WGS 84 / UTM zone 38N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS "
        "84\",6378137,298.257223563]],"
        "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
        "PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",45],PARAMETER[\"scale_factor\",0."
        "9996],"
        "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]");
  const auto grid = read_terrain(file);
  ASSERT_TRUE(grid.ok()) << grid.error().message();
  const auto height_m = terrain_height_m(*grid, 33.3, 44.4);
  ASSERT_TRUE(height_m.has_value());
  EXPECT_NEAR(*height_m, 140.54, 0.02);
}

}  // namespace
}  // namespace furrow::geo
