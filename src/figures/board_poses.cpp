// The boards as the camera saw them, in the camera's frame.
//
// Drawn by our own painter rather than VTK's 3-D pipeline, so that PNG and SVG show the same lines
// (docs/decisions). The projection is orthographic: equal lengths along an axis stay equal anywhere in the
// picture, so positions can be read off the grid.
#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <numeric>

#include "figures/finish.h"
#include "figures/font.h"
#include "figures/plot.h"
#include "furrow/base/text.h"
#include "furrow/figures/figures.h"
#include "furrow/geom/angles.h"

namespace furrow::figures {
namespace {

/// The eye stands behind the camera, to its right and above, and looks this much to the left of the optical
/// axis and down.
constexpr double kAzimuthRad = geom::deg_to_rad(52.0);
constexpr double kElevationRad = geom::deg_to_rad(22.0);

/// Orthographic view of the camera's frame (x right, y down, z forward).
struct View3 {
  Eigen::Vector3d right, up, away;  ///< unit vectors of the paper in cam
  double pt_per_m = 1.0;
  Point origin_pt = Point::Zero();  ///< where the camera stands on the paper

  Point map(const Eigen::Vector3d& x_in_cam) const {
    return origin_pt + pt_per_m * Point(right.dot(x_in_cam), -up.dot(x_in_cam));
  }
};

View3 standard_view() {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), above = -Eigen::Vector3d::UnitY(),
                        z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d level = -std::sin(kAzimuthRad) * x + std::cos(kAzimuthRad) * z;
  View3 view;
  view.right = std::cos(kAzimuthRad) * x + std::sin(kAzimuthRad) * z;
  view.up = std::cos(kElevationRad) * above + std::sin(kElevationRad) * level;
  view.away = std::cos(kElevationRad) * level - std::sin(kElevationRad) * above;
  return view;
}

/// Axis-aligned box in cam with ends on ticks.
struct Room {
  Eigen::Vector3d low, high;
  double step_m = 1.0;
  int decimals = 0;
};

using Outline = std::array<Eigen::Vector3d, 4>;

struct BoardDrawn {
  std::size_t number;  ///< of the view, from 1
  Outline outline;     ///< of the printed squares, x_in_cam
  Eigen::Vector3d centre;
  double mean_error_px;
};

BoardDrawn board_drawn(const calib::Calibration& calibration, std::size_t i) {
  const calib::View& view = calibration.views[i];
  const auto [low_m, high_m] = target::printed_extent(calibration.board);
  BoardDrawn drawn;
  drawn.number = i + 1;
  drawn.outline = {view.cam_from_board * Eigen::Vector3d(low_m.x(), low_m.y(), 0),
                   view.cam_from_board * Eigen::Vector3d(high_m.x(), low_m.y(), 0),
                   view.cam_from_board * Eigen::Vector3d(high_m.x(), high_m.y(), 0),
                   view.cam_from_board * Eigen::Vector3d(low_m.x(), high_m.y(), 0)};
  drawn.centre = 0.25 * std::accumulate(drawn.outline.begin(), drawn.outline.end(), Eigen::Vector3d(0, 0, 0));
  drawn.mean_error_px = view.mean_error_px;
  return drawn;
}

std::vector<BoardDrawn> boards_of(const calib::Calibration& calibration) {
  std::vector<BoardDrawn> boards;
  for (std::size_t i = 0; i < calibration.views.size(); ++i) {
    if (!calibration.views[i].used) continue;
    BoardDrawn drawn = board_drawn(calibration, i);
    if (drawn.centre.allFinite()) boards.push_back(drawn);
  }
  return boards;
}

Room room_around(const std::vector<BoardDrawn>& boards, double width_mm) {
  Room room{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  for (const BoardDrawn& board : boards) {
    for (const auto& corner : board.outline) {
      room.low = room.low.cwiseMin(corner);
      room.high = room.high.cwiseMax(corner);
    }
  }
  const double span = std::max((room.high - room.low).maxCoeff(), 1e-6);
  constexpr double kMmPerStep = 28.0;
  const Ticks ticks = nice_ticks(0.0, span, std::max(2, static_cast<int>(width_mm / kMmPerStep)));
  room.step_m = ticks.values.size() > 1 ? ticks.values[1] - ticks.values[0] : span;
  room.decimals = ticks.decimals;
  for (int axis = 0; axis < 3; ++axis) {
    room.low[axis] = std::floor(room.low[axis] / room.step_m + 1e-9) * room.step_m;
    room.high[axis] = std::ceil(room.high[axis] / room.step_m - 1e-9) * room.step_m;
  }
  return room;
}

/// Scales and shifts the view so that the room fills the rectangle; returns the height it needs.
double fit(View3& view, const Room& room, const Point& top_left, double width_pt, double most_height_pt) {
  Point low = Point::Constant(1e300), high = Point::Constant(-1e300);
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d at;
    for (int axis = 0; axis < 3; ++axis)
      at[axis] = ((corner >> axis) & 1) != 0 ? room.high[axis] : room.low[axis];
    const Point on_paper = view.map(at);
    low = low.cwiseMin(on_paper);
    high = high.cwiseMax(on_paper);
  }
  const Point size = high - low;
  view.pt_per_m = std::min(width_pt / size.x(), most_height_pt / size.y());
  const double spare = width_pt - view.pt_per_m * size.x();
  view.origin_pt = top_left + Point(0.5 * spare, 0) - view.pt_per_m * low;
  return view.pt_per_m * size.y();
}

void line(Drawing& drawing, const View3& view, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
          Colour colour, double width_pt, Dash dash = {}) {
  drawing.items.push_back(Stroke{{view.map(a), view.map(b)}, colour, width_pt, std::move(dash)});
}

int steps(const Room& room, int axis) {
  return static_cast<int>(std::lround((room.high[axis] - room.low[axis]) / room.step_m));
}

/// Grid on the floor and on the two far walls.
void draw_room(Drawing& drawing, const View3& view, const Room& room) {
  struct Wall {
    int along, across, fixed;
    double at;
  };
  const std::array<Wall, 3> walls{
      {{0, 2, 1, room.high.y()}, {1, 2, 0, room.low.x()}, {0, 1, 2, room.high.z()}}};
  for (const Wall& wall : walls) {
    for (const auto& [running, other] :
         {std::pair{wall.along, wall.across}, std::pair{wall.across, wall.along}}) {
      for (int i = 0; i <= steps(room, running); ++i) {
        Eigen::Vector3d a = room.low, b = room.low;
        a[wall.fixed] = b[wall.fixed] = wall.at;
        a[running] = b[running] = room.low[running] + i * room.step_m;
        b[other] = room.high[other];
        line(drawing, view, a, b, kGridGrey, 0.4);
      }
    }
  }
}

/// One edge of the room that carries numbers.
struct Scale {
  int axis;
  Eigen::Vector3d edge;  ///< a point on the edge
  Point aside;           ///< from the edge to its numbers, on the paper
  Align align;
  bool upward;  ///< its text reads upwards
  int first;    ///< number of ticks to leave out at the low end, where another scale has its own
  std::string text;
};

void draw_scale(Drawing& drawing, const View3& view, const Room& room, const Scale& scale) {
  double widest = 0.0;
  Eigen::Vector3d at = scale.edge;
  for (int i = scale.first; i <= steps(room, scale.axis); ++i) {
    at[scale.axis] = room.low[scale.axis] + i * room.step_m;
    const std::string label = tick_text(at[scale.axis], room.decimals);
    widest = std::max(widest, text_width_pt(label, kTickTextPt));
    const Point tick = view.map(at);
    drawing.items.push_back(Stroke{{tick, tick + 0.4 * scale.aside}, kInk, 0.6, {}});
    drawing.items.push_back(Text{tick + scale.aside + Point(0, kCapHeight / 2 * kTickTextPt), label,
                                 kTickTextPt, kInk, scale.align});
  }
  at[scale.axis] = 0.5 * (room.low[scale.axis] + room.high[scale.axis]);
  const double sideways = (scale.align == Align::end ? -1.0 : 1.0) * (widest + 1.2 * kAxisTextPt);
  const double down = scale.upward ? 0.0 : 1.0 * kAxisTextPt;
  drawing.items.push_back(Text{view.map(at) + scale.aside + Point(sideways, down), scale.text, kAxisTextPt,
                               kInk, scale.upward ? Align::middle : scale.align, false, scale.upward});
}

void draw_scales(Drawing& drawing, const View3& view, const Room& room) {
  const Eigen::Vector3d low(room.low.x(), room.high.y(), room.low.z());
  const Eigen::Vector3d near_corner(room.high.x(), room.high.y(), room.low.z());
  draw_scale(drawing, view, room, {0, low, {-5.0, 5.0}, Align::end, false, 1, "x, right / m"});
  draw_scale(drawing, view, room, {2, near_corner, {5.0, 5.0}, Align::start, false, 0, "z, forward / m"});
  draw_scale(drawing, view, room, {1, low, {-6.0, 0.0}, Align::end, true, 0, "y, down / m"});
}

/// The pyramid the sensor sees, up to `depth_m`.
void draw_camera(Drawing& drawing, const View3& view, const Camera& camera, double depth_m,
                 double axis_end_m) {
  const auto corner = [&](double u, double v) -> Eigen::Vector3d {
    const auto ray = camera::unproject(camera, {u, v});
    // Beyond a distortion model's fold the pinhole's ray is near enough for a sketch of the camera.
    const Eigen::Vector2d on_plane =
        ray ? *ray : Eigen::Vector2d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy);
    return depth_m * on_plane.homogeneous();
  };
  const double last_u = camera.width - 1.0, last_v = camera.height - 1.0;
  const std::array<Eigen::Vector3d, 4> corners{corner(0, 0), corner(last_u, 0), corner(last_u, last_v),
                                               corner(0, last_v)};
  const Eigen::Vector3d apex = Eigen::Vector3d::Zero();
  line(drawing, view, apex, {0, 0, axis_end_m}, kMidGrey, 0.7, {6.0, 1.8, 1.2, 1.8});
  drawing.items.push_back(
      Fill{{view.map(corners[0]), view.map(corners[1]), view.map(corners[2]), view.map(corners[3])},
           with_alpha(kInk, 40)});
  for (std::size_t i = 0; i < corners.size(); ++i) {
    line(drawing, view, apex, corners[i], kInk, 1.0);
    line(drawing, view, corners[i], corners[(i + 1) % corners.size()], kInk, 1.0);
  }
  drawing.items.push_back(
      Text{view.map(apex) + Point(-4.0, kTickTextPt), "camera", kTickTextPt, kInk, Align::end});
}

