#pragma once
#include <vector>

#include "furrow/rows/planar_field.h"
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

}  // namespace furrow::rows
