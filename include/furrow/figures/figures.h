#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "furrow/audit/shot_record.h"
#include "furrow/base/csv.h"
#include "furrow/calib/calibrate.h"
#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"

namespace furrow::figures {

/// A finished figure: the same drawing as PNG and SVG, the numbers drawn, and a caption that says what they
/// are.
struct Figure {
  std::string name;  ///< file stem, snake_case
  std::string caption;
  std::string png;                  ///< bytes
  std::string svg;                  ///< text
  base::CsvTable data;              ///< what was drawn; may be empty for pictures
  int width_px = 0, height_px = 0;  ///< of the PNG
};

/// Print widths of a one- and a two-column figure.
inline constexpr double kOneColumnMm = 85.0;
inline constexpr double kTwoColumnsMm = 174.0;

struct FigureOptions {
  double width_mm = kTwoColumnsMm;
  double dpi = 200.0;  ///< of the PNG
};

/// Heights over the shots: refined above ground with its sigma band, thesis, log above take-off, VPS, and
/// truth where there is one. `row_height_m` takes canopy heights to the ground; with NaN, heights above the
/// canopy are drawn and the log's are left out.
Result<Figure> heights_over_shots(const std::vector<audit::ShotRecord>& records, double row_height_m,
                                  const FigureOptions& options = {});

/// Gimbal pitch of the log and refined pitch with sigma over the shots.
Result<Figure> pitch_over_shots(const std::vector<audit::ShotRecord>& records,
                                const FigureOptions& options = {});

/// Cross-track offset with sigma over the shots.
Result<Figure> cross_track_over_shots(const std::vector<audit::ShotRecord>& records,
                                      const FigureOptions& options = {});

/// One bar per view of the mean reprojection error, the overall mean as a line (thesis, figure of section 2).
Result<Figure> reprojection_bars(const calib::Calibration& calibration, const FigureOptions& options = {});

/// Board poses in the camera's frame, in 3-D (thesis, camera-centric view).
Result<Figure> board_poses(const calib::Calibration& calibration, const FigureOptions& options = {});

/// The picture with its rows (centre line, edges, index), horizon or vanishing point, and confidence.
Result<Figure> row_overlay(const Image& picture, const rows::RowLines& lines, const std::string& shot_id,
                           const FigureOptions& options = {});

/// Writes name.png, name.svg and, when there are data, name.csv into `folder`, atomically.
Status write_figure(const std::filesystem::path& folder, const Figure& figure);

}  // namespace furrow::figures
