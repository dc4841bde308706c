#pragma once
#include <array>
#include <Eigen/Core>
#include <optional>

#include "furrow/rows/planar_field.h"
#include "rows/green_map.h"

namespace furrow::rows {

inline constexpr int kLightBlocks = 8;       ///< independent parts of a picture, for the sigma of a place
inline constexpr double kLightReach = 4.5;   ///< row numbers to each side that are looked at
inline constexpr double kLightBin = 0.02;    ///< row numbers
inline constexpr int kLightBins = 450;       ///< 2 kLightReach / kLightBin
inline constexpr double kLeastScale = 0.10;  ///< PlanarField::scale: farther off a spacing has too few pixels

/// The field with a tilted horizon: row number k lies at u = u_vp + (v - v_vp) m / (1 + tilt m).
struct Fan {
  Eigen::Vector2d point;
  double per_row = 1.0, zero = 0.0, tilt = 0.0;

  double u_at(double v, double k) const {
    const double m = zero + k * per_row;
    return point.x() + (v - point.y()) * m / (1.0 + tilt * m);
  }
};

/// Nothing where the rows are parallel in the picture. `tilt` is dv/du of the horizon.
std::optional<Fan> fan_of(const PlanarField& field, double tilt);

/// By real-valued row number, for each block of picture rows: sum of the leaves' light, how much is leaf, and
/// number of picture rows. Lines parallel to the rows keep their number in any perspective, whatever their
/// height.
struct LightByRow {
  std::array<std::array<float, kLightBins>, kLightBlocks> lit{}, leaf{}, count{};
};

LightByRow light_by_row(const GreenMap& map, const PlanarField& field, const Fan& fan);

/// Row number at the outer border of a bin, which may lie between two.
inline double place_of(double bin) {
  return (bin + 1.0) * kLightBin - kLightReach;
}
inline double bin_at(double place) {
  return (place + kLightReach) / kLightBin - 1.0;
}

/// How much the light changes at each bin's outer border, away from the followed row on the given side:
/// positive where it drops.
using LightDrop = std::array<float, kLightBins>;

/// Log light of the leaves, against the typical leaf's.
struct MeanLight {
  std::array<float, kLightBins> mean{};
  std::array<bool, kLightBins> there{};
};

/// What a place is that shows no leaves: darker than any leaf, so that ground beyond a top counts as its end
/// like a wall in shade, or not there.
enum class Bare { dark, not_there };

/// The light on one side of the followed row (`direction` -1: left, 1: right).
struct LightSide : MeanLight {
  int direction = 1;
  LightDrop all{};
  std::array<LightDrop, kLightBlocks> without{};  ///< of all blocks but one

  LightSide(const MeanLight& light, const std::array<MeanLight, kLightBlocks>& light_without, int towards);

  /// Standard error of the drop at a place, by leaving out each block (Tukey's jackknife).
  float sigma_at(double place) const;
};

/// Left and right.
std::array<LightSide, 2> sides_of(const LightByRow& light, Bare bare);

float value_at(const LightDrop& drop, double place);

/// Where the light drops most (`sign` 1) or rises most (-1) within `reach` of a place, sub-bin by a parabola;
/// nothing where it does not.
std::optional<double> peak_near(const LightDrop& drop, float sign, double place, double reach);

}  // namespace furrow::rows
