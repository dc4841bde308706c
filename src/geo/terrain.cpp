#include "furrow/geo/terrain.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <limits>
#include <memory>
#include <mutex>

#include "furrow/base/text.h"

namespace furrow::geo {
namespace {

struct CloseDataset {
  void operator()(GDALDataset* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<GDALDataset, CloseDataset>;

/// A gigabyte of heights; a field needs a thousandth of it.
constexpr std::int64_t kMostCells = std::int64_t{1} << 28;

Error unreadable(const std::filesystem::path& file, const std::string& code, std::string found,
                 std::string wanted) {
  return {code, file.string(), std::move(found), std::move(wanted), ""};
}

/// Metres per unit of the band.
double unit_factor(GDALRasterBand& band) {
  const std::string unit = base::to_lower(band.GetUnitType() != nullptr ? band.GetUnitType() : "");
  constexpr double kFoot = 0.3048, kSurveyFoot = 1200.0 / 3937.0;
  if (unit == "ft" || unit == "foot" || unit == "feet") return kFoot;
  if (unit == "us-ft" || unit == "us survey foot") return kSurveyFoot;
  return 1.0;
}

std::string vertical_reference(const OGRSpatialReference& frame) {
  const char* datum = frame.GetAttrValue("VERT_DATUM");
  if (datum == nullptr) datum = frame.GetAttrValue("VDATUM");
  return datum != nullptr ? datum : "not stated";
}

Status read_heights(GDALDataset& dataset, const std::filesystem::path& file, TerrainGrid& grid) {
  GDALRasterBand* band = dataset.GetRasterBand(1);
  grid.height_m.resize(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
  if (band->RasterIO(GF_Read, 0, 0, grid.columns, grid.rows, grid.height_m.data(), grid.columns, grid.rows,
                     GDT_Float32, 0, 0, nullptr) != CE_None)
    return unreadable(file, "terrain_unreadable", CPLGetLastErrorMsg(), "whole terrain data");
  int has_nodata = 0;
  const auto nodata = static_cast<float>(band->GetNoDataValue(&has_nodata));
  const double scale = band->GetScale() * unit_factor(*band), offset = band->GetOffset() * unit_factor(*band);
  for (float& height : grid.height_m) {
    const bool empty = (has_nodata != 0 && height == nodata) || !std::isfinite(height);
    height = empty ? std::numeric_limits<float>::quiet_NaN()
                   : static_cast<float>(static_cast<double>(height) * scale + offset);
  }
  return Done{};
}

}  // namespace

Result<TerrainGrid> read_terrain(const std::filesystem::path& file) {
  std::error_code failure;
  if (!std::filesystem::exists(file, failure))
    return unreadable(file, "file_missing", "no such file", "a terrain file");
  static std::once_flag registered;
  std::call_once(registered, [] { GDALAllRegister(); });
  const CPLConfigOptionSetter no_side_files("GDAL_PAM_ENABLED", "NO", false);
  const CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);
  const Dataset dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset || dataset->GetRasterCount() < 1)
    return unreadable(file, "terrain_unreadable", "not a terrain file that GDAL reads",
                      "GeoTIFF, .hgt or another grid");
  TerrainGrid grid;
  grid.source = file.filename().string();
  grid.columns = dataset->GetRasterXSize();
  grid.rows = dataset->GetRasterYSize();
  if (grid.columns < 2 || grid.rows < 2)
    return unreadable(file, "terrain_unreadable", "a grid of less than 2 x 2 cells", "a larger one");
  if (static_cast<std::int64_t>(grid.columns) * grid.rows > kMostCells)
    return unreadable(file, "terrain_too_large",
                      std::to_string(grid.columns) + " x " + std::to_string(grid.rows) + " cells",
                      "a part of it around the field");
  double forward[6], inverse[6];
  const OGRSpatialReference* frame = dataset->GetSpatialRef();
  if (frame == nullptr || dataset->GetGeoTransform(forward) != CE_None ||
      GDALInvGeoTransform(forward, inverse) == 0)
    return unreadable(file, "terrain_no_frame", "no coordinate system or no place on Earth",
                      "a georeferenced file");
  // GDAL counts from the corner of a cell; half a cell further is its middle.
  for (int i = 0; i < 3; ++i) {
    grid.column_from_xy[i] = inverse[i] - (i == 0 ? 0.5 : 0.0);
    grid.row_from_xy[i] = inverse[3 + i] - (i == 0 ? 0.5 : 0.0);
  }
  char* wkt = nullptr;
  frame->exportToWkt(&wkt);
  grid.frame_wkt = wkt != nullptr ? wkt : "";
  CPLFree(wkt);
  grid.vertical_reference = vertical_reference(*frame);
  FURROW_DO(read_heights(*dataset, file, grid));
  return grid;
}

std::optional<double> terrain_height_m(const TerrainGrid& grid, double latitude_deg, double longitude_deg) {
  check(grid.columns >= 2 && grid.rows >= 2, "terrain_height_m: an empty grid");
  if (!std::isfinite(latitude_deg) || !std::isfinite(longitude_deg)) return std::nullopt;
  const CPLErrorHandlerPusher quiet(CPLQuietErrorHandler);
  OGRSpatialReference wgs84, frame;
  if (wgs84.SetWellKnownGeogCS("WGS84") != OGRERR_NONE ||
      frame.importFromWkt(grid.frame_wkt.c_str()) != OGRERR_NONE)
    return std::nullopt;
  wgs84.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  frame.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
  double x = longitude_deg, y = latitude_deg;
  const std::unique_ptr<OGRCoordinateTransformation> transform(
      OGRCreateCoordinateTransformation(&wgs84, &frame));
  if (!transform || transform->Transform(1, &x, &y) == 0) return std::nullopt;
  const double column = grid.column_from_xy[0] + grid.column_from_xy[1] * x + grid.column_from_xy[2] * y;
  const double row = grid.row_from_xy[0] + grid.row_from_xy[1] * x + grid.row_from_xy[2] * y;
  if (!(column >= 0.0 && column <= grid.columns - 1.0 && row >= 0.0 && row <= grid.rows - 1.0))
    return std::nullopt;
  const int c = std::min(static_cast<int>(column), grid.columns - 2),
            r = std::min(static_cast<int>(row), grid.rows - 2);
  const double u = column - c, v = row - r;
  const auto cell = [&](int dr, int dc) {
    return static_cast<double>(
        grid.height_m[static_cast<std::size_t>(r + dr) * static_cast<std::size_t>(grid.columns) +
                      static_cast<std::size_t>(c + dc)]);
  };
  const double height_m =
      (1.0 - v) * ((1.0 - u) * cell(0, 0) + u * cell(0, 1)) + v * ((1.0 - u) * cell(1, 0) + u * cell(1, 1));
  if (!std::isfinite(height_m)) return std::nullopt;
  return height_m;
}

}  // namespace furrow::geo
