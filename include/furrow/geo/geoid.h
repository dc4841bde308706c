#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "furrow/base/result.h"

namespace furrow::geo {

/// A grid of geoid heights N (m): height_ellipsoid_m = height_geoid_m + N. Rows run from south to north,
/// columns from west to east. The grid spans 360 degrees of longitude and both poles.
struct GeoidGrid {
  std::string name;  ///< the model, for reports: a height over a geoid means nothing without it
  double west_deg = 0.0;
  double step_deg = 0.0;  ///< between rows and between columns
  int rows = 0, columns = 0;
  std::vector<float> height_m;  ///< row after row
};

/// Reads NOAA's GTX (40 bytes of header, then big-endian floats from the south-west corner). Only global
/// grids with one step for latitude and longitude are taken. Errors: file_*, geoid_malformed.
Result<GeoidGrid> read_gtx(const std::filesystem::path& file);
Result<GeoidGrid> parse_gtx(std::string_view bytes, const std::string& name);

/// EGM96 on 15' from PROJ's data (Debian package proj-data), sought in $PROJ_DATA, $PROJ_LIB and
/// /usr/share/proj. Errors: geoid_missing (lists the folders), geoid_malformed.
Result<GeoidGrid> egm96();

/// Geoid height N (m) at a place by cubic convolution (Keys 1981, a = -1/2) on 4 x 4 nodes: exact at the
/// nodes, continuous with its slope, across the date line and the poles too. On the 15' grid the
/// interpolation error of a cubic scheme is at most 0.17 m, 7 mm RMS (GeographicLib manual, geoid heights);
/// EGM96 itself is good to some 0.5 m.
double geoid_height_m(const GeoidGrid& grid, double latitude_deg, double longitude_deg);

}  // namespace furrow::geo
