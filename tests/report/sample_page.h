#pragma once
#include "figures/samples.h"
#include "furrow/base/file.h"
#include "furrow/report/page.h"

namespace furrow::samples {

/// A report as a run makes it: findings of all three kinds, charts, a photograph, short and long tables.
inline report::Page page() {
  const auto records = flight();
  const auto board_views = calibration();
  const auto rows = field(640, 360, 45.0);
  report::Page page;
  page.title = "Vineyard, three heights";
  page.subtitle = "48 shots, 14 pictures of the board, one AirData log";
  page.summary = {"A height above the canopy for 43 of 48 shots, 0.08 m one sigma on average.",
                  "The log reads 0.12 m too high by the end of the flight."};
  report::Section camera;
  camera.title = "Camera";
  camera.paragraphs = {"Calibrated from 12 of 14 pictures at 1280x720."};
  camera.findings = {{"calibration.rms", "Reprojection error", audit::Verdict::pass, "0.26 px",
                      "at most 1 px", "12 views, 648 corners."}};
  camera.figures = {figures::reprojection_bars(board_views).value(),
                    figures::board_poses(board_views).value()};
  report::Section heights;
  heights.title = "Heights";
  heights.findings = {{"heights.log", "Log against pictures", audit::Verdict::fail, "0.31 m",
                       "at most 0.25 m", "Worst in shots 40 to 48."},
                      {"heights.pitch", "Gimbal pitch", audit::Verdict::not_assessed, "", "at most 1.5 deg",
                       "Not assessed, because the log has no pitch."}};
  heights.figures = {figures::heights_over_shots(records, 1.7).value(),
                     figures::pitch_over_shots(records).value(),
                     figures::row_overlay(rows.picture, rows.lines, "shot-1003").value(),
                     figures::cross_track_over_shots(records, {figures::kOneColumnMm, 200.0}).value()};
  heights.tables = {{"Agreement by height",
                     {"",
                      {"flight", "mean / m", "error / m", "sd / m"},
                      {{"3 m", "3.02", "0.02", "0.05"}, {"4 m", "4.01", "0.01", "0.07"}},
                      {},
                      {}},
                     false},
                    {"All shots", heights.figures[0].data, true}};
  page.sections = {camera, heights};
  page.provenance = {{"furrow", "0.1.0"}, {"airdata.csv", "sha256 " + base::sha256_hex("airdata")}};
  return page;
}

}  // namespace furrow::samples
