#include "furrow/sim/simulate.h"

#include <atomic>
#include <mutex>
#include <optional>

#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
#include "furrow/base/text.h"
#include "furrow/base/time.h"
#include "furrow/camera/model_files.h"
#include "furrow/geo/geodesy.h"
#include "furrow/geom/angles.h"
#include "furrow/sim/world.h"
#include "sim/airdata.h"
#include "sim/board.h"

namespace furrow::sim {
namespace {

namespace fs = std::filesystem;
using base::format_double;
using base::format_fixed;
using geom::rad_to_deg;

std::string number_name(const char* stem, int number, int digits, const char* extension) {
  const std::string text = std::to_string(number);
  const int zeros = std::max(0, digits - static_cast<int>(text.size()));
  return stem + std::string(static_cast<std::size_t>(zeros), '0') + text + extension;
}

std::string board_name(int index) {
  return number_name("board-", index + 1, 2, ".png");
}

std::string truth_csv(const Scene& scene, const std::vector<ShotTruth>& shots) {
  std::string csv =
      "shot_id,image,t_log_s,t_utc,latitude_deg,longitude_deg,east_m,north_m,up_m,height_above_ground_m,"
      "height_above_canopy_m,pitch_deg,roll_deg,yaw_deg,heading_deg,cross_track_m,nearest_row,along_row_m,"
      "row_spacing_m,half_width_m,row_height_m,foliage_bottom_m,base_half_width_m\n";
  const Flight& flight = scene.flight;
  const Field& f = scene.field;
  const geo::LocalFrame world({flight.latitude_deg, flight.longitude_deg, flight.height_ellipsoid_m});
  const base::Nanoseconds start_ns = base::parse_date_time(flight.start_utc).value_or(0);
  for (const ShotTruth& shot : shots) {
    const geo::Geodetic place = world.geodetic(shot.x_in_world);
    csv += shot.shot_id + ",frames/" + shot.shot_id + ".jpg," + format_fixed(shot.t_log_s, 4) + "," +
           base::format_utc(start_ns + base::seconds_to_ns(shot.t_log_s)) + "," +
           format_fixed(place.latitude_deg, 9) + "," + format_fixed(place.longitude_deg, 9);
    for (double metres : {shot.x_in_world.x(), shot.x_in_world.y(), shot.x_in_world.z(),
                          shot.height_above_ground_m, shot.height_above_canopy_m}) {
      csv += "," + format_fixed(metres, 5);
    }
    for (double degrees : {rad_to_deg(shot.attitude.pitch_rad), rad_to_deg(shot.attitude.roll_rad),
                           rad_to_deg(shot.attitude.yaw_rad), shot.heading_deg}) {
      csv += "," + format_fixed(degrees, 5);
    }
    csv += "," + format_fixed(shot.cross_track_m, 5) + "," + std::to_string(shot.nearest_row) + "," +
           format_fixed(shot.along_row_m, 5);
    for (double metres :
         {f.spacing_m, f.half_width_m, f.row_height_m, f.foliage_bottom_m, f.base_half_width_m}) {
      csv += "," + format_double(metres);
    }
    csv += "\n";
  }
  return csv;
}

std::string boards_csv(const Scene& scene, const std::vector<Rigid3>& boards) {
  std::string csv = "image,corner,u_px,v_px\n";
  const auto corners = target::corners_in_board(printed_board(scene.boards));
  for (std::size_t i = 0; i < boards.size(); ++i) {
    for (std::size_t corner = 0; corner < corners.size(); ++corner) {
      const auto px = camera::project(scene.camera, boards[i] * corners[corner]);
      if (!px) continue;
      csv += "boards/" + board_name(static_cast<int>(i)) + "," + std::to_string(corner) + "," +
             format_fixed(px->x(), 4) + "," + format_fixed(px->y(), 4) + "\n";
    }
  }
  return csv;
}

std::string rows_csv(const Scene& scene, const std::vector<ShotTruth>& shots) {
  std::vector<std::string> parts(shots.size());
  base::parallel_for(shots.size(), 0, [&](std::size_t i) {
    for (const TrueRow& row : true_rows(scene, shots[i])) {
      for (const RowCrossing& at : row.crossings) {
        parts[i] += shots[i].shot_id + "," + std::to_string(row.index) + "," + std::to_string(row.row) + "," +
                    format_fixed(at.v_px, 0) + "," + format_fixed(at.u_px, 3) + "," +
                    format_fixed(at.left_u_px, 3) + "," + format_fixed(at.right_u_px, 3) + "\n";
      }
    }
  });
  std::string csv = "shot_id,index,row,v_px,u_px,left_u_px,right_u_px\n";
  for (const std::string& part : parts) csv += part;
  return csv;
}

std::string board_yaml(const Boards& b) {
  const target::BoardSpec board = printed_board(b);
  if (b.type == target::BoardKind::charuco) {
    return "type: charuco\nsquares: [" + std::to_string(b.corners_x + 1) + ", " +
           std::to_string(b.corners_y + 1) + "]\nsquare_m: " + format_double(b.square_m) +
           "\nmarker_m: " + format_double(b.marker_m) + "\ndictionary: " + board.dictionary + "\n";
  }
  if (b.type == target::BoardKind::aprilgrid) {
    return "target_type: aprilgrid\ntagCols: " + std::to_string(b.corners_x / 2) +
           "\ntagRows: " + std::to_string(b.corners_y / 2) + "\ntagSize: " + format_double(b.square_m) +
           "\ntagSpacing: " + format_double(b.gap_m / b.square_m) + "\n";
  }
  return "type: checkerboard\ncorners: [" + std::to_string(b.corners_x) + ", " + std::to_string(b.corners_y) +
         "]\nsquare_m: " + format_double(b.square_m) + "\n";
}

/// What the farm would write down: its numbers are the scene's, the spacing known to 1 %.
std::string project_yaml(const Scene& scene) {
  constexpr double kSpacingKnown = 0.01;
  const Field& f = scene.field;
  const std::string camera = scene.boards.count > 0
                                 ? "{ calibrate: { images: boards/*.png, target: board.yaml } }"
                                 : "{ model: camera_true.yaml }";
  return "name: " + scene.name + "\ncamera: " + camera +
         "\nshots: { images: frames/*.jpg }\ntelemetry: { file: airdata.csv }\nrows: { spacing_m: " +
         format_double(f.spacing_m) + ", spacing_sigma_m: " + format_double(kSpacingKnown * f.spacing_m) +
         ", half_width_m: " + format_double(f.half_width_m) + ", height_m: " + format_double(f.row_height_m) +
         " }\n";
}

/// Writes the files that need no rendering.
Status write_texts(const Scene& scene, const fs::path& folder, const std::vector<ShotTruth>& shots) {
  FURROW_DO(base::write_file(folder / "scene.yaml", to_yaml(scene)));
  FURROW_DO(base::write_file(folder / "truth.csv", truth_csv(scene, shots)));
  FURROW_DO(base::write_file(folder / "rows_truth.csv", rows_csv(scene, shots)));
  FURROW_DO(base::write_file(folder / "airdata.csv", airdata_csv(scene)));
  FURROW_DO(base::write_file(folder / "camera_true.yaml", camera::to_opencv_yaml(scene.camera)));
  FURROW_DO(base::write_file(folder / "project.yaml", project_yaml(scene)));
  if (scene.boards.count == 0) return Done{};
  FURROW_DO(base::write_file(folder / "board.yaml", board_yaml(scene.boards)));
  return base::write_file(folder / "boards_truth.csv", boards_csv(scene, true_boards(scene)));
}

}  // namespace

Result<Simulated> simulate(const Scene& scene, const fs::path& folder, const base::Progress& progress,
                           const SimulateOptions& options) {
  FURROW_DO(validate(scene));
  const std::vector<ShotTruth> shots = true_shots(scene);
  FURROW_DO(write_texts(scene, folder, shots));

  const Renderer renderer(scene);
  const auto boards = static_cast<std::size_t>(scene.boards.count);
  const std::size_t total = boards + shots.size();
  std::mutex mutex;
  std::size_t done = 0;
  std::optional<Error> fault;
  base::parallel_for(total, options.threads, [&](std::size_t i) {
    {
      const std::lock_guard lock(mutex);
      if (fault) return;
    }
    const bool board = i < boards;
    const Image picture = board ? renderer.board(static_cast<int>(i)) : renderer.shot(i - boards);
    const fs::path file = board ? folder / "boards" / board_name(static_cast<int>(i))
                                : folder / "frames" / (shots[i - boards].shot_id + ".jpg");
    const Status status = image::write_image(file, picture, scene.pictures.jpeg_quality);
    const std::lock_guard lock(mutex);
    if (!status.ok() && !fault) fault = status.error();
    base::report(progress, "rendering", ++done, total);
  });
  if (fault) return *fault;
  return Simulated{folder, scene.boards.count, static_cast<int>(shots.size())};
}

}  // namespace furrow::sim
