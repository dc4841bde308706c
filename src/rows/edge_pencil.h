#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "furrow/rows/detect.h"
#include "furrow/rows/row_lines.h"

namespace furrow::rows {

/// Where the edges of straight, parallel rows meet, px of the picture: by robust least squares over all edges
/// and the gimbal's horizon (docs/formulation/rows.md). The edges tell it far better than the search does,
/// which sees how green rows and alleys are but not where a row ends. Nothing without a horizon, with fewer
/// than two rows that show edges, or where the edges deny the horizon by more than three of its sigmas.
std::optional<Eigen::Vector2d> meeting_point(const std::vector<RowLine>& rows, const Priors& priors,
                                             double u_middle);

/// The straight field whose rows meet at `point` and lie on picture row `v` where `row_zero_u` and `spacing`
/// say; anchored as `field`.
PlanarField field_through(const PlanarField& field, const Eigen::Vector2d& point, double v, double row_zero_u,
                          double spacing);

/// The straight field as it lies in the picture that is levelled by `tilt` more (levelled.h). Row 0 and the
/// spacing beside it are those of `field`; other rows fan out unevenly from where they were. Nothing where
/// row 0 lies along the picture's rows.
std::optional<PlanarField> relevelled(const PlanarField& field, double tilt, double u_middle);

}  // namespace furrow::rows
