#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::geo {

/// Heights of the ground (or of what grows on it: surface models hold trees) on a grid. What they are
/// measured from the file seldom says: SRTM is over EGM96, Copernicus over EGM2008, a photogrammetric model
/// over the ellipsoid. So use differences of heights within one file.
struct TerrainGrid {
  std::string source;              ///< file name
  std::string vertical_reference;  ///< as the file names it; "not stated" otherwise
  int columns = 0, rows = 0;
  std::vector<float> height_m;  ///< row after row from the top; NaN where the file has none
  /// Column and row (0, 0 at the middle of the top-left cell) of a place (x, y) in the file's own frame: col
  /// = a0 + a1 x + a2 y, row likewise.
  double column_from_xy[3] = {0, 0, 0}, row_from_xy[3] = {0, 0, 0};
  std::string frame_wkt;  ///< coordinate system of (x, y)
};

/// Reads a terrain file that GDAL knows (GeoTIFF, SRTM .hgt, ASCII grid, ...), first band. Heights in feet
/// become metres; nodata becomes NaN. Errors: file_missing, terrain_unreadable, terrain_no_frame (no
/// coordinate system or no transform), terrain_too_large.
Result<TerrainGrid> read_terrain(const std::filesystem::path& file);

/// Height at a place, bilinear between cell middles; nothing outside the file or where a neighbouring cell is
/// void.
std::optional<double> terrain_height_m(const TerrainGrid& grid, double latitude_deg, double longitude_deg);

}  // namespace furrow::geo
