#include "rows/common_model.h"

#include <algorithm>

namespace furrow::rows {

CommonModel::CommonModel(const FoundField& found, const GreenMap& search_map)
    : field_(found.field), centre_k_(found.followed.centre_k) {
  field_.u0 = search_map.u_in_picture(found.field.u0);
  field_.v0 = search_map.v_in_picture(found.field.v0);
  field_.length = found.field.length * search_map.scale_v;
  for (double* px : {&field_.spacing, &field_.offset, &field_.slope, &field_.bend, &field_.bend2})
    *px *= search_map.scale_u;
  const FollowedField& followed = found.followed;
  for (std::size_t i = 0; i < followed.v.size(); ++i) {
    const double spacing = found.field.spacing_at(followed.v[i]);
    departures_.push_back({search_map.v_in_picture(followed.v[i]),
                           (followed.centre[i] - found.field.u_at(followed.v[i], centre_k_)) / spacing,
                           followed.spacing[i] / spacing});
  }
}

Cut CommonModel::at(double v) const {
  double shift = 0.0, stretch = 1.0;
  if (!departures_.empty()) {
    const auto upper = std::lower_bound(departures_.begin(), departures_.end(), v,
                                        [](const Departure& one, double at) { return one.v < at; });
    const Departure& b = upper == departures_.end() ? departures_.back() : *upper;
    const Departure& a = upper == departures_.begin() ? b : *(upper - 1);
    const double part = b.v > a.v ? std::clamp((v - a.v) / (b.v - a.v), 0.0, 1.0) : 0.0;
    shift = a.shift + part * (b.shift - a.shift);
    stretch = a.stretch + part * (b.stretch - a.stretch);
  }
  const double spacing = field_.spacing_at(v);
  return {v, field_.u_at(v, centre_k_) + shift * spacing - centre_k_ * spacing * stretch, spacing * stretch};
}

}  // namespace furrow::rows
