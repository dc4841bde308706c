#pragma once
#include <cstddef>
#include <vector>

#include "furrow/rows/planar_field.h"
#include "rows/green_map.h"

namespace furrow::rows {

/// Rows nearer than this cannot be told apart in a map: two samples a period and some blur.
constexpr float kLeastRowSpacingPx = 3.0F;

/// Horizontal strips of a map, each a profile of greenness across it: local mean 0, variance 1, peaks
/// limited.
struct Strips {
  int width = 0, height = 0;  ///< of the map, px
  std::vector<float> v;       ///< middle of each strip
  /// Running sums of the profiles, each with `width` entries of padding before and behind, so that intervals
  /// that leave the picture need no test: running(j)[u] is the sum over [0, u) for -width <= u <= 2 width.
  std::vector<float> sum;

  std::size_t count() const { return v.size(); }
  std::size_t stride() const { return 3 * static_cast<std::size_t>(width) + 1; }
  const float* running(std::size_t strip) const { return sum.data() + strip * stride() + width; }
};

Strips make_strips(const GreenMap& map, int strip_height);

/// Which rows and strips a score counts.
struct Emphasis {
  double least_scale = 0.05;  ///< strips whose spacing is below this part of the bottom one are left out
  double centre_k = 0.0;      ///< rows count with weight 1 / (1 + ((k - centre_k) / reach)^2)
  double reach = 1e9;
  double tilt = 0.0;  ///< dv/du of the horizon; the field is then that of the picture levelled by it
};

/// For every place of every strip: how much greener a row of that field would be there than what lies
/// between, as a correlation. Made for one field's spacings; valid for fields whose spacings differ by a few
/// percent. The strips are 16 px wide or more.
struct Response {
  int width = 0;
  std::vector<float> v;
  std::vector<float> value;  ///< value[j * width + u]

  const float* line(std::size_t strip) const {
    return value.data() + strip * static_cast<std::size_t>(width);
  }
  /// Nothing outside the picture.
  float at(std::size_t strip, float u) const {
    return between(line(strip), static_cast<float>(width - 1), u);
  }
  /// The same of a strip's line; `last` is its last place, px.
  static float between(const float* line, float last, float u) {
    if (!(u >= 0.0F) || u >= last) return 0.0F;
    const int i = static_cast<int>(u);
    return line[i] + (u - static_cast<float>(i)) * (line[i + 1] - line[i]);
  }
};

Response respond(const Strips& strips, const PlanarField& field, double tooth);

/// Mean over all strips of the mean response at the field's rows.
double comb_score(const Response& response, const PlanarField& field, const Emphasis& emphasis);

/// The same without a Response, for fields that are looked at once.
double comb_score(const Strips& strips, const PlanarField& field, double tooth, const Emphasis& emphasis);

/// Mean number of rows that a strip below the horizon shows.
double mean_row_count(const Strips& strips, const PlanarField& field);

}  // namespace furrow::rows
