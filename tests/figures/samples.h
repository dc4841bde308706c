#pragma once
// Plausible inputs for figures and reports, the same in every run.
#include <cmath>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "furrow/altitude/birds_eye.h"
#include "furrow/altitude/plan.h"
#include "furrow/audit/budget.h"
#include "furrow/audit/fusion.h"
#include "furrow/audit/shot_record.h"
#include "furrow/base/random.h"
#include "furrow/calib/calibrate.h"
#include "furrow/image/image.h"
#include "furrow/rows/row_lines.h"

namespace furrow::samples {

/// A flight like the thesis's: 3, 4 and 5 m above ground over rows of 1.7 m, a log with a slow drift, VPS
/// that jumps between canopy and soil, shots without rows, and a thesis formula with wild values.
inline std::vector<audit::ShotRecord> flight(std::size_t shots = 48) {
  base::Random random(7);
  std::vector<audit::ShotRecord> records;
  for (std::size_t i = 0; i < shots; ++i) {
    audit::ShotRecord r;
    r.shot_id = "shot-" + std::to_string(1000 + i);
    r.image = "frames/" + r.shot_id + ".jpg";
    const double share = static_cast<double>(i) / static_cast<double>(shots);
    const double ground_m = 3.0 + std::floor(3.0 * share) + 0.05 * std::sin(0.4 * static_cast<double>(i));
    r.truth_above_canopy_m = ground_m - 1.7;
    r.height_takeoff_m = std::round((ground_m + 0.25 * share + random.normal(0.0, 0.05)) * 10.0) / 10.0;
    r.height_vps_m = i % 5 < 2 ? ground_m - 1.7 + random.normal(0, 0.05) : ground_m + random.normal(0, 0.05);
    r.pitch_log_deg = (i < shots / 2 ? -12.4 : -13.8) + random.normal(0.0, 0.1);
    r.rows_confidence = 0.9;
    r.rows_used = 5;
    r.status = "ok";
    if (i % 17 == 11 || i % 17 == 12) {
      r.status = "no_rows";
      r.reason = "fewer than two rows stand out from the soil";
      r.rows_used = 0;
    } else {
      const double sigma = 0.06 + 0.03 * (ground_m - 3.0);
      r.above_canopy_refined_m = {r.truth_above_canopy_m + random.normal(0.0, sigma), sigma, 120};
      r.above_ground_refined_m = {r.above_canopy_refined_m.value + 1.7, std::hypot(sigma, 0.02), 120};
      r.above_canopy_thesis_m.value = r.truth_above_canopy_m * (1.0 + random.normal(0.0, 0.35));
      if (i % 13 == 5) r.above_canopy_thesis_m.value = 25.0;
      r.above_canopy_spacing_m = {r.truth_above_canopy_m + random.normal(0.0, 2 * sigma), 2 * sigma, 5};
      r.pitch_deg = {r.pitch_log_deg + 0.8 + random.normal(0.0, 0.2), 0.2, 120};
      r.cross_track_m = {0.3 * std::sin(0.3 * static_cast<double>(i)) + random.normal(0.0, 0.03), 0.04, 120};
      r.heading_error_deg = {random.normal(0.0, 1.0), 0.4, 120};
    }
    records.push_back(r);
  }
  return records;
}

/// The same flight fused, two seconds from shot to shot.
inline audit::FlightFusion fusion(const std::vector<audit::ShotRecord>& records) {
  audit::FlightFusion made;
  for (std::size_t i = 0; i < records.size(); ++i) {
    altitude::HeightSample sample;
    sample.t_s = 2.0 * static_cast<double>(i);
    sample.vision_above_canopy_m = records[i].above_canopy_refined_m;
    if (i % 19 == 7) sample.vision_above_canopy_m.value += 1.0;
    sample.baro_height_m = records[i].height_takeoff_m;
    sample.vps_height_m = records[i].height_vps_m;
    made.samples.push_back(sample);
    made.shots.push_back(i);
  }
  altitude::FuseOptions options;
  options.row_height_m = {1.7, 0.05, 1};
  made.fused = altitude::fuse(made.samples, options).value();
  return made;
}

/// Sigmas of that flight by cause.
inline std::vector<audit::ShotBudget> budgets(const std::vector<audit::ShotRecord>& records) {
  std::vector<audit::ShotBudget> made;
  for (const audit::ShotRecord& r : records) {
    const double sigma = r.above_canopy_refined_m.sigma;
    made.push_back({r.shot_id,
                    r.above_canopy_refined_m,
                    {{"picture", 0.3 * sigma},
                     {"plants", 0.7 * sigma},
                     {"spacing", 0.5 * sigma},
                     {"half_width", 0.2 * sigma},
                     {"pitch", 0.3 * sigma},
                     {"distortion", -0.1 * sigma},
                     {"other", 0.2 * sigma}}});
  }
  return made;
}

/// Plans from -10 to -90 degrees, and from half to double the height.
inline std::vector<altitude::PlannedShot> plans() {
  std::vector<altitude::PlannedShot> made;
  for (int i = 2; i <= 18; ++i) {
    altitude::PlannedShot plan;
    plan.pose = {0.5 * i, -0.0873 * i, 0.0, 0.0};
    const double sigma = 0.02 * 0.5 * i * (1.0 + 4.0 / i);
    plan.height_above_canopy_m = {0.5 * i, sigma, 100};
    plan.height_budget = {{"picture", 0.8 * sigma}, {"spacing", 0.6 * sigma}};
    made.push_back(plan);
  }
  return made;
}

/// Boards half a metre to two metres before a camera like the thesis's; two views are not used.
inline calib::Calibration calibration(std::size_t views = 14) {
  base::Random random(11);
  calib::Calibration c;
  c.camera.model = camera::CameraModel::opencv5;
  c.camera.width = 1280;
  c.camera.height = 720;
  c.camera.fx = 874.33;
  c.camera.fy = 872.39;
  c.camera.cx = 640.49;
  c.camera.cy = 360.81;
  c.camera.distortion = {-0.01, 0.02, 0.0005, -0.0003, 0.0};
  c.board = {"board", 9, 6, 0.038, 1.0};
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < views; ++i) {
    calib::View view;
    view.image = "boards/left" + std::to_string(i + 1) + ".jpg";
    view.used = i != 4 && i != 9;
    if (view.used) {
      const Eigen::Vector3d turn(random.normal(0, 0.35), random.normal(0, 0.35), random.normal(0, 0.15));
      view.cam_from_board.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
      const double z = random.uniform(0.5, 1.6);
      view.cam_from_board.translation = {-0.15 + 0.3 * z * random.normal(0, 0.6),
                                         -0.1 + 0.2 * z * random.normal(0, 0.6), z};
      view.mean_error_px = random.uniform(0.11, 0.3);
      view.rms_px = 1.15 * view.mean_error_px;
      sum += view.mean_error_px;
      squares += view.rms_px * view.rms_px;
      for (int k = 0; k < 54; ++k) {
        view.observed_px.push_back({random.uniform(100, 1180), random.uniform(60, 660)});
        view.residual_px.push_back({random.normal(0, 0.15), random.normal(0, 0.15)});
      }
    } else {
      view.mean_error_px = view.rms_px = std::nan("");
      view.reason = "no board of 9x6 inner corners found";
    }
    c.views.push_back(view);
  }
  const auto used = static_cast<double>(views - (views > 9 ? 2 : views > 4 ? 1 : 0));
  c.mean_error_px = sum / used;
  c.rms_px = std::sqrt(squares / used);
  c.corners = static_cast<int>(used) * 54;
  c.termination = "Function tolerance reached.";
  c.iterations = 9;
  c.usable = true;
  return c;
}

