#include <cmath>

#include "furrow/altitude/shot_height.h"

namespace furrow::altitude {
namespace {

RowOffset of(const SpacingHeight& closed) {
  return {closed.cross_track_m, closed.yaw_rad, closed.row_spacing_m,
          closed.cross_track_spacing_covariance_m2};
}

/// The refined shot once its height is known better, by its covariance (eq. 3.11).
RowOffset of(const RefinedShot& shot, const Estimate& height_above_canopy_m) {
  constexpr int kHeight = 0, kYaw = 3, kCross = 4, kSpacing = 5;  // places in its covariance
  Eigen::MatrixXd covariance = shot.covariance;
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(covariance.rows());
  if (height_above_canopy_m.usable()) {
    const Eigen::VectorXd shared = covariance.col(kHeight);
    const double variance = shared[kHeight] + height_above_canopy_m.sigma * height_above_canopy_m.sigma;
    moved = shared * ((height_above_canopy_m.value - shot.height_above_canopy_m.value) / variance);
    covariance -= shared * shared.transpose() / variance;
  }
  const auto estimate = [&](const Estimate& before, int place) {
    return Estimate{before.value + moved[place], std::sqrt(covariance(place, place)), before.observations};
  };
  return {estimate(shot.cross_track_m, kCross), estimate(shot.yaw_rad, kYaw),
          estimate(shot.row_spacing_m, kSpacing), covariance(kCross, kSpacing)};
}

}  // namespace

Result<RowOffset> offset_from_rows(const rows::RowLines& lines, const Camera& camera,
                                   const FieldKnowledge& field, const AttitudePrior& prior,
                                   const Estimate& height_above_canopy_m) {
  rows::RowLines seen = lines;
  std::erase_if(seen.rows, [](const rows::RowLine& row) { return !row.seen; });
  if (field.row_spacing_m.usable()) {
    const auto refined = refine_shot(seen, camera, field, prior);
    if (refined.ok()) return of(*refined, height_above_canopy_m);
  }
  FURROW_TRY(const RowsOnUnitPlane directions, rows_on_unit_plane(seen, camera));
  FURROW_TRY(const SpacingHeight closed, from_any_scale(directions, field, prior, height_above_canopy_m));
  if (closed.cross_track_m.usable()) return of(closed);
  return Error{"no_metres", "rows", "one row, which says nothing of its neighbours' distance",
               "a height above the canopy, or the row's half width", ""};
}

}  // namespace furrow::altitude