void draw_board(Drawing& drawing, const View3& view, const BoardDrawn& board, Colour colour) {
  std::vector<Point> corners;
  for (const auto& corner : board.outline) corners.push_back(view.map(corner));
  drawing.items.push_back(Fill{corners, with_alpha(colour, 150)});
  const Colour edge{static_cast<std::uint8_t>(colour.r * 6 / 10),
                    static_cast<std::uint8_t>(colour.g * 6 / 10),
                    static_cast<std::uint8_t>(colour.b * 6 / 10)};
  corners.push_back(corners[0]);
  corners.push_back(corners[0] + 0.02 * (corners[1] - corners[0]));
  drawing.items.push_back(Stroke{corners, edge, 0.9, {}});
}

/// Numbers at the boards' centres, moved apart where they would cover each other; returns how many found a
/// place.
std::size_t draw_numbers(Drawing& drawing, const View3& view, const std::vector<BoardDrawn>& boards) {
  constexpr double kSizePt = 7.5;
  std::vector<Point> placed;
  for (const BoardDrawn& board : boards) {
    const std::string text = std::to_string(board.number);
    const Point clear(text_width_pt(text, kSizePt) + 5.0, 1.4 * kSizePt);
    Point at = view.map(board.centre);
    const auto taken = [&](const Point& there) {
      return std::any_of(placed.begin(), placed.end(), [&](const Point& other) {
        return ((there - other).cwiseAbs().array() < clear.array()).all();
      });
    };
    // A spiral of tries around the centre. Among very many boards a number without a free place is left out.
    constexpr int kTries = 30;
    for (int attempt = 1; attempt <= kTries && taken(at); ++attempt) {
      const double angle = 2.4 * attempt, radius = 1.8 * kSizePt * std::sqrt(attempt / 6.0);
      at = view.map(board.centre) + radius * Point(std::cos(angle), std::sin(angle));
    }
    if (taken(at)) continue;
    placed.push_back(at);
    if ((at - view.map(board.centre)).norm() > kSizePt) {
      drawing.items.push_back(Stroke{{view.map(board.centre), at}, kInk, 0.4, {}});
    }
    add_label(drawing, at, text, kSizePt, kInk, with_alpha(kWhite, 215));
  }
  return placed.size();
}

