#pragma once
#include <vector>

#include "furrow/rows/planar_field.h"
#include "rows/comb.h"

namespace furrow::rows {

/// What the planar model leaves: on each strip the rows lie at centre + (k - centre_k) spacing, in px of the
/// map.
struct FollowedField {
  double centre_k = 0.0;
  std::vector<double> v, centre, spacing;  ///< by rising v
};

/// Lets centre and spacing leave the plane from strip to strip: the mean over all ways that the rows may have
/// taken, each by what the strips respond along it and by its steps (forward and backward sums, as for hidden
/// Markov chains). Rows count with weight 1 / (1 + ((k - centre_k) / reach)^2).
FollowedField follow(const Response& response, const PlanarField& field, double centre_k, double reach);

}  // namespace furrow::rows
