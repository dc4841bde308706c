// Every figure, whole: it comes out as PNG and SVG, says what it shows, and takes any input without falling
// over.
#include "furrow/figures/figures.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>

#include "figures/samples.h"
#include "furrow/base/file.h"
#include "furrow/base/parallel.h"
#include "furrow/figures/camera_maps.h"
#include "furrow/figures/comparison.h"
#include "furrow/figures/following.h"
#include "furrow/figures/pictures.h"
#include "furrow/figures/sources.h"
#include "furrow/figures/stacked.h"

namespace furrow::figures {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

/// With FURROW_FIGURES_OUT set, the figures of these tests are left there to be looked at.
void keep(Figure figure, const std::string& suffix = "") {
  const char* folder = std::getenv("FURROW_FIGURES_OUT");
  if (folder == nullptr) return;
  figure.name += suffix;
  ASSERT_TRUE(write_figure(folder, figure).ok());
}

/// A minute of following with a gap, thinned as a run keeps it.
FollowingCurves following_curves() {
  FollowingCurves curves;
  for (int i = 0; i < 240; ++i) {
    const double t = 0.25 * i, offset = 0.3 * std::sin(0.4 * t);
    const bool is_hold = i > 150 && i < 170;
    curves.t_s.push_back(t);
    curves.measured.push_back(is_hold ? kNaN : offset + 0.03 * std::sin(17.0 * i));
    curves.filtered.push_back(is_hold ? kNaN : offset);
    curves.filtered_sigma.push_back(is_hold ? kNaN : 0.04);
    curves.thesis_steer.push_back(is_hold ? kNaN : 1.4 * offset + 0.1);
    curves.right_mps.push_back(is_hold ? kNaN : 0.5 * offset);
    curves.is_hold.push_back(is_hold);
  }
  return curves;
}

std::vector<DeviationByHand> flights_by_hand() {
  DeviationByHand low{"3 m", "m", {}, {}, {}, {}}, high{"4 m <second>", "m", {"a"}, {0.2}, {kNaN}, {kInf}};
  for (int i = 0; i < 30; ++i) {
    low.pictures.push_back("shot-" + std::to_string(i));
    low.by_hand.push_back(0.1 * std::sin(0.3 * i));
    low.thesis.push_back(i == 7 ? kNaN : 0.1 * std::sin(0.3 * i) + 0.05);
    low.filtered.push_back(0.1 * std::sin(0.3 * i) - 0.01);
  }
  return {low, high};
}

/// The views of the sample calibration that the figures of corners show: a used one with a corner left out,
/// part of its board seen, and one without a board.
struct CornerSample {
  Image picture = samples::field(320, 180, 20.0).picture;
  calib::Calibration calibration = samples::calibration();
  calib::TellingViews telling;