base::CsvTable poses_table(const calib::Calibration& calibration, const std::vector<BoardDrawn>& boards) {
  base::CsvTable table;
  table.columns = {"view_number",    "image",          "x_in_cam_m",     "y_in_cam_m",   "z_in_cam_m",
                   "rotation_x_deg", "rotation_y_deg", "rotation_z_deg", "mean_error_px"};
  for (const BoardDrawn& board : boards) {
    const calib::View& view = calibration.views[board.number - 1];
    const Eigen::Vector3d& at = view.cam_from_board.translation;
    const Eigen::Vector3d turn = geom::rotation_vector(view.cam_from_board.rotation);
    table.rows.push_back({std::to_string(board.number), view.image, cell(at.x(), 5), cell(at.y(), 5),
                          cell(at.z(), 5), cell(geom::rad_to_deg(turn.x()), 3),
                          cell(geom::rad_to_deg(turn.y()), 3), cell(geom::rad_to_deg(turn.z()), 3),
                          cell(view.mean_error_px, 4)});
  }
  return table;
}

/// Boards from the farthest to the nearest, each tied to its place on the floor by a plumb line.
void draw_boards(Drawing& drawing, const View3& view, const Room& room, std::vector<BoardDrawn> boards,
                 const Axis& scale) {
  std::stable_sort(boards.begin(), boards.end(), [&](const BoardDrawn& a, const BoardDrawn& b) {
    return view.away.dot(a.centre) > view.away.dot(b.centre);
  });
  for (const BoardDrawn& board : boards) {
    Eigen::Vector3d foot = board.centre;
    foot.y() = room.high.y();
    line(drawing, view, board.centre, foot, kMidGrey, 0.4, {1.2, 1.2});
    add_marker(drawing, Marker::circle, view.map(foot), 2.0, kMidGrey);
  }
  for (const BoardDrawn& board : boards) {
    draw_board(drawing, view, board, viridis((board.mean_error_px - scale.low) / (scale.high - scale.low)));
  }
}

