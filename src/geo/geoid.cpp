#include "furrow/geo/geoid.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "furrow/base/file.h"
#include "furrow/base/text.h"

namespace furrow::geo {
namespace {

constexpr std::size_t kHeaderBytes = 40;
/// |N| stays below 107 m on Earth; more means another byte order or another quantity.
constexpr double kLargestGeoidHeight_m = 150.0;

template <class Word>
Word big_endian(std::string_view bytes, std::size_t at) {
  Word word = 0;
  for (std::size_t i = 0; i < sizeof(Word); ++i)
    word = static_cast<Word>((word << 8) | static_cast<unsigned char>(bytes[at + i]));
  return word;
}
double big_endian_double(std::string_view bytes, std::size_t at) {
  return std::bit_cast<double>(big_endian<std::uint64_t>(bytes, at));
}

Error malformed(const std::string& name, std::string found) {
  return {"geoid_malformed", name, std::move(found),
          "a global GTX grid with equal steps in latitude and longitude", ""};
}

/// Height at a node; a row beyond a pole continues on the meridian opposite.
double node_m(const GeoidGrid& grid, int row, int column) {
  if (row < 0 || row >= grid.rows) {
    row = row < 0 ? -row : 2 * (grid.rows - 1) - row;
    column += grid.columns / 2;
  }
  column = ((column % grid.columns) + grid.columns) % grid.columns;
  return static_cast<double>(
      grid.height_m[static_cast<std::size_t>(row) * static_cast<std::size_t>(grid.columns) +
                    static_cast<std::size_t>(column)]);
}

/// Weights of the nodes at -1, 0, 1, 2 for a place at t in [0, 1] (Keys 1981, a = -1/2).
std::array<double, 4> cubic_weights(double t) {
  return {t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2.0 - 1.5 * t)),
          t * t * (-0.5 + 0.5 * t)};
}

}  // namespace

Result<GeoidGrid> parse_gtx(std::string_view bytes, const std::string& name) {
  if (bytes.size() < kHeaderBytes)
    return malformed(name, std::to_string(bytes.size()) + " bytes, less than a header");
  GeoidGrid grid;
  grid.name = name;
  const double south_deg = big_endian_double(bytes, 0);
  grid.west_deg = big_endian_double(bytes, 8);
  grid.step_deg = big_endian_double(bytes, 16);
  const double column_step_deg = big_endian_double(bytes, 24);
  grid.rows = static_cast<int>(big_endian<std::uint32_t>(bytes, 32));
  grid.columns = static_cast<int>(big_endian<std::uint32_t>(bytes, 36));
  constexpr int kLargestSide = 100'000;
  if (grid.rows < 3 || grid.columns < 4 || grid.rows > kLargestSide || grid.columns > kLargestSide ||
      grid.columns % 2 != 0)
    return malformed(
        name, "a grid of " + std::to_string(grid.rows) + " x " + std::to_string(grid.columns) + " nodes");
  const std::size_t nodes = static_cast<std::size_t>(grid.rows) * static_cast<std::size_t>(grid.columns);
  if (bytes.size() != kHeaderBytes + 4 * nodes)
    return malformed(name, std::to_string(bytes.size()) + " bytes where the header promises " +
                               std::to_string(kHeaderBytes + 4 * nodes));
  const double kSlack_deg = 1e-6;
  const bool global =
      std::abs(south_deg + 90.0) < kSlack_deg && std::abs(grid.step_deg - column_step_deg) < kSlack_deg &&
      std::abs(grid.step_deg * (grid.rows - 1) - 180.0) < kSlack_deg &&
      std::abs(grid.step_deg * grid.columns - 360.0) < kSlack_deg && std::abs(grid.west_deg) <= 360.0;
  if (!global) return malformed(name, "a grid that does not span the Earth");
  grid.height_m.resize(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    grid.height_m[i] = std::bit_cast<float>(big_endian<std::uint32_t>(bytes, kHeaderBytes + 4 * i));
    if (!(std::abs(static_cast<double>(grid.height_m[i])) < kLargestGeoidHeight_m))
      return malformed(name, "a geoid height of " +
                                 base::format_double(static_cast<double>(grid.height_m[i])) + " m at node " +
                                 std::to_string(i));
  }
  return grid;
}

Result<GeoidGrid> read_gtx(const std::filesystem::path& file) {
  FURROW_TRY(const std::string bytes, base::read_file(file));
  return parse_gtx(bytes, file.stem().string());
}

Result<GeoidGrid> egm96() {
  std::vector<std::filesystem::path> folders;
  for (const char* variable : {"PROJ_DATA", "PROJ_LIB"})
    if (const char* value = std::getenv(variable); value != nullptr && *value != '\0')
      for (const std::string_view part : base::split(value, ':'))
        if (!part.empty()) folders.emplace_back(part);
  folders.emplace_back("/usr/share/proj");
  std::string sought;
  for (const auto& folder : folders) {
    const auto file = folder / "egm96_15.gtx";
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) return read_gtx(file);
    sought += (sought.empty() ? "" : ", ") + folder.string();
  }
  return Error{"geoid_missing", "egm96_15.gtx", "not in " + sought, "the EGM96 grid",
               "Install the Debian package proj-data."};
}

double geoid_height_m(const GeoidGrid& grid, double latitude_deg, double longitude_deg) {
  check(grid.rows > 2 && grid.columns > 3, "geoid_height_m: an empty grid");
  if (!(std::abs(latitude_deg) <= 90.0) || !std::isfinite(longitude_deg))
    return std::numeric_limits<double>::quiet_NaN();
  const double row = (latitude_deg + 90.0) / grid.step_deg;
  const double column = std::remainder(longitude_deg - grid.west_deg, 360.0) / grid.step_deg;
  const int row0 = std::min(static_cast<int>(std::floor(row)), grid.rows - 2);
  const int column0 = static_cast<int>(std::floor(column));
  const auto row_weights = cubic_weights(row - row0);
  const auto column_weights = cubic_weights(column - column0);
  double sum = 0.0;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      sum += row_weights[static_cast<std::size_t>(i)] * column_weights[static_cast<std::size_t>(j)] *
             node_m(grid, row0 + i - 1, column0 + j - 1);
  return sum;
}

}  // namespace furrow::geo
