#pragma once
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "calib/solve.h"
#include "calib/start.h"
#include "furrow/base/result.h"
#include "furrow/calib/calibrate.h"

namespace furrow::calib {

/// Fewer views than these leave the focal length and the principal point to chance.
inline constexpr std::size_t kFewestViews = 3;
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Everything the rounds of one calibration share.
struct Job {
  const std::vector<target::BoardDetection>& detections;
  target::BoardSpec board;
  CalibrateOptions options;
  int width = 0, height = 0;
};

/// A solution of the views in `order`.
struct Round {
  std::vector<std::size_t> order;
  SharedModel model;
  std::vector<SolveView> views;
  Solved solved;
};
/// Solves the views in `order`, corners that were left out weighing nothing. Errors: solve_failed.
Result<Round> solve_round(const Job& job, const std::vector<std::size_t>& order,
                          const std::vector<View>& views);

/// Error "solve_failed" with its reason and what to do.
Error solve_failed(const std::string& why);

/// Sets the solved camera and poses as the start of what follows.
void take_over(Round& round, const Solved& solved, Camera& camera);

/// Root mean square residual of the views per coordinate, px.
double residual_px(const Round& round);

/// A lens with a formula. First the focal length with two radial coefficients, then Brown-Conrady's, then
/// everything: a rational lens started from nothing finds false minima.
Status solve_formula(const Job& job, const Start& start, Round& round);

/// A splined lens: a fisheye first, which bends to anything radial, then knots that start on its surface.
/// They are free of it but for a prior that speaks where no corner does: there the surface stays near the
/// fisheye's.
Status solve_splined_lens(const Job& job, const Start& start, Round& round);

/// Whether a corner was rejected as an outlier.
bool is_left_out(const View& view, std::size_t corner);

/// Unuses the views whose RMS stands out; whether any did.
bool drop_outlying_views(const Round& round, double ratio, std::vector<View>& views);

/// Leaves out the corners that lie too far from their projections; whether there were new ones. A view keeps
/// at least half of its corners: one that would lose more is bad as a whole, and its corners say nothing
/// about single ones.
bool leave_out_corners(const Round& round, double sigmas, std::vector<View>& views);

/// Writes a solved view's pose and residuals.
void fill_view(const Round& round, std::size_t i, View& view);

/// The last round as a calibration, with its covariances.
Calibration summarize(const Job& job, const Round& round, std::vector<View> views);

}  // namespace furrow::calib