std::string poses_caption(std::size_t boards, std::size_t numbered) {
  const auto degrees = [](double angle_rad) {
    return base::format_fixed(geom::rad_to_deg(angle_rad), 0) + "\u00b0";
  };
  std::string caption =
      "The " + count_of(boards, "board") +
      " used, in the camera's frame (x right, y down, z forward), coloured by their mean reprojection "
      "error. Orthographic view from behind the camera, " +
      degrees(kAzimuthRad) + " from its axis and " + degrees(kElevationRad) +
      " from above; dotted plumb lines end on the floor of the box.";
  if (numbered < boards) caption += " Where boards crowd, view numbers are left out; the data table has all.";
  return caption;
}

}  // namespace

Result<Figure> board_poses(const calib::Calibration& calibration, const FigureOptions& options) {
  const std::string name = "board_poses";
  const std::vector<BoardDrawn> boards = boards_of(calibration);
  if (boards.empty()) return nothing_to_draw(name, "a calibration without a used view", "at least one");

  constexpr double kMostRoomMm = 95.0, kScalesPt = 42.0, kFootPt = 22.0, kBarMm = 60.0;
  constexpr double kCameraShare = 0.1;  // of the farthest board: a sketch, not the real size
  FURROW_TRY(Drawing drawing, paper(options, kMostRoomMm));
  const Room room = room_around(boards, options.width_mm);
  View3 view = standard_view();
  const double top = kMarginPt + kTickTextPt;
  const double room_height = fit(view, room, {kMarginPt + kScalesPt, top},
                                 drawing.width_pt - 2 * (kMarginPt + kScalesPt), drawing.height_pt);
  std::vector<double> errors;
  errors.reserve(boards.size());
  for (const BoardDrawn& board : boards) errors.push_back(board.mean_error_px);
  const Axis scale = axis_over("mean reprojection error / px", errors, 5, true);

  draw_room(drawing, view, room);
  draw_scales(drawing, view, room);
  draw_boards(drawing, view, room, boards, scale);
  draw_camera(drawing, view, calibration.camera, kCameraShare * room.high.z(), room.high.z());
  const std::size_t numbered = draw_numbers(drawing, view, boards);
  const double bar_top = top + room_height + kFootPt, bar_width = kBarMm * kPointsPerMm;
  const double bar_height =
      draw_colour_bar(drawing, {0.5 * (drawing.width_pt - bar_width), bar_top}, bar_width, scale);
  drawing.height_pt = bar_top + bar_height + kMarginPt;
  return finish(name, poses_caption(boards.size(), numbered), drawing, poses_table(calibration, boards),
                options);
}

}  // namespace furrow::figures
