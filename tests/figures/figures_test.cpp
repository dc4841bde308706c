#include "furrow/figures/figures.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "figures/samples.h"
#include "furrow/base/file.h"

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
}

}  // namespace
}  // namespace furrow::figures