  CornerSample() {
    calib::View& view = calibration.views[2];
    view.left_out.assign(view.residual_px.size(), false);
    view.left_out[4] = true;
    view.residual_px[6].x() = kNaN;
    for (int i = 0; i < 54; ++i) view.corner_ids.push_back(i + 10);
    telling.residual_px = 0.35;
    telling.spacing_px = 60.0;
    telling.views.resize(2);
    telling.views[0] = {2,
                        "lowest RMS",
                        0,
                        0,
                        1280,
                        720,
                        {{300.0, 200.0}, {340.0, 205.0}, {380.0, 210.0}},
                        {{300.0, 200.0}, {300.0, 240.0}}};
    telling.views[1] = {4, "not used", 0, 0, 1280, 720, {}, {}};
  }
};

struct Case {
  std::string name;
  std::function<Result<Figure>(const FigureOptions&)> draw;
  bool has_data = true;
};

std::vector<Case> all_figures() {
  const auto records = samples::flight();
  const auto calibration = samples::calibration();
  const auto fusion = samples::fusion(records);
  const auto budgets = samples::budgets(records);
  const auto plans = samples::plans();
  const auto field = samples::field(640, 360, 45.0);
  const std::vector<NamedPicture> steps{{"green mask", field.picture}, {"otsu <1>", field.picture}};
  return {
      {"heights_over_shots", [=](const auto& o) { return heights_over_shots(records, 1.7, o); }},
      {"pitch_over_shots", [=](const auto& o) { return pitch_over_shots(records, o); }},
      {"cross_track_over_shots", [=](const auto& o) { return cross_track_over_shots(records, o); }},
      {"reprojection_bars", [=](const auto& o) { return reprojection_bars(calibration, o); }},
      {"board_poses", [=](const auto& o) { return board_poses(calibration, o); }},
      {"rows_shot-1003",
       [=](const auto& o) { return row_overlay(field.picture, field.lines, "shot-1003", o); }},
      {"height_agreement_log", [=](const auto& o) { return agreement(heights_against_log(records), o); }},
      {"height_agreement_truth_errors",
       [=](const auto& o) { return error_histogram(heights_against_truth(records), o); }},
      {"heights_by_leg", [=](const auto& o) { return heights_by_leg(records, 1.7, o); }},
      {"log_over_shots", [=](const auto& o) { return log_heights_over_shots(records, false, o); }},
      {"log_and_vps_over_shots", [=](const auto& o) { return log_heights_over_shots(records, true, o); }},
      {"fusion_over_shots", [=](const auto& o) { return fusion_over_shots(records, fusion, o); }},
      {"budget_over_shots", [=](const auto& o) { return budget_over_shots(budgets, o); }},
      {"plan_over_pitch", [=](const auto& o) { return plan_over_pitch(plans, o); }},
      {"plan_over_height", [=](const auto& o) { return plan_over_height(plans, o); }},
      {"residual_map", [=](const auto& o) { return residual_map(calibration, o); }},
      {"corners_view_3",
       [](const auto& o) {
         const CornerSample sample;
         return corners_overlay(sample.picture, sample.calibration, sample.telling, 0, o);
       }},
      {"corners_view_5",
       [](const auto& o) {
         const CornerSample sample;
         return corners_overlay(sample.picture, sample.calibration, sample.telling, 1, o);
       },
       false},
      {"residual_errors", [=](const auto& o) { return residual_histogram(calibration, o); }},
      {"coverage_map", [=](const auto& o) { return coverage_map(calibration, o); }},
      {"distortion_curve",
       [=](const auto& o) { return distortion_curve(camera::distortion_curve(calibration.camera), o); }},
      {"sigma_map",
       [=](const auto& o) {
         PictureMap map{"sigma_map", "projection sigma / px", "Sigma over the picture.", 12, 8, 1280, 720,
                        {}};
         for (int i = 0; i < 96; ++i) map.values.push_back(i == 0 ? kNaN : 0.1 + 0.01 * (i % 12));
         return picture_map(map, o);
       }},
      {"birds_eye_shot-1003",
       [=](const auto& o) { return birds_eye(samples::from_above(), "shot-1003", o); }},
      {"following_over_time", [](const auto& o) { return following_over_time(following_curves(), o); }},
      {"deviation_by_hand", [](const auto& o) { return deviation_by_hand(flights_by_hand(), o); }},
      {"following_shot-1003",
       [=](const auto& o) {
         return following_overlay(field.picture, {38.0, 22.0}, "shot-1003", o);
       }},
      {"steps", [=](const auto& o) { return contact_sheet("steps", "Steps of row detection.", steps, o); },
       false},
  };
}

std::size_t colours_in(const Image& picture) {
  std::set<std::uint32_t> seen;
  for (std::size_t i = 0; i + 2 < picture.data.size(); i += 3) {
    seen.insert(picture.data[i] | picture.data[i + 1] * 256u | picture.data[i + 2] * 65536u);
  }
  return seen.size();
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The SVG without its embedded photographs, whose base64 may spell anything.
std::string vector_part(std::string svg) {
  for (std::size_t at = 0; (at = svg.find("base64,", at)) != std::string::npos;)
    svg.erase(at, svg.find('"', at) - at);
  return svg;
}

bool has_bad_number(const Figure& figure) {
  const std::string svg = vector_part(figure.svg);
  return holds(svg, "nan") || holds(svg, "inf,") || holds(svg, ",inf") || holds(svg, "e+");
}

TEST(Figures, EveryOneComesOutWholeInBothWidths) {
  for (const Case& one : all_figures()) {
    for (const double width_mm : {kOneColumnMm, kTwoColumnsMm}) {
      SCOPED_TRACE(one.name + " at " + std::to_string(width_mm) + " mm");
      const auto figure = one.draw({width_mm, 150.0});
      ASSERT_TRUE(figure.ok()) << figure.error().message();
      keep(*figure, width_mm == kOneColumnMm ? "_85mm" : "");
      EXPECT_EQ(figure->name, one.name);
      EXPECT_GT(figure->caption.size(), 20u);
      // 150 dots per inch of 25.4 mm.
      EXPECT_EQ(figure->width_px, static_cast<int>(std::lround(width_mm / 25.4 * 150.0)));
      const auto png = image::decode_image(figure->png, "figure");
      ASSERT_TRUE(png.ok());
      EXPECT_EQ(png->width, figure->width_px);
      EXPECT_EQ(png->height, figure->height_px);
      EXPECT_GT(colours_in(*png), 30u) << "a blank or unsmoothed picture";
      EXPECT_TRUE(figure->svg.starts_with("<?xml"));
      EXPECT_TRUE(holds(figure->svg, width_mm == kOneColumnMm ? "width=\"85.00mm\"" : "width=\"174.00mm\""));
      EXPECT_TRUE(holds(figure->svg, "<title>" + one.name + "</title>"));
      EXPECT_FALSE(has_bad_number(*figure));
      EXPECT_FALSE(holds(figure->svg, "<text"))
          << "text must be drawn as outlines: fonts differ between machines";
      EXPECT_EQ(!figure->data.rows.empty(), one.has_data);
      for (const auto& row : figure->data.rows) EXPECT_EQ(row.size(), figure->data.columns.size());
    }
  }
}

TEST(Figures, SameInputSameBytesWhateverWasDrawnBeforeAndOnWhicheverThread) {
  const auto cases = all_figures();
  std::vector<Figure> first(cases.size()), again(cases.size());
  const FigureOptions small{kOneColumnMm, 100.0};
  for (std::size_t i = 0; i < cases.size(); ++i) first[i] = cases[i].draw(small).value();
  base::parallel_for(cases.size(), 4, [&](std::size_t i) {
    const std::size_t backwards = cases.size() - 1 - i;
    again[backwards] = cases[backwards].draw(small).value();
  });
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SCOPED_TRACE(cases[i].name);
    EXPECT_EQ(base::sha256_hex(first[i].svg), base::sha256_hex(again[i].svg));
    EXPECT_EQ(base::sha256_hex(first[i].png), base::sha256_hex(again[i].png));
    EXPECT_EQ(base::to_csv(first[i].data), base::to_csv(again[i].data));
  }
}

TEST(Figures, CornersTableHoldsTheViewsResidualsAndSaysWhatWasLeftOut) {
  const CornerSample sample;
  const Figure figure = corners_overlay(sample.picture, sample.calibration, sample.telling, 0).value();
  const calib::View& view = sample.calibration.views[2];
  const auto& table = figure.data;
  const auto id = table.column("corner_id"), u = table.column("u_px"),
             projected_u = table.column("projected_u_px"), dv = table.column("residual_v_px"),
             left_out = table.column("left_out");
  ASSERT_TRUE(id && u && projected_u && dv && left_out);
  ASSERT_EQ(table.rows.size(), view.observed_px.size());
  for (std::size_t c = 0; c < table.rows.size(); ++c) {
    EXPECT_EQ(table.rows[c][*id], std::to_string(c + 10));
    EXPECT_NEAR(std::stod(table.rows[c][*u]), view.observed_px[c].x(), 6e-5);
    EXPECT_NEAR(std::stod(table.rows[c][*dv]), view.residual_px[c].y(), 6e-5);
    EXPECT_EQ(table.rows[c][*left_out], c == 4 ? "yes" : "no");
    if (c == 6) continue;
    EXPECT_NEAR(std::stod(table.rows[c][*projected_u]), view.observed_px[c].x() - view.residual_px[c].x(),
                6e-5);
  }
  EXPECT_EQ(table.rows[6][*projected_u], "");
  EXPECT_TRUE(holds(figure.caption, "View 3, boards/left3.jpg: lowest RMS"));
  EXPECT_TRUE(holds(figure.caption, "53 corners, 1 left out"));
  EXPECT_TRUE(holds(figure.caption, "120 times enlarged"));
  const Figure without = corners_overlay(sample.picture, sample.calibration, sample.telling, 1).value();
  EXPECT_TRUE(holds(without.caption, "not used: no board of 9x6 inner corners found"));
}

TEST(Figures, HeightsTableHoldsTheNumbersDrawn) {
  const auto records = samples::flight(5);
  const Figure figure = heights_over_shots(records, 1.7).value();
  const auto& table = figure.data;
  const auto refined = table.column("above_ground_refined_m"), thesis = table.column("above_ground_thesis_m");
  ASSERT_TRUE(refined && thesis && table.column("above_ground_refined_sigma_m") &&
              table.column("height_vps_m"));
  ASSERT_EQ(table.rows.size(), records.size());
  EXPECT_NEAR(std::stod(table.rows[2][*refined]), records[2].above_ground_refined_m.value, 1e-4);
  EXPECT_NEAR(std::stod(table.rows[2][*thesis]), records[2].above_canopy_thesis_m.value + 1.7, 1e-4);
}

TEST(Figures, UnknownRowHeightLeavesTheLogOut) {
  const Figure figure = heights_over_shots(samples::flight(), kNaN).value();
  EXPECT_TRUE(figure.data.column("above_canopy_refined_m").has_value());
  EXPECT_FALSE(figure.data.column("height_takeoff_m").has_value());
  EXPECT_FALSE(figure.data.column("height_vps_m").has_value());
  keep(figure, "_no_row_height");
}

TEST(Figures, WildValuesBecomeArrowsAndAreCounted) {
  auto records = samples::flight();
  for (auto& r : records) r.above_canopy_thesis_m.value = 2.0;
  EXPECT_FALSE(holds(heights_over_shots(records, 1.7)->caption, "beyond"));
  records[3].above_canopy_thesis_m.value = 90.0;
  records[7].above_canopy_thesis_m.value = -90.0;
  EXPECT_TRUE(holds(heights_over_shots(records, 1.7)->caption, "2 values beyond the axis"));
}

TEST(Figures, AnyFlightCanBeDrawn) {
  auto absurd = samples::flight(12);
  absurd[2].height_takeoff_m = 1e300;
  absurd[3].height_takeoff_m = -1e308;
  absurd[4].above_ground_refined_m = {kInf, kInf, 1};
  absurd[5].above_ground_refined_m = {3.0, -1.0, 1};
  absurd[6].cross_track_m = {1e-300, 1e-300, 1};
  auto constant = samples::flight(3);
  for (auto& r : constant) r = constant[0];
  for (const auto& records :
       {std::vector<audit::ShotRecord>{}, std::vector<audit::ShotRecord>(1), samples::flight(1),
        samples::flight(2), constant, absurd, samples::flight(3000)}) {
    SCOPED_TRACE(records.size());
    const FigureOptions small{kOneColumnMm, 72.0};
    for (const double row_height_m : {1.7, kNaN})
      EXPECT_TRUE(heights_over_shots(records, row_height_m, small).ok());
    EXPECT_TRUE(pitch_over_shots(records, small).ok());
    const auto track = cross_track_over_shots(records, small);
    ASSERT_TRUE(track.ok());
    EXPECT_FALSE(has_bad_number(*track));
    const auto legs = heights_by_leg(records, 1.7, small);
    EXPECT_TRUE(legs.ok() || legs.error().code == "nothing_to_draw");
    const auto agreed = agreement(heights_against_log(records), small);
    EXPECT_TRUE(agreed.ok() || agreed.error().code == "nothing_to_draw");
    const auto errors = error_histogram(heights_against_log(records), small);
    EXPECT_TRUE(errors.ok() || errors.error().code == "nothing_to_draw");
  }
  keep(heights_over_shots({}, 1.7).value(), "_empty");
  keep(heights_over_shots(samples::flight(3000), 1.7).value(), "_3000");
  keep(heights_over_shots(samples::flight(2), 1.7).value(), "_2");
}

// Far from 0 the first border of the bins lay over the only error by a rounding, and less than no bin was
// asked for.
TEST(Figures, ErrorsThatAreAllOneFillOneBin) {
  for (const double error : {0.3, 1.2, 1.7e15, 1.3e17}) {
    const Comparison equal{"equal", "height", "m", "refined", "log", {"a", "b"}, {error, error}, {0.0, 0.0}};
    const auto drawn = error_histogram(equal, {kOneColumnMm, 72.0});
    EXPECT_TRUE(drawn.ok()) << error << ": " << drawn.error().message();
  }
}

TEST(Figures, AnyCalibrationCanBeDrawnOrSaysWhyNot) {
  EXPECT_EQ(reprojection_bars({}).error().code, "nothing_to_draw");
  EXPECT_EQ(board_poses({}).error().code, "nothing_to_draw");
  EXPECT_EQ(residual_map({}).error().code, "nothing_to_draw");
  auto calibration = samples::calibration(120);
  keep(reprojection_bars(calibration).value(), "_120");
  keep(board_poses(calibration).value(), "_120");
  calibration.views[0].cam_from_board.translation.x() = kNaN;
  calibration.views[1].mean_error_px = kInf;
  calibration.views[2].image = "<script>&\"\xff\x80";
  EXPECT_TRUE(reprojection_bars(calibration).ok());
  const auto poses = board_poses(calibration);
  ASSERT_TRUE(poses.ok());
  EXPECT_FALSE(has_bad_number(*poses));
}

TEST(Figures, MapsOfACameraTakeWhatThereIsOrSayWhyNot) {
  calib::Calibration none = samples::calibration();
  for (calib::View& view : none.views) view.used = false;
  EXPECT_EQ(residual_histogram(none).error().code, "nothing_to_draw");
  EXPECT_EQ(coverage_map(none).error().code, "nothing_to_draw");
  EXPECT_EQ(distortion_curve({}).error().code, "nothing_to_draw");
  PictureMap map{"map", "q / px", "A map.", 2, 2, 640, 480, {kNaN, kNaN, kInf, kNaN}};
  EXPECT_EQ(picture_map(map).error().code, "nothing_to_draw");
  map.values = {0.0, 0.0, 0.0, kNaN};  // no relief
  const auto flat = picture_map(map);
  ASSERT_TRUE(flat.ok()) << flat.error().message();
  EXPECT_NE(flat->caption.find("White"), std::string::npos);
  EXPECT_EQ(flat->data.rows.size(), 4U);
  map.values = {0.1, 0.2, 1e6, 0.3};
  EXPECT_TRUE(picture_map(map).ok());
}

// A sum over the bins is the count of coordinates: two a corner.
TEST(Figures, HistogramCountsEveryResidualOnce) {
  const calib::Calibration calibration = samples::calibration();
  const auto figure = residual_histogram(calibration);
  ASSERT_TRUE(figure.ok());
  int sum = 0, expected = 0;
  for (const auto& row : figure->data.rows) sum += std::stoi(row[2]);
  for (const calib::View& view : calibration.views)
    expected += view.used ? 2 * static_cast<int>(view.residual_px.size()) : 0;
  EXPECT_EQ(sum, expected);
}

TEST(Figures, OverlayNamesItsFileSafelyAndKeepsHostileTextOut) {
  const auto field = samples::field(320, 180, 20.0);
  const auto figure =
      row_overlay(field.picture, field.lines, "../a<b>&\"\xff$x$\n.jpg", {kOneColumnMm, 100.0});
  ASSERT_TRUE(figure.ok());
  EXPECT_EQ(figure->name, "rows____a_b_____x___jpg");
  EXPECT_TRUE(holds(figure->svg, "&lt;b&gt;&amp;&quot;"));
  EXPECT_FALSE(holds(figure->svg, "\xff"));
}

TEST(Figures, OverlayTakesAnyRowsAndPicture) {
  auto field = samples::field(320, 180, 20.0);
  const FigureOptions small{kOneColumnMm, 100.0};
  rows::RowLines none;
  none.status = "no_rows";
  none.reason = "fewer than two rows stand out from the soil";
  const auto without = row_overlay(samples::field().picture, none, "shot-1");
  ASSERT_TRUE(without.ok());
  EXPECT_TRUE(holds(without->caption, none.reason));
  keep(*without, "_none");
  EXPECT_TRUE(row_overlay(image::make_image(1, 1, 1), none, "dot", small).ok());
  EXPECT_TRUE(row_overlay(image::make_image(4000, 1, 3), none, "line", small).ok());
  EXPECT_TRUE(row_overlay(image::make_image(1, 4000, 3), none, "upright", small).ok());
  EXPECT_EQ(row_overlay({}, none, "empty", small).error().code, "nothing_to_draw");
  EXPECT_EQ(row_overlay(image::make_image(9, 9, 3), field.lines, "other", small).error().code,
            "picture_size_differs");
  field.lines.vanishing_point_px = Eigen::Vector2d(-4000.0, -9000.0);
  field.lines.rows[0].samples[0].centre_px.x() = kNaN;
  field.lines.rows[1].samples[0].centre_px.x() = 1e300;
  field.lines.rows[2].samples.clear();
  const auto far = row_overlay(field.picture, field.lines, "far", small);
  ASSERT_TRUE(far.ok());
  EXPECT_FALSE(has_bad_number(*far));
  keep(*far);
  field.lines.vanishing_point_px = Eigen::Vector2d(kNaN, kInf);
  EXPECT_TRUE(row_overlay(field.picture, field.lines, "lost", small).ok());
}

TEST(Figures, SizesThatCannotBeDrawnAreErrors) {
  const auto records = samples::flight(4);
  EXPECT_EQ(heights_over_shots(records, 1.7, {10.0, 200.0}).error().code, "figure_size");
  EXPECT_EQ(heights_over_shots(records, 1.7, {kNaN, 200.0}).error().code, "figure_size");
  EXPECT_EQ(heights_over_shots(records, 1.7, {174.0, kNaN}).error().code, "figure_size");
  EXPECT_EQ(heights_over_shots(records, 1.7, {174.0, 1e9}).error().code, "figure_too_large");
  const auto print = heights_over_shots(records, 1.7, {174.0, 600.0});
  ASSERT_TRUE(print.ok());
  EXPECT_EQ(print->width_px, 4110);
}

TEST(Figures, PhotographKeepsItsColoursInTheOverlay) {
  // One flat colour: whatever scales, averages or encodes it, it must come out as it went in.
  Image flat = image::make_image(400, 200, 3);
  for (std::size_t i = 0; i < flat.data.size(); i += 3) {
    flat.data[i] = 40;
    flat.data[i + 1] = 120;
    flat.data[i + 2] = 200;
  }
  rows::RowLines none;
  const Figure figure = row_overlay(flat, none, "flat", {kOneColumnMm, 150.0}).value();
  const Image png = image::decode_image(figure.png, "flat").value();
  const std::uint8_t* middle = png.at(png.width / 2, png.width / 4);
  EXPECT_NEAR(middle[0], 40, 1);
  EXPECT_NEAR(middle[1], 120, 1);
  EXPECT_NEAR(middle[2], 200, 1);
  EXPECT_TRUE(holds(figure.svg, "data:image/jpeg;base64,"));
}

TEST(Figures, SayWhenThereIsNoHeightToDraw) {
  const std::vector<audit::ShotRecord> none(3);
  EXPECT_EQ(log_heights_over_shots(none, false).error().code, "nothing_to_draw");
  EXPECT_EQ(log_heights_over_shots(none, true).error().code, "nothing_to_draw");
  EXPECT_EQ(fusion_over_shots(none, {}).error().code, "nothing_to_draw");
  EXPECT_EQ(budget_over_shots({{"a", {}, {}}}).error().code, "nothing_to_draw");
  EXPECT_EQ(plan_over_pitch({}).error().code, "nothing_to_draw");
}

TEST(Figures, WrittenFilesAreTheFigure) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "furrow_figures_test";
  std::filesystem::remove_all(folder);
  const Figure figure = cross_track_over_shots(samples::flight(6), {kOneColumnMm, 100.0}).value();
  ASSERT_TRUE(write_figure(folder, figure).ok());
  EXPECT_EQ(base::read_file(folder / "cross_track_over_shots.png").value(), figure.png);
  EXPECT_EQ(base::read_file(folder / "cross_track_over_shots.svg").value(), figure.svg);
  EXPECT_EQ(base::read_csv(folder / "cross_track_over_shots.csv")->rows.size(), 6u);
  std::filesystem::remove_all(folder);
}

