#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "furrow/geom/attitude.h"
#include "furrow/geom/rigid3.h"
#include "furrow/image/image.h"
#include "furrow/sim/scene.h"

/// The simulated world without files, for tests and benches that want truth and pictures in memory.
namespace furrow::sim {

/// Where the camera truly was at one exposure (its middle row, its middle moment).
struct ShotTruth {
  std::string shot_id;  ///< "shot-0001", also the stem of the picture
  double t_log_s = 0.0;
  Rigid3 cam_from_world;               ///< world: ENU at the take-off point
  Eigen::Vector3d x_in_world;          ///< camera centre
  double along_row_m = 0.0;            ///< s
  double cross_track_m = 0.0;          ///< camera left of the nearest row
  int nearest_row = 0;                 ///< counted to the left from row 0
  double height_above_ground_m = 0.0;  ///< above the soil straight below
  double height_above_canopy_m = 0.0;  ///< above the plane of the row tops straight below
  geom::Attitude attitude;             ///< against the row's direction at s
  double heading_deg = 0.0;            ///< of the camera, clockwise from north
};

/// All shots of the flight, in order. The scene must be valid.
std::vector<ShotTruth> true_shots(const Scene& scene);

/// x_in_world of a point given in row coordinates (s, l, height above the soil there).
Eigen::Vector3d world_from_row(const Scene& scene, const Eigen::Vector3d& s_l_height);

/// (s, l, height above the soil) of a point of the world.
Eigen::Vector3d row_from_world(const Scene& scene, const Eigen::Vector3d& x_in_world);

/// Where one row's plane of tops crosses a picture row.
struct RowCrossing {
  double v_px = 0.0;
  double u_px = 0.0;                         ///< of the row's centre line at the height of the row tops
  double left_u_px = 0.0, right_u_px = 0.0;  ///< of the edges of the stated half width at that height
};

/// A row as the picture of one shot would show it if the canopy were its plane of tops.
struct TrueRow {
  int row = 0;    ///< counted to the left from row 0
  int index = 0;  ///< from left to right; 0 crosses the picture's middle row nearest its middle column
  std::vector<RowCrossing>
      crossings;  ///< every `step_px` from top to bottom, where the centre is in the picture
};

/// Rows of a shot (its pose at the middle of the exposure; a rolling shutter is left out), from left to
/// right.
std::vector<TrueRow> true_rows(const Scene& scene, const ShotTruth& shot, double step_px = 10.0);

/// Pictures of one scene; keeps what all shots share (ray table, canopy levels).
class Renderer {
 public:
  explicit Renderer(const Scene& scene);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// The picture of shot `index` of true_shots(), before JPEG. Safe to call from several threads at a time.
  Image shot(std::size_t index) const;
  /// Picture of board pose `index`, in [0, scene.boards.count).
  Image board(int index) const;

 private:
  struct Shared;
  std::unique_ptr<const Shared> shared_;
};

/// cam_from_board of every board picture; board: origin at the first inner corner, x along the columns, y
/// along the rows.
std::vector<Rigid3> true_boards(const Scene& scene);

}  // namespace furrow::sim
