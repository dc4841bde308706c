#pragma once
#include <array>
#include <cstdint>
#include <Eigen/Core>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/sim/scene.h"

namespace furrow::sim {

enum class Shape : std::uint8_t {
  leaf,   ///< lobed when large in the picture, a hexagon when small
  blade,  ///< a parallelogram: corn blades, trunks, posts
};

/// A small flat thing in row coordinates (s, l, height above the soil).
struct Leaf {
  Eigen::Vector3f centre;
  Eigen::Vector3f along, across;  ///< half axes
  Eigen::Vector3f colour;         ///< linear radiance under the scene's sun
  Shape shape = Shape::leaf;
};

/// The plants of all rows, made on demand piece by piece: the same piece always has the same leaves. Coarser
/// levels hold fewer leaves that are longer along the row, with the same mean silhouette.
class Canopy {
 public:
  /// Level k holds leaves kStretch[k] times as long along the row and kWiden[k] times as wide.
  static constexpr int kLevels = 7;
  static constexpr std::array<double, kLevels> kStretch = {1, 2, 4, 8, 16, 16, 16};
  static constexpr std::array<double, kLevels> kWiden = {1, 1, 1, 1, 1, 2, 3};
  static constexpr double kPiece_m = 1.0;

  explicit Canopy(const Scene& scene);

  /// Appends the leaves of row `row`, s in [piece, piece + 1) m, as the sun lights them. `direction_rad`: of
  /// the row there.
  void append_piece(int row, int piece, int level, double direction_rad, std::vector<Leaf>& out) const;

  /// Part of the sun's light that the rows let through to a point; `direction_rad` as above.
  double sunlight(double s, double l, double height_m, double direction_rad) const;

  /// Sun's direction in row coordinates, and its height.
  Eigen::Vector3d to_sun(double direction_rad) const;

  /// Foliage present at s of a row: 0 in a gap, about 1 elsewhere.
  double density(int row, double s) const;

  /// Half width of the envelope at a height above the soil; 0 where there is no foliage.
  double envelope_half_width(double height_m) const;

 private:
  struct Fit {
    double inset_m = 0.0;  ///< the envelope's edge lies so far inside the stated half width
    double drop_m = 0.0;   ///< and its top below the stated height
  };
  struct Surface {
    Eigen::Vector3d point, normal;
    double depth;    ///< 0 at the top of the canopy, 1 at its lowest leaves
    double outside;  ///< offset outwards from the envelope, in sigmas
    bool inner;
  };
  void append_vines(int row, int piece, int level, const Fit& fit, bool calibrating, double direction_rad,
                    std::vector<Leaf>& out) const;
  void append_corn(int row, int piece, const Fit& fit, bool calibrating, double direction_rad,
                   std::vector<Leaf>& out) const;
  void append_wood(int row, int piece, double direction_rad, std::vector<Leaf>& out) const;
  Surface pick_surface(int row, double s, const Fit& fit, bool with_inner, base::Random& random) const;
  Eigen::Vector3f light_leaf(const Surface& at, const Eigen::Vector3d& leaf_normal, int row,
                             double direction_rad, base::Random& random) const;
  Fit fit_level(int level) const;
  bool plant_missing(int row, std::int64_t plant) const;
  std::uint64_t key(std::uint64_t salt, std::int64_t a, std::int64_t b = 0) const;

  const Scene scene_;
  std::array<Fit, kLevels> fits_;
};

/// Mean silhouette of leaves seen from straight above, over a stretch of one row at l = 0.
struct Silhouette {
  double half_width_m = 0.0;  ///< where half of the ground is covered, mean of both sides
  double top_m = 0.0;         ///< mean first-hit height over the middle four fifths of `nominal_half_width_m`
};
Silhouette measure_silhouette(const std::vector<Leaf>& leaves, double length_m, double nominal_half_width_m);

/// Corner `i` of a leaf's outline, in units of its half axes; small outlines have 6 corners, lobed ones 10 (5
/// lobes).
inline constexpr int kHexagonCorners = 6;
inline constexpr int kLobedCorners = 10;
std::array<Eigen::Vector2f, kHexagonCorners> hexagon_outline();
std::array<Eigen::Vector2f, kLobedCorners> lobed_outline();

}  // namespace furrow::sim