/// A field of dark green stripes that meet at the horizon, and the rows in it.
struct FieldPicture {
  Image picture;
  rows::RowLines lines;
};

inline FieldPicture field(int width = 1280, int height = 720, double horizon_v = 90.0) {
  base::Random random(3);
  FieldPicture made;
  made.picture = image::make_image(width, height, 3);
  const double vanishing_u = 0.53 * width, spacing_at_foot = 0.32 * width;
  for (int v = 0; v < height; ++v) {
    const double share = (v - horizon_v) / (height - horizon_v);
    for (int u = 0; u < width; ++u) {
      std::uint8_t* px = made.picture.at(u, v);
      const auto noise = static_cast<int>(random.below(28));
      const auto set = [&](int r, int g, int b) {
        px[0] = static_cast<std::uint8_t>(r + noise);
        px[1] = static_cast<std::uint8_t>(g + noise);
        px[2] = static_cast<std::uint8_t>(b + noise);
      };
      if (share <= 0.0) {
        set(140, 175, 215);
        continue;
      }
      const double place = (u - vanishing_u) / (spacing_at_foot * share);
      const double off = std::abs(place - std::round(place));
      if (off < 0.2)
        set(45, 105, 35);
      else
        set(150, 120, 85);
    }
  }
  made.lines.method = "field";
  made.lines.width = width;
  made.lines.height = height;
  made.lines.vanishing_point_px = Eigen::Vector2d(vanishing_u, horizon_v);
  made.lines.confidence = 0.94;
  made.lines.status = "ok";
  for (int index = -3; index <= 3; ++index) {
    rows::RowLine row;
    row.index = index;
    row.seen = std::abs(index) < 3;
    for (double v = horizon_v + 60.0; v < height; v += 10.0) {
      const double share = (v - horizon_v) / (height - horizon_v);
      rows::RowSample sample;
      sample.centre_px = {vanishing_u + index * spacing_at_foot * share, v};
      sample.sigma_px = 1.5;
      const double half = 0.2 * spacing_at_foot * share;
      if (row.seen && v > horizon_v + 150.0) {
        sample.left_u_px = sample.centre_px.x() - half;
        sample.right_u_px = sample.centre_px.x() + half;
        sample.edge_sigma_px = 3.0;
      }
      if (sample.centre_px.x() > -0.2 * width && sample.centre_px.x() < 1.2 * width)
        row.samples.push_back(sample);
    }
    made.lines.rows.push_back(row);
  }
  return made;
}

/// Twelve by twenty metres of striped ground with the camera at the near border.
inline altitude::BirdsEye from_above() {
  altitude::BirdsEye view;
  view.px_per_m = 20.0;
  view.picture = image::make_image(240, 400, 3);
  for (std::size_t i = 0; i < view.picture.data.size(); ++i)
    view.picture.data[i] = static_cast<std::uint8_t>(60 + i / 3 % 240 % 60 * 2);
  view.ahead_m = 21.0;
  view.left_m = 6.0;
  view.spacing_m = 3.0;
  view.half_width_m = 0.6;
  view.cross_track_m = 0.3;
  altitude::GroundRow row;
  for (int i = 0; i < 20; ++i) row.left_m.push_back({20.0 - i, 0.3 + 0.02 * (i % 5)});
  view.rows.push_back(row);
  return view;
}

}  // namespace furrow::samples
