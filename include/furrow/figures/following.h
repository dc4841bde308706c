#pragma once
#include <string>
#include <vector>

#include "furrow/figures/figures.h"
#include "furrow/follow/follower.h"
#include "furrow/image/image.h"

namespace furrow::figures {

/// A followed row over time, value by value; NaN where nothing was known.
struct FollowingCurves {
  bool is_metric = true;  ///< offsets in m, else px
  std::vector<double> t_s, measured, filtered, filtered_sigma;
  std::vector<double> thesis_steer;  ///< of the thesis's rule, in the same unit where it has one
  std::vector<double> right_mps;     ///< lateral speed asked for; all NaN without guidance
  std::vector<bool> is_hold;
};

/// Offset from the followed row as measured in each picture and filtered with its sigma, the thesis's rule
/// beside it, and below, where there is guidance, the lateral speed asked for. Stretches on hold are shaded.
/// Errors: nothing_to_draw (no picture).
Result<Figure> following_over_time(const FollowingCurves& curves, const FigureOptions& options = {});

/// Deviations read by hand and by a method, over the pictures of one flight.
struct DeviationByHand {
  std::string flight;
  std::string unit;  ///< "m", "cm" or "px"
  std::vector<std::string> pictures;
  std::vector<double> by_hand, thesis, filtered;  ///< NaN where one is missing
};

/// One panel per flight (the thesis's figures 4.9 to 4.11). Errors: nothing_to_draw (no flight).
Result<Figure> deviation_by_hand(const std::vector<DeviationByHand>& flights,
                                 const FigureOptions& options = {});

/// A picture of the overlay video: middle column (green), followed row upright at its place on the middle row
/// as in the thesis (red) and as it was fitted (orange, its neighbours light blue), an arrow of what steering
/// goes by (blue), and what is known in words.
Image following_picture(Image picture, const rows::RowLines& lines, const follow::Following& following,
                        const follow::FollowerOptions& options);

}  // namespace furrow::figures
