#pragma once
#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include "rows/common_model.h"
#include "rows/summed_map.h"

namespace furrow::rows {

/// Profiles across a row reach so far to each side, spacings: to the foot of a wall seen from low.
inline constexpr double kProfileReach = 0.90;
inline constexpr std::size_t kProfileBins = 230;
inline constexpr double kProfileBinWidth = 2.0 * kProfileReach / static_cast<double>(kProfileBins);
inline constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

/// Half the window along the row, in samples, over which levels and the smooth edges are taken: parallel
/// edges keep their place in spacings along a row, in any perspective, so averaging there does not blur them.
inline constexpr int kWindow = 8;

/// Greenness by distance from the row's model centre; kNone outside the picture.
using Profile = std::array<float, kProfileBins>;

/// The model's cuts of all rows of the map; no spacing where the horizon is near or above.
std::vector<Cut> cuts_of(const GreenMap& map, const CommonModel& model);

/// Mean profile over the map's rows that belong to one sample. `cuts` are the model's at the map's rows.
Profile sample_profile(const SummedMap& summed, const std::vector<Cut>& cuts, int k, double v_from,
                       double v_to);

/// For every sample the mean of the profiles in its window; a running sum, so the window's length costs
/// nothing.
std::vector<Profile> window_means(const std::vector<Profile>& profiles);

/// Mean of the lowest (or highest) `part` of the values in an interval of x.
std::optional<float> tail_mean(const Profile& profile, double x_from, double x_to, bool lower, double part);

}  // namespace furrow::rows
