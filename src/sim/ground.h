#pragma once
#include <Eigen/Core>
#include <optional>

#include "sim/canopy.h"
#include "sim/plan.h"

namespace furrow::sim {

/// What stands behind the plants: soil with grass and shadows, the land around the field, hills and sky. All
/// colours linear.
class Backdrop {
 public:
  Backdrop(const Scene& scene, const Terrain& terrain, const RowFrame& rows, const Canopy& canopy,
           double first_s, double last_s);

  struct Hit {
    Eigen::Vector3f colour;
    float inverse_depth = 0.0F;  ///< 1 / (parameter of the ray); 0 for the sky
  };
  /// `ray` in the plan, from `centre`; `pixel_angle`: of one pixel, radians.
  Hit look(const Eigen::Vector3d& centre, const Eigen::Vector3d& ray, double pixel_angle) const;

  /// Light scattered by `distance_m` of air.
  static Eigen::Vector3f through_air(const Eigen::Vector3f& colour, double distance_m);

 private:
  std::optional<double> meet_ground(const Eigen::Vector3d& centre, const Eigen::Vector3d& ray) const;
  Eigen::Vector3f soil(double s, double l, double footprint_s, double footprint_l) const;
  Eigen::Vector3f land(double s, double l, double footprint) const;
  Eigen::Vector3f sky(const Eigen::Vector3d& ray, double pixel_angle) const;

  const Scene scene_;
  const Terrain& terrain_;
  const RowFrame& rows_;
  const Canopy& canopy_;
  double first_s_, last_s_, half_breadth_m_;
  std::uint32_t key_;
};

}  // namespace furrow::sim
