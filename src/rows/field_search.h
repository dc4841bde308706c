#pragma once
#include <optional>
#include <vector>

#include "furrow/rows/planar_field.h"
#include "rows/follow_field.h"
#include "rows/green_map.h"

namespace furrow::rows {

/// A field in px of the map and how well it explains the picture.
struct FoundField {
  PlanarField field;
  double tooth = 0.3;  ///< width of a row in spacings that explains most
  double score = 0.0;  ///< mean response, lowered where few rows carry it
  double tilt = 0.0;   ///< dv/du of the horizon, where the rows clearly show one; else 0
  /// Part of the pattern that half strips show by themselves which the field explains; 1 where they show none
  /// clearly. A field that is right has more than two thirds.
  double explained = 1.0;
  FollowedField
      followed;  ///< the same rows, let go from the plane where the picture asks for it (hills, uneven bends)
};

struct SearchPriors {
  std::optional<double> horizon_v, horizon_sigma;  ///< map px
};

/// The planar field that explains the greenness best, or nothing for a picture too small or without any
/// contrast.
std::optional<FoundField> search_field(const GreenMap& map, const SearchPriors& priors);

/// What the best field of a quick look explains, on a scale of its own that is the same for the same picture
/// levelled differently.
double promise_of(const GreenMap& map);

/// The field that `before`, of a picture a moment ago, has become; nothing when it is not there any more.
std::optional<FoundField> continue_field(const GreenMap& map, const FoundField& before,
                                         const SearchPriors& priors);

}  // namespace furrow::rows