/// The other side of NoRenderer.SaysWhatToInstall: runs where EGL finds no driver.
TEST(NoRenderer, DISABLED_Child) {
  const auto figure = cross_track_over_shots(samples::flight(6));
  ASSERT_FALSE(figure.ok());
  EXPECT_EQ(figure.error().code, "no_renderer");
  EXPECT_TRUE(holds(figure.error().message(), "libegl-mesa0"));
}

TEST(NoRenderer, SaysWhatToInstall) {
  // libglvnd looks for drivers in this folder only.
  const std::string command =
      "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent '" + std::filesystem::read_symlink("/proc/self/exe").string() +
      "' --gtest_also_run_disabled_tests --gtest_filter=NoRenderer.DISABLED_Child > /dev/null 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST(Following, NoPictureNoFigure) {
  EXPECT_EQ(following_over_time({}).error().code, "nothing_to_draw");
  EXPECT_EQ(deviation_by_hand({}).error().code, "nothing_to_draw");
}

TEST(Following, ThePictureOfTheVideoShowsMiddleAndRow) {
  const auto field = samples::field(640, 360, 45.0);
  follow::FollowerOptions in_px;
  in_px.is_metric = false;
  const auto following = follow::follow_step({}, follow::sighting_of(field.lines, 0), in_px);
  const Image shown = following_picture(field.picture, field.lines, following, in_px);
  ASSERT_EQ(shown.width, 640);
  // Green in the middle at the foot of the picture, where no row's line runs.
  const auto* middle = shown.at(320, 300);
  EXPECT_GT(middle[1], middle[0] + 80);
  const Image empty_view = following_picture(field.picture, {}, {}, {});
  EXPECT_EQ(empty_view.data.size(), field.picture.data.size());
}

}  // namespace
}  // namespace furrow::figures
