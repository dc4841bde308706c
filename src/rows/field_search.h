#pragma once
#include <optional>
#include <vector>

#include "furrow/rows/planar_field.h"
#include "rows/green_map.h"

namespace furrow::rows {

/// Strips of the picture, each a profile of greenness across it with mean 0 and variance 1, as running sums
/// for fast means.
struct Strips {
  int width = 0;  ///< of the map, px
  int height = 0;
  double strip_height = 1.0;
  std::vector<double> v;                    ///< middle of each strip, map px
  std::vector<std::vector<float>> profile;  ///< greenness across
  std::vector<std::vector<float>> sum;      ///< sum[j][u]: of profile[j] over [0, u)

  std::size_t count() const { return v.size(); }
  /// Mean over [from, to] (pixel borders are at +-0.5), clipped to the picture; weight is the part inside.
  struct Mean {
    double value = 0.0, weight = 0.0;
  };
  Mean mean(std::size_t strip, double from, double to) const;
};

Strips make_strips(const GreenMap& map, int strip_height);

/// A field in px of the map and how well it explains the picture.
struct FoundField {
  PlanarField field;
  double tooth = 0.3;  ///< width of a row in spacings that explains most
  double score = 0.0;  ///< mean correlation of a strip with the comb
  double contrast_share =
      0.0;  ///< part of the strips below the horizon whose rows are greener than their alleys
};

struct SearchPriors {
  std::optional<double> horizon_v, horizon_sigma;  ///< map px
};

/// The planar field that explains the greenness best, or nothing for a picture too small or without any
/// contrast.
std::optional<FoundField> search_field(const GreenMap& map, const SearchPriors& priors);

/// Comb score of a field: per strip, the correlation of its profile with a comb of rows `tooth` spacings
/// wide; mean over all strips.
double comb_score(const Strips& strips, const PlanarField& field, double tooth, double least_scale);

}  // namespace furrow::rows
