#pragma once
#include <array>
#include <cstdint>
#include <Eigen/Core>
#include <vector>

#include "furrow/base/random.h"
#include "furrow/sim/scene.h"

namespace furrow::sim {

/// Colours of the light, the sun's green channel about 1.
inline const Eigen::Vector3f kSunColour(1.0F, 0.97F, 0.90F);
inline const Eigen::Vector3f kSkyColour(0.82F, 0.98F, 1.25F);

enum class Shape : std::uint8_t {
  leaf,   ///< lobed when large in the picture, a hexagon when small
  blade,  ///< a trapezium: a length of a corn blade, a trunk or a post
};

/// A small flat thing in row coordinates (s, l, height above the soil).
struct Leaf {
  Eigen::Vector3f centre;
  Eigen::Vector3f along, across;  ///< half axes
  Shape shape = Shape::leaf;
  float taper = 1.0F;  ///< of a blade: width at the far end of `along` over that at the near end, whose half
                       ///< is `across`
  /// Blades carry their colour (linear radiance under the scene's sun); leaves are lit only when they are
  /// seen, by Canopy::light().
  Eigen::Vector3f colour;
  Eigen::Vector3f normal;
  float part = 0.0F;     ///< place in its piece, 0 to 1
  float depth = 0.0F;    ///< 0 at the top of the canopy, 1 at its lowest leaves
  float outside = 0.0F;  ///< offset outwards from the envelope, in sigmas
  bool inner = false, left = false;
  std::uint64_t seed = 0;
};

/// What changes slowly along a row, over one piece of it.
struct Course {
  static constexpr int kNodes = 11;
  std::array<double, kNodes> top, left, right, density, tone;
  /// Sun that reaches the walls from the top down, left and right.
  std::array<double, kNodes> sun_left, sun_right;
  Eigen::Vector3d sun;
  double at(const std::array<double, kNodes>& nodes, double part) const {
    const double x = part * (kNodes - 1);
    const auto i = static_cast<std::size_t>(x);
    return nodes[i] + (x - static_cast<double>(i)) * (nodes[i + 1] - nodes[i]);
  }
};

/// The plants of all rows, made on demand piece by piece: the same piece always has the same leaves. Coarser
/// levels hold fewer leaves that are longer along the row, with the same mean silhouette.
class Canopy {
 public:
  /// Level (i, j), numbered i + kStretches j, holds leaves kStretch[i] times as long along the row and
  /// kWiden[j] times as wide.
  static constexpr int kStretches = 5, kWidenings = 3;
  static constexpr int kLevels = kStretches * kWidenings;
  static constexpr std::array<double, kStretches> kStretch = {1, 2, 4, 8, 16};
  static constexpr std::array<double, kWidenings> kWiden = {1, 2, 3};
  static double stretch_of(int level) { return kStretch[static_cast<std::size_t>(level % kStretches)]; }
  static double widen_of(int level) { return kWiden[static_cast<std::size_t>(level / kStretches)]; }
  static constexpr double kPiece_m = 1.0;

  /// Without `fitted` only density() and the shadows may be asked for; fitting takes a fraction of a second.
  explicit Canopy(const Scene& scene, bool fitted = true);

  /// The leaves of row `row`, s in [piece, piece + 1) m, into `out`. `direction_rad`: of the row there.
  /// `hidden_side`: 1 to leave out what stands on the lower left wall because the camera is far to the right,
  /// -1 the other way, 0 for all.
  Course append_piece(int row, int piece, int level, double direction_rad, int hidden_side,
                      std::vector<Leaf>& out) const;

  /// Colour of a leaf of a piece with that course.
  Eigen::Vector3f light(const Leaf& leaf, const Course& course) const;

  /// Part of the sun's light that the rows let through to a point; `direction_rad` as above.
  double sunlight(double s, double l, double height_m, double direction_rad) const;

  /// The same under rows without gaps: quicker, for leaves.
  double sunlight_under_even_rows(const Eigen::Vector3d& sun, double l, double height_m) const;

  /// Sun's direction in row coordinates, and its height.
  Eigen::Vector3d to_sun(double direction_rad) const;

  /// Foliage present at s of a row: 0 in a gap, about 1 elsewhere.
  double density(int row, double s) const;

  /// The same without gaps.
  double even_density(int row, double s) const;

  /// Half width of the envelope at a height above the soil; 0 where there is no foliage.
  double envelope_half_width(double height_m) const;

 private:
  /// What append_vines is asked for.
  struct Piece {
    int row, number, level;
    int hidden_side;
    bool calibrating;
    double direction_rad;
  };
  struct Fit {
    double inset_m = 0.0;  ///< the envelope's edge lies so far inside the stated half width
    double drop_m = 0.0;   ///< and its top below the stated height
  };
  struct Surface {
    Eigen::Vector3d point, normal;
    double depth;    ///< 0 at the top of the canopy, 1 at its lowest leaves
    double outside;  ///< offset outwards from the envelope, in sigmas
    bool inner, left;
  };
  Course append_vines(const Piece& piece, const Fit& fit, std::vector<Leaf>& out) const;
  void append_corn(const Piece& piece, const Fit& fit, std::vector<Leaf>& out) const;
  void append_blade(const Eigen::Vector3d& foot, double turn, double length, double rise, double half_width,
                    int cuts, const Eigen::Vector3d& sun, std::vector<Leaf>& out) const;
  void append_wood(int row, int piece, double direction_rad, std::vector<Leaf>& out) const;
  Course course_of(const Piece& piece, const Fit& fit) const;
  Surface pick_surface(const Course& course, double part, bool with_inner, base::Random& random) const;
  double open_above(double outside) const;
  Fit fit_level(int level) const;
  static int alike(int level);
  static bool has_inner(int level);
  bool plant_missing(int row, std::int64_t plant) const;
  std::uint64_t key(std::uint64_t salt, std::int64_t a, std::int64_t b = 0) const;

  const Scene scene_;
  std::array<Fit, kLevels> fits_;
  static constexpr int kOpenNodes = 65;
  std::array<double, kOpenNodes> open_{};  ///< open_above() at offsets from -4 to 4 sigma
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
/// As large as the hexagon.
std::array<Eigen::Vector2f, 4> rectangle_outline();
std::array<Eigen::Vector2f, 4> blade_outline(float taper);

}  // namespace furrow::sim
