#include "furrow/figures/figures.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "figures/samples.h"
#include "furrow/base/file.h"
#include "furrow/figures/comparison.h"
#include "furrow/figures/pictures.h"

namespace furrow::figures {
namespace {

/// With FURROW_FIGURES_OUT set, every figure of these tests is left there to be looked at.
void keep(const Figure& figure, const std::string& suffix = "") {
  if (const char* folder = std::getenv("FURROW_FIGURES_OUT")) {
    Figure copy = figure;
    copy.name += suffix;
    ASSERT_TRUE(write_figure(folder, copy).ok());
  }
}

TEST(Figures, Draft) {
  const auto records = samples::flight();
  const auto show = [](const Result<Figure>& figure) {
    ASSERT_TRUE(figure.ok()) << figure.error().message();
    keep(*figure);
  };
  show(heights_over_shots(records, 1.7));
  show(pitch_over_shots(records));
  show(cross_track_over_shots(records));
  show(reprojection_bars(samples::calibration()));
  show(board_poses(samples::calibration()));
  const auto field = samples::field();
  show(row_overlay(field.picture, field.lines, "shot-1003"));
  show(agreement(heights_against_log(records)));
  show(error_histogram(heights_against_truth(records)));
  show(heights_by_leg(records, 1.7));
  show(residual_map(samples::calibration()));
  show(following_overlay(field.picture, {38.0, 22.0}, "shot-1003"));
  std::vector<NamedPicture> steps;
  for (const char* name : {"green mask", "otsu", "filled", "skeleton", "lines"})
    steps.push_back({name, field.picture});
  show(contact_sheet("steps", "Steps of row detection.", steps));
  Figure empty = heights_over_shots({}, 1.7).value();
  empty.name = "empty";
  show(empty);
}

}  // namespace
}  // namespace furrow::figures
