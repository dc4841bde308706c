#pragma once
#include <cstdint>
#include <limits>

#include "furrow/altitude/field_knowledge.h"
#include "furrow/altitude/shot_height.h"
#include "furrow/base/random.h"
#include "furrow/camera/camera.h"
#include "furrow/geom/attitude.h"
#include "furrow/rows/row_lines.h"

/// An independent world for the altitude tests: rows are 3-D prisms whose edges are projected point by point
/// with camera::project, and whose silhouettes are found in the picture. It shares no formula with the
/// estimator.
namespace furrow::altitude::testing {

struct World {
  // The camera.
  double height_above_canopy_m = 1.3;
  geom::Attitude attitude;
  double cross_track_m = 0.0;  ///< camera left of row 0
  // The field.
  double spacing_m = 3.0;
  double half_width_m = 0.6;
  double base_half_width_m = 0.6;
  double foliage_depth_m = 1.0;
  double rounding_m = 0.0;  ///< the top is half an ellipse of this depth, 0 for a flat one
  /// Leaves thin out over this length at the edge of the canopy: its outline moves outwards by it where a
  /// line of sight meets e times as many of them.
  double softness_m = 0.0;
  /// How much of the walls' depth shows on the left and on the right of a row: in shade, leaves pass for
  /// soil.
  double left_wall_shown = 1.0, right_wall_shown = 1.0;
  int rows_each_side = 6;
  /// Rows bend: y = curvature x^2 / 2.
  double curvature_per_m = 0.0;
};

struct Noise {
  double edge_sigma_px = 0.0;
  double correlation = 0.0;       ///< between neighbouring samples of one edge
  double planting_sigma_m = 0.0;  ///< of a row's axis
  double growth_sigma_m = 0.0;    ///< of each edge of a row
  bool foot_anywhere = false;     ///< each wall's green ends anywhere between the row's top and its base
  bool edges = true;              ///< give edges; else centres of the visible green only
  /// A row's far edge is seen against the next row's leaves; else only against soil, as by a detector of
  /// green.
  bool leaf_against_leaf = true;
  /// Far edges of tops that stand against leaves and are not told otherwise are told by their light on the
  /// three rows to each side, with one error for a row of this sigma, px along the picture row; 0: not at
  /// all.
  double top_sigma_px = 0.0;
};

/// The thesis's camera at 1280x720 (THESIS.md, section 2), with mild distortion.
Camera thesis_camera();

/// What a perfect detector would find in the picture of that world, plus the noise.
rows::RowLines picture_of(const World& world, const Camera& camera, const Noise& noise = {},
                          std::uint64_t seed = 1);

/// FieldKnowledge equal to the world, with these relative sigmas.
FieldKnowledge knowledge_of(const World& world, double relative_sigma);

/// Exact attitude prior with these sigmas.
AttitudePrior prior_of(const World& world, double pitch_sigma_rad, double roll_sigma_rad);

}  // namespace furrow::altitude::testing
