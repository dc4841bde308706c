#include "rows/row_profile.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "furrow/base/whole.h"

namespace furrow::rows {
namespace {

double bin_of(double x) {
  return (x + kProfileReach) / kProfileBinWidth - 0.5;
}

/// Mean over the bins' widths of what several picture rows show. Unseen bins count nothing.
class ProfileSum {
 public:
  /// Takes one row of the map in by its running sum; borders of the bins are at `first + i * width`, px from
  /// the map's left border. Bins are means over their whole width: points would lose edges between them.
  void add(const float* running, int map_width, float first, float width) {
    const float end = static_cast<float>(map_width), per_width = 1.0F / width,
                bins = static_cast<float>(kProfileBins);
    const auto from = static_cast<std::size_t>(std::clamp(std::ceil(-first * per_width), 0.0F, bins));
    const auto to = static_cast<std::size_t>(std::clamp(std::floor((end - first) * per_width), 0.0F, bins));
    if (to <= from) return;
    // In loops of which the first and the last fit vector registers.
    for (std::size_t i = from; i <= to; ++i) {
      const float x = std::min(std::max(first + static_cast<float>(static_cast<int>(i)) * width, 0.0F), end);
      pixel_[i] = static_cast<int>(x);
      sum_to_[i] = x - static_cast<float>(pixel_[i]);
    }
    for (std::size_t i = from; i <= to; ++i) {
      const float* at = running + pixel_[i];
      sum_to_[i] = at[0] + sum_to_[i] * (at[1] - at[0]);
    }
    for (std::size_t i = from; i < to; ++i) sum_[i] += (sum_to_[i + 1] - sum_to_[i]) * per_width;
    ++begun_[from], --begun_[to];
  }
  Profile mean() const {
    Profile mean;
    int count = 0;
    for (std::size_t i = 0; i < kProfileBins; ++i) {
      count += begun_[i];
      mean[i] = count > 0 ? sum_[i] / static_cast<float>(count) : kNone;
    }
    return mean;
  }

 private:
  std::array<float, kProfileBins> sum_{};
  std::array<int, kProfileBins + 1> begun_{};  // rows that show bins from here on; less those that end
  std::array<int, kProfileBins + 1> pixel_;
  std::array<float, kProfileBins + 1> sum_to_;  // at first the part of a pixel
};

}  // namespace

std::vector<Cut> cuts_of(const GreenMap& map, const CommonModel& model) {
  std::vector<Cut> cuts(static_cast<std::size_t>(map.height));
  for (int row = 0; row < map.height; ++row) {
    const double v = map.v_in_picture(row);
    if (model.field().scale(v) > 0.02) cuts[static_cast<std::size_t>(row)] = model.at(v);
  }
  return cuts;
}

Profile sample_profile(const SummedMap& summed, const std::vector<Cut>& cuts, int k, double v_from,
                       double v_to) {
  const GreenMap& map = summed.map();
  ProfileSum sum;
  const int first = base::ceil_between((v_from + 0.5) / map.scale_v - 0.5, 0, map.height - 1);
  const int last = base::floor_between((v_to + 0.5) / map.scale_v - 0.5, first, map.height - 1);
  const int step = last - first >= 5 ? 2 : 1;  // neighbouring rows of a fine map tell the same
  for (int row = first; row <= last; row += step) {
    const Cut& cut = cuts[static_cast<std::size_t>(row)];
    if (!(cut.spacing > 0.0)) continue;
    sum.add(summed.running(row), map.width,
            static_cast<float>((cut.centre + (k - kProfileReach) * cut.spacing + 0.5) / map.scale_u),
            static_cast<float>(kProfileBinWidth * cut.spacing / map.scale_u));
  }
  return sum.mean();
}

std::vector<Profile> window_means(const std::vector<Profile>& profiles) {
  std::vector<Profile> means(profiles.size());
  std::array<float, kProfileBins> sum{}, count{};
  const auto add = [&](const Profile& profile, float sign) {
    for (std::size_t i = 0; i < kProfileBins; ++i) {
      const bool is_seen = !std::isnan(profile[i]);
      sum[i] += is_seen ? sign * profile[i] : 0.0F;
      count[i] += is_seen ? sign : 0.0F;
    }
  };
  for (std::size_t j = 0; j < std::min<std::size_t>(kWindow, profiles.size()); ++j) add(profiles[j], 1.0F);
  for (std::size_t j = 0; j < profiles.size(); ++j) {
    if (j + kWindow < profiles.size()) add(profiles[j + kWindow], 1.0F);
    if (j > kWindow) add(profiles[j - kWindow - 1], -1.0F);
    for (std::size_t i = 0; i < kProfileBins; ++i) means[j][i] = count[i] > 0.0F ? sum[i] / count[i] : kNone;
  }
  return means;
}

std::optional<float> tail_mean(const Profile& profile, double x_from, double x_to, bool lower, double part) {
  std::array<float, kProfileBins> values;
  const auto first = static_cast<std::size_t>(std::clamp(std::ceil(bin_of(x_from)), 0.0, kProfileBins - 1.0));
  const auto last = static_cast<std::size_t>(std::clamp(std::floor(bin_of(x_to)), 0.0, kProfileBins - 1.0));
  std::size_t seen = 0;
  for (std::size_t i = first; i <= last; ++i) {
    values[seen] = profile[i];
    seen += !std::isnan(profile[i]);
  }
  if (seen < 2 || 2 * seen < last - first + 1) return std::nullopt;
  const auto count = static_cast<std::ptrdiff_t>(std::ceil(part * static_cast<double>(seen)));
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(seen),
             last_counted = values.begin() + count - 1;
  if (lower) {
    std::nth_element(values.begin(), last_counted, end);
  } else {
    std::nth_element(values.begin(), last_counted, end, std::greater<>());
  }
  return std::accumulate(values.begin(), last_counted + 1, 0.0F) / static_cast<float>(count);
}

}  // namespace furrow::rows
