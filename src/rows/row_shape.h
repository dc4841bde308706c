#pragma once
#include <vector>

#include "furrow/rows/row_lines.h"
#include "rows/field_search.h"
#include "rows/green_map.h"

namespace furrow::rows {

/// Where the common model puts rows on a picture row: row k lies at centre + k spacing, px of the picture.
struct Cut {
  double v = 0.0, centre = 0.0, spacing = 0.0;
};

/// The common model of a picture: the planar field, and what it left (FollowedField), in px of the picture.
class CommonModel {
 public:
  CommonModel(const FoundField& found, const GreenMap& search_map);
  /// Straight rows that keep to the plane.
  explicit CommonModel(const PlanarField& field) : field_(field) {}
  const PlanarField& field() const { return field_; }
  /// Only below the horizon.
  Cut at(double v) const;

 private:
  struct Departure {
    double v = 0.0, shift = 0.0, stretch = 1.0;  // of row centre_k in spacings; of the spacing
  };
  PlanarField field_;
  double centre_k_ = 0.0;
  std::vector<Departure> departures_;
};

/// A map with the running sum of each of its rows, which takes longer than a look at the rows through it.
class SummedMap {
 public:
  explicit SummedMap(GreenMap map);
  const GreenMap& map() const { return map_; }
  /// running(row)[u] is the sum over [0, u) for 0 <= u <= width, and once more at width + 1, so that places
  /// between need no test.
  const float* running(int row) const { return sums_.data() + static_cast<std::ptrdiff_t>(row) * (map_.width + 2); }

 private:
  GreenMap map_;
  std::vector<float> sums_;
};

/// Gives the rows their own centres and the edges of their visible green, from a map that may be finer than
/// the search's. `rows` come with samples at the model's places; samples that show no row of their own keep
/// them.
void shape_rows(const SummedMap& map, const CommonModel& model, std::vector<RowLine>& rows);

}  // namespace furrow::rows
